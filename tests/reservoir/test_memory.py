import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from stickslip.reservoir import delay_line, memory_capacity


def message(samples, seed=0):
    return np.random.default_rng(seed).integers(0, 2, samples) - 0.5


@pytest.mark.parametrize("taps", [1, 5, 20])
def test_a_delay_line_remembers_as_many_steps_as_it_has_taps(taps):
    e = message(4000)
    memory = memory_capacity(delay_line(e, taps), e, 30)
    np.testing.assert_allclose(memory.profile[:taps], 1, atol=1e-9)
    assert memory.bound == taps
    assert memory.corrected == pytest.approx(taps, abs=1e-8)
    assert memory.total - memory.corrected < 30 * 5 / 1900


@pytest.mark.parametrize("features", [1, 12, 100])
def test_noise_remembers_nothing(features):
    """The naive in-sample total would be delays * features / samples, here up to 1."""
    noise = np.random.default_rng(1).normal(size=(4000, features))
    memory = memory_capacity(noise, message(4000), 40)
    assert memory.corrected == 0
    assert memory.total < 0.03
    assert memory.bound == features


def test_chance_passes_the_cutoff_as_often_as_the_significance_says():
    """Binomial: 4000 delays at p = 0.05 give 200 with standard deviation 14."""
    noise = np.random.default_rng(2).normal(size=(8000, 10))
    memory = memory_capacity(noise, message(8000), 4000, holdout=0.3, significance=0.05)
    assert abs((memory.profile > memory.cutoff).sum() - 200) < 5 * 14


@pytest.mark.parametrize("pole", [0.3, 0.9])
def test_a_leaky_integrator_forgets_geometrically(pole):
    """X(k) = a x(k-1) + e(k) has MC_d = (1 - a^2) a^(2 d), which sums to 1."""
    e = message(100_000)
    memory = memory_capacity(lfilter([1], [1, -pole], e)[:, None], e, 60)
    exact = (1 - pole**2) * pole ** (2 * np.arange(60))
    # The standard error of a correlation is 1 / sqrt(test samples), and of its square 2 rho times that.
    assert (np.abs(memory.profile - exact) < 5 * 2 * np.sqrt(exact / 5e4) + 25 / 5e4).all()
    assert memory.corrected == pytest.approx(1, abs=0.05)


def test_distinct_linear_modes_remember_as_much_as_there_are_of_them():
    e = message(50_000)
    states = np.column_stack([lfilter([1], [1, -pole], e) for pole in (0.2, -0.5, 0.8)])
    memory = memory_capacity(states, e, 60)
    assert memory.bound == 3
    assert memory.corrected == pytest.approx(3, abs=0.06)


def test_neither_units_nor_offset_nor_copies_of_a_state_matter():
    e = message(3000)
    states = delay_line(e, 4) @ np.random.default_rng(3).normal(size=(4, 3))
    reference = memory_capacity(states, e, 8)
    copied = memory_capacity(np.column_stack([1e2 * states + 7, states]), 3 * e + 5, 8)
    assert copied.bound == reference.bound == 3
    np.testing.assert_allclose(copied.profile, reference.profile, atol=1e-6)


def test_an_offset_matters_without_intercept():
    """Cancelling noise and cancelling offset ask for different weights: 0.25 / (0.25 + 0.16) is left."""
    e = message(20_000)
    noise = np.random.default_rng(4).normal(size=20_000)
    states = np.column_stack([e + noise + 1, noise + 2])
    assert memory_capacity(states, e, 1).total == pytest.approx(1)
    assert memory_capacity(states, e, 1, fit_intercept=False).total == pytest.approx(0.61, abs=0.03)


@settings(max_examples=40, deadline=None)
@given(
    st.integers(1, 6),
    st.lists(st.integers(0, 30), min_size=1, max_size=8, unique=True),
    st.integers(0, 60),
    st.floats(0.2, 0.8),
    st.integers(0, 2**32 - 1),
)
def test_delays_are_scored_one_by_one_whatever_their_order(taps, delays, washout, holdout, seed):
    e = message(600, seed)
    memory = memory_capacity(delay_line(e, taps), e, delays, washout=washout, holdout=holdout)
    assert memory.delays.tolist() == delays
    np.testing.assert_allclose(memory.profile[np.array(delays) < taps], 1, atol=1e-9)
    assert (memory.profile[np.array(delays) >= taps] < 0.5).all()


def test_a_state_that_never_moves_remembers_nothing():
    memory = memory_capacity(np.full((1000, 3), 0.1), message(1000), 10)
    assert memory.total < 1e-9
    assert (memory.corrected, memory.bound) == (0, 0)


@pytest.mark.parametrize(
    ("change", "error", "text"),
    [
        (
            {"states": np.zeros(500)},
            ValueError,
            r"states must be 2-dimensional .* got shape \(500,\)",
        ),
        (
            {"message": message(499)},
            ValueError,
            "message must have as many samples as states, 500, got 499",
        ),
        ({"message": np.full(500, 0.5)}, ValueError, "message must vary, .* got 0.5 throughout"),
        ({"message": np.full(500, np.nan)}, ValueError, r"message must be finite, got nan at index \(0,\)"),
        ({"delays": 0}, ValueError, "delays must be a whole number >= 1, got 0"),
        ({"delays": 2.5}, TypeError, "delays must be a whole number >= 1, got 2.5"),
        ({"delays": [0, -1]}, ValueError, "delays must be a whole number >= 0, got -1"),
        (
            {"delays": [3, 3]},
            ValueError,
            r"delays must hold at least one delay and none twice, got \[3, 3\]",
        ),
        ({"delays": []}, ValueError, r"delays must hold at least one delay and none twice, got \[\]"),
        ({"washout": -1}, ValueError, "washout must be a whole number >= 0, got -1"),
        ({"holdout": 1.0}, ValueError, r"holdout must be in \(0, 1\), got 1.0"),
        ({"significance": 0}, ValueError, r"significance must be in \(0, 0.5\), got 0"),
        (
            {"washout": 485},
            ValueError,
            "states must have at least 501 samples for 8 features, washout=485, .* got 500",
        ),
        ({"delays": [490]}, ValueError, "at least 506 samples .* delays up to 490 and holdout=0.5, got 500"),
    ],
)
def test_bad_input(change, error, text):
    good = {"states": np.random.default_rng(0).normal(size=(500, 8)), "message": message(500), "delays": 5}
    memory_capacity(**good)
    with pytest.raises(error, match=text):
        memory_capacity(**{**good, **change})
