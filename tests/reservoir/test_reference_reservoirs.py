import mpmath
import numpy as np
import pytest

from stickslip.reservoir import delay_line, echo_state, EchoStateNetwork, memory_capacity
from stickslip.reservoir.echo_state import _aperiodic_signs, _signs_of_pi

BITS = np.random.default_rng(0).integers(0, 2, 2000).astype(float)


def test_delay_line_by_hand():
    np.testing.assert_array_equal(delay_line([1, 2, 3], 2), [[1, 0], [2, 1], [3, 2]])
    np.testing.assert_array_equal(delay_line([1, 2], 4), [[1, 0, 0, 0], [2, 1, 0, 0]])


def test_delay_line_is_a_copy():
    states = delay_line(BITS, 3)
    states[0] = 9
    assert BITS.max() == 1


def test_a_network_is_its_equation():
    network = EchoStateNetwork(5, leak=0.4, density=0.7, seed=3)
    recurrent, inward, bias = network._weights()
    states = network.states(BITS[:50])
    assert np.abs(np.linalg.eigvals(recurrent)).max() == pytest.approx(0.9)
    before = np.vstack([np.zeros(5), states[:-1]])
    renewed = np.tanh(before @ recurrent.T + np.outer(BITS[:50], inward) + bias)
    np.testing.assert_allclose(states, 0.6 * before + 0.4 * renewed, atol=1e-14)


def drawn_weights(nodes, spectral_radius, input_scaling, density, seed, topology):
    """Of a network with random weights, from the generator that its seed and size say."""
    random = np.random.default_rng([seed, nodes])
    matrix = random.standard_normal((nodes, nodes))
    if topology == "random":
        matrix = np.where(random.random((nodes, nodes)) < density, matrix, 0)
        matrix = matrix / max(abs(np.linalg.eigvals(matrix)))
    inward = random.uniform(-input_scaling, input_scaling, nodes)
    bias = random.uniform(-input_scaling, input_scaling, nodes)
    if topology == "orthogonal":
        # The Gram-Schmidt process gives the one decomposition with a positive diagonal.
        columns = []
        for column in matrix.T:
            left = column - sum((each * (each @ column) for each in columns), np.zeros(nodes))
            columns.append(left / np.linalg.norm(left))
        matrix = np.transpose(columns)
    return spectral_radius * matrix, inward, bias


USUAL = {
    "nodes": 6,
    "spectral_radius": 0.9,
    "input_scaling": 0.1,
    "leak": 1.0,
    "density": 1.0,
    "seed": 0,
    "topology": "random",
}


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"nodes": 7},
        {"spectral_radius": 1.7},
        {"input_scaling": 2.0},
        {"leak": 0.3},
        {"density": 0.4},
        {"seed": 5},
        {"topology": "orthogonal"},
        {"topology": "orthogonal", "seed": 1, "spectral_radius": 0.5},
    ],
)
def test_every_attribute_of_a_network_has_its_effect(change):
    asked = USUAL | change
    states = EchoStateNetwork(6, **{name: value for name, value in change.items() if name != "nodes"}).states(BITS[:40])
    if "nodes" in change:
        states = EchoStateNetwork(**change).states(BITS[:40])
    recurrent, inward, bias = drawn_weights(**{name: value for name, value in asked.items() if name != "leak"})
    state = np.zeros(asked["nodes"])
    for k, u in enumerate(BITS[:40]):
        state = (1 - asked["leak"]) * state + asked["leak"] * np.tanh(recurrent @ state + inward * u + bias)
        np.testing.assert_allclose(states[k], state, rtol=0, atol=1e-13)
    usual = EchoStateNetwork(6).states(BITS[:40])
    assert not change or states.shape != usual.shape or np.abs(states - usual).max() > 1e-3


def test_a_long_series_is_followed_in_pieces(monkeypatch):
    """Interrupts are heard between them; a piece ends wherever it ends, and one sample is the least."""
    network = EchoStateNetwork(5, leak=0.5)
    whole = network.states(BITS[:100])
    for products in (25 * 7, 25, 1):
        monkeypatch.setattr(echo_state, "_PRODUCTS_OF_A_CALL", products)
        np.testing.assert_array_equal(network.states(BITS[:100]), whole)


def test_a_cycle_is_its_equation():
    """Each node feeds the next. Signs by the digits 14159 of pi; no bias."""
    network = EchoStateNetwork(5, spectral_radius=0.8, input_scaling=0.3, topology="cycle", seed=4)
    states = network.states(BITS[:50])
    before = np.vstack([np.zeros(5), states[:-1]])
    signs = np.array([-1, -1, -1, 1, 1])
    expected = np.tanh(0.8 * np.roll(before, 1, axis=1) + 0.3 * np.outer(BITS[:50], signs))
    np.testing.assert_allclose(states, expected, atol=1e-14)
    np.testing.assert_array_equal(states, EchoStateNetwork(5, 0.8, 0.3, topology="cycle", seed=5).states(BITS[:50]))


def test_signs_are_never_singular():
    """At 6 nodes the digits 141592 would be: their alternating sum is 0."""
    alternating = (-1.0) ** np.arange(6)
    assert _signs_of_pi(6) @ alternating == 0
    for nodes in range(3, 130):
        assert np.abs(np.fft.fft(_aperiodic_signs(nodes))).min() > 0.01
    np.testing.assert_array_equal(_aperiodic_signs(12), _signs_of_pi(12))


def test_the_digits_of_pi():
    with mpmath.workdps(420):
        digits = str(mpmath.pi)[2:402]
    np.testing.assert_array_equal(_signs_of_pi(400) > 0, np.array([int(digit) >= 5 for digit in digits]))


@pytest.mark.parametrize("radius", [0.8, 0.95])
def test_a_linear_cycle_has_the_memory_that_theory_gives_it(radius):
    """Rodan and Tino (2011): r^(2 j N) (1 - r^(2 N)) of the input j N + i samples ago, and N in all."""
    nodes, series = 6, np.random.default_rng(0).uniform(-1, 1, 60_000)
    network = EchoStateNetwork(nodes, radius, 1e-4, topology="cycle")
    memory = memory_capacity(network.states(series), series, 60, ridge=1e-14)
    rounds = np.arange(60) // nodes
    expected = radius ** (2 * rounds * nodes) * (1 - radius ** (2 * nodes))
    np.testing.assert_allclose(memory.profile, expected, atol=0.03)
    assert memory.total == pytest.approx(nodes, rel=0.02)


def test_a_cycle_of_sixty_remembers_all_of_forty():
    series = np.random.default_rng(0).uniform(-1, 1, 6000)
    memory = memory_capacity(EchoStateNetwork(60, 0.9, 0.01, topology="cycle").states(series), series, 40)
    assert memory.corrected == pytest.approx(40, abs=0.03)


def test_an_orthogonal_network_is_orthogonal_and_remembers_all_it_can():
    network = EchoStateNetwork(20, 0.9, 1e-4, topology="orthogonal", seed=2)
    recurrent, _, _ = network._weights()
    np.testing.assert_allclose(recurrent @ recurrent.T, 0.81 * np.eye(20), atol=1e-12)
    series = np.random.default_rng(1).uniform(-1, 1, 40_000)
    memory = memory_capacity(network.states(series), series, 150, ridge=1e-14)
    assert memory.total == pytest.approx(20, rel=0.03)


def test_equal_networks_agree_and_seeds_differ():
    states = EchoStateNetwork(10, seed=1).states(BITS)
    np.testing.assert_array_equal(states, EchoStateNetwork(10, seed=1).states(BITS))
    assert np.abs(states - EchoStateNetwork(10, seed=2).states(BITS)).max() > 0.01


def test_the_echo_state_property():
    """Whatever came before, the same input leads to the same state."""
    other = BITS.copy()
    other[:100] = 1 - other[:100]
    network = EchoStateNetwork(30)
    difference = np.abs(network.states(BITS) - network.states(other)).max(axis=1)
    assert difference[99] > 1e-3
    assert difference[400:].max() < 1e-12


def test_the_default_network_remembers_and_stays_within_its_nodes():
    memory = memory_capacity(EchoStateNetwork(12).states(BITS), BITS, 40)
    assert 7 < memory.corrected < memory.bound == 12


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"nodes": 0}, "nodes must be a whole number >= 1, got 0"),
        ({"spectral_radius": -0.1}, r"spectral_radius must be in \[0, inf\), got -0.1"),
        ({"input_scaling": 0.0}, r"input_scaling must be in \(0, inf\), got 0.0"),
        ({"leak": 0.0}, r"leak must be in \(0, 1\], got 0.0"),
        ({"density": 1.5}, r"density must be in \(0, 1\], got 1.5"),
        ({"seed": -1}, "seed must be a whole number >= 0, got -1"),
        ({"topology": "star"}, "topology has no 'star'"),
        ({"topology": "cycle", "density": 0.5}, "density must be 1 unless the topology is random, got 0.5"),
    ],
)
def test_bad_network(arguments, message):
    with pytest.raises(ValueError, match=message):
        EchoStateNetwork(**{"nodes": 4, **arguments})


def test_a_network_without_a_cycle_is_refused():
    with pytest.raises(ValueError, match="density must be larger for 4 nodes to form a cycle, got 1e-09"):
        EchoStateNetwork(4, density=1e-9).states(BITS)


def test_bad_signals():
    with pytest.raises(ValueError, match=r"signal must be 1-dimensional and not empty, got shape \(2, 1\)"):
        delay_line([[1.0], [2.0]], 2)
    with pytest.raises(ValueError, match="taps must be a whole number >= 1, got 0"):
        delay_line(BITS, 0)
    with pytest.raises(ValueError, match=r"signal must be finite, got inf at index \(1,\)"):
        EchoStateNetwork(3).states([0.0, np.inf])
