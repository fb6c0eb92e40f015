import numpy as np
import pytest

from stickslip.reservoir import delay_line, EchoStateNetwork, memory_capacity

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
