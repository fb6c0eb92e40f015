import warnings

import numpy as np
import pytest

from stickslip.reservoir import echo_state_property, EchoStateNetwork


def trajectories(step, starts, drive):
    states = np.empty((len(starts), len(drive), np.shape(starts)[1]))
    now = np.array(starts, dtype=float)
    for k, u in enumerate(drive):
        now = step(now, u)
        states[:, k] = now
    return states


def drive(samples, seed=0):
    return np.random.default_rng(seed).normal(size=samples)


@pytest.mark.parametrize("poles", [(0.9,), (0.8, 0.5, -0.3)])
def test_a_linear_system_forgets_at_the_rate_of_its_slowest_pole(poles):
    """Turned by an orthogonal matrix, so that no feature is a mode."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(len(poles), len(poles))))[0]
    system = turn @ np.diag(poles) @ turn.T
    starts = np.random.default_rng(2).normal(size=(4, len(poles)))
    found = echo_state_property(trajectories(lambda x, u: x @ system.T + u, starts, drive(400)), washout=200)
    assert found.echo_index == 1
    assert found.exponent == pytest.approx(np.log(max(poles)), abs=0.02)
    assert found.consistency == pytest.approx(1, abs=1e-12)
    assert found.distance[-1] < 1e-9


def test_the_exponent_is_the_mean_logarithm_of_the_derivative_along_the_trajectory():
    def step(x, u):
        return np.tanh(0.9 * x + 0.3 * u)

    u = drive(300)
    states = trajectories(step, [[0.5], [-0.5]], u)
    found = echo_state_property(states)
    before = np.concatenate([[0.5], states[0, :-1, 0]])
    rate = np.log(0.9 * (1 - np.tanh(0.9 * before + 0.3 * u) ** 2))
    # Over the samples in which the two are apart but close.
    apart = np.abs(states[1, :, 0] - states[0, :, 0]) / states.std()
    counted = (apart[:-1] < 0.01) & (apart[:-1] > 1e-11)
    assert found.exponent == pytest.approx(rate[1:][counted].mean(), abs=0.01)
    assert 0 < found.exponent_error < 0.1


def test_chaos_is_measured_from_neighbours():
    """The logistic map at 4 has exponent ln 2."""
    starts = [[0.3]] + [[0.3 + d * 1e-10] for d in range(1, 30)]
    found = echo_state_property(trajectories(lambda x, u: 4 * x * (1 - x), starts, drive(2000)), washout=100)
    assert found.exponent == pytest.approx(np.log(2), abs=3 * found.exponent_error)
    assert found.exponent_error < 0.2
    # Two of the thirty may be near each other by chance.
    assert found.echo_index > 25
    assert found.consistency < 0.2


def test_two_attractors_are_counted():
    starts = [[-2.0], [-0.5], [0.7], [1.5]]
    with pytest.warns(UserWarning, match="no Lyapunov exponent"):
        found = echo_state_property(trajectories(lambda x, u: np.tanh(3 * x + 0.1 * u), starts, drive(300)))
    assert np.isnan(found.exponent)
    assert found.echo_index == 2
    assert found.distance[-1] > 1


def test_a_network_within_its_radius_has_the_property():
    network = EchoStateNetwork(20, spectral_radius=0.8)
    recurrent, inward, bias = network._weights()
    starts = np.random.default_rng(0).uniform(-1, 1, (5, 20))
    states = trajectories(lambda x, u: np.tanh(x @ recurrent.T + inward * u + bias), starts, drive(300))
    found = echo_state_property(states, washout=100)
    assert found.echo_index == 1
    assert found.consistency == pytest.approx(1, abs=1e-6)
    assert np.log(0.5) < found.exponent < 0
    # Units, offsets and copies of features change nothing.
    other = echo_state_property(np.concatenate([1e3 * states + 5, states * 2], axis=2), washout=100)
    assert other.exponent == pytest.approx(found.exponent, rel=0.02)
    assert other.consistency == pytest.approx(found.consistency)


def test_consistency_is_the_mean_correlation_of_pairs():
    rng = np.random.default_rng(0)
    states = rng.normal(size=(4, 200, 2)) + 0.5 * rng.normal(size=(200, 2))
    with pytest.warns(UserWarning, match="no Lyapunov exponent"):
        found = echo_state_property(states, washout=50)
    pairs = [
        np.corrcoef(states[i, 50:, f], states[j, 50:, f])[0, 1] for f in range(2) for i in range(4) for j in range(i)
    ]
    assert found.consistency == pytest.approx(np.mean(pairs), abs=1e-12)


def test_a_tolerance_is_in_units_of_the_spread():
    base = drive(100)
    states = np.stack([base, base + 0.01])[:, :, None] * 1e3
    with pytest.warns(UserWarning, match="no Lyapunov exponent"):
        assert echo_state_property(states, tolerance=0.1).echo_index == 1
    with pytest.warns(UserWarning, match="no Lyapunov exponent"):
        assert echo_state_property(states, tolerance=0.001).echo_index == 2


def test_bad_input():
    states = np.random.default_rng(0).normal(size=(2, 10, 1))
    with pytest.raises(ValueError, match=r"states must be 3-dimensional and not empty, got shape \(10, 1\)"):
        echo_state_property(states[0])
    with pytest.raises(ValueError, match="states must hold two starts at least, got 1"):
        echo_state_property(states[:1])
    with pytest.raises(ValueError, match="states must have at least 11 samples for washout=9, got 10"):
        echo_state_property(states, washout=9)
    with pytest.raises(ValueError, match=r"states must move, .* got constants throughout"):
        echo_state_property(np.full((2, 10, 1), 0.1))
    with pytest.raises(ValueError, match=r"tolerance must be in \(0, inf\), got 0"):
        echo_state_property(states, tolerance=0)


def test_what_cannot_be_told_is_not_computed():
    """An error of one sample and a consistency of what stands still are NaN without a division by zero."""
    near = np.concatenate([np.zeros((1, 1)), np.linspace(1e-3, 2e-3, 12)[:, None]])
    states = np.concatenate([near, 50 * near, 50 * near], axis=1)
    states[:, 1:] += np.array([1.0, -1.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = echo_state_property(states[:, :, None])
        still = echo_state_property(np.stack([np.zeros((50, 1)), 0.5 ** np.arange(50.0)[:, None]]))
    assert found.exponent == pytest.approx(np.log(50))
    assert np.isnan(found.exponent_error)
    assert np.isnan(still.consistency)
    assert still.exponent == pytest.approx(-np.log(2))
