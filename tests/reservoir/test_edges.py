"""Both sides of the thresholds that decide which way a measure goes, and what it says and returns there."""

import inspect
import warnings

import numpy as np
import plain_reservoir as plain
import pytest

import stickslip.reservoir
from stickslip.reservoir import (
    delay_line,
    echo_state_property,
    information_processing_capacity,
    kernel_quality,
    mean_over_runs,
    memory_capacity,
    memory_over_runs,
    ranks,
    RecursiveLeastSquares,
    RecursiveLeastSquaresReadout,
    RidgeReadout,
    state_rank,
)
from stickslip.reservoir.convergence import _exponent
from stickslip.reservoir.echo_state import _aperiodic_signs, _signs_of_pi
from stickslip.reservoir.orthonormal import of_usual_size, repair, whitening
from stickslip.reservoir.ridge import samples_needed, training_samples

EPS = np.finfo(float).eps


def bits(samples, seed=0):
    return np.random.default_rng(seed).integers(0, 2, samples).astype(float)


def test_the_package_gives_what_it_names_and_nothing_else():
    for name in stickslip.reservoir.__all__:
        assert getattr(stickslip.reservoir, name).__name__ == name
    assert set(stickslip.reservoir.__all__) <= set(dir(stickslip.reservoir))
    with pytest.raises(AttributeError, match=r"^module 'stickslip.reservoir' has no attribute 'octopus'$"):
        stickslip.reservoir.octopus  # noqa: B018


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda x, e: memory_capacity(x[:220], e[:220], 2), "the readout is fitted on 10 samples"),
        (lambda x, e: memory_capacity(x, np.eye(1, 400, 350)[0], 2), "100 scored samples are few"),
        (lambda x, e: information_processing_capacity(x[:220], e[:220], delays=3), "no capacity below"),
        (lambda x, e: information_processing_capacity(x[:250], e[:250], delays=3), "50 samples are few"),
        (lambda x, e: information_processing_capacity(x, e, delays=9, budget=5), "the budget of 5 functions"),
        (lambda x, e: ranks(x[:4], x), "different has 4 inputs"),
        (lambda x, e: echo_state_property(x.reshape(2, 200, 6)), "fewer than 10 samples have distances"),
    ],
)
def test_a_warning_points_to_the_line_that_asked(call, text):
    message, states = bits(400), np.random.default_rng(1).normal(size=(400, 6))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call(states, message)
    found = [each for each in caught if str(each.message).startswith(text)]
    assert [(each.filename, each.lineno) for each in found] == [(__file__, inspect.getsourcelines(call)[1])]


def test_a_message_is_constant_only_if_it_is_so_over_all_that_is_scored():
    states = np.random.default_rng(0).normal(size=(1000, 2))
    early, late = bits(1000), bits(1000)
    early[580:] = 0.5
    late[560:] = 0.5
    late[999] = 1.0
    for message, refused, scored in ((early, 20, 21), (late, 1, 0)):
        with pytest.raises(ValueError, match=f"over the 400 samples that delay {refused} is scored on$"):
            memory_capacity(states, message, [refused])
        memory_capacity(states, message, [scored], significance=0.4)


def test_training_samples_by_hand():
    """Shares that are not exact in binary are the whole numbers that they stand for."""
    assert [training_samples(10, holdout) for holdout in (0.3, 0.7, 0.9, 0.1, 0.25)] == [7, 3, 1, 9, 7]
    assert training_samples(9, 0.5) == 4
    assert [samples_needed(7, holdout) for holdout in (0.3, 0.5, 0.9, 0.1)] == [10, 14, 70, 20]
    assert samples_needed(1, 0.5) == 4


def test_runs_that_differ_by_rounding_alone_are_equal():
    for factor in (1.0, -1e6):
        assert np.isnan(mean_over_runs(factor * np.array([1.0, 1 + 0.8e-13, 1.0])).low)
        assert not np.isnan(mean_over_runs(factor * np.array([1.0, 1 + 1.3e-13, 1.0])).low)


def test_runs_are_combined_with_the_bounds_of_what_they_measure():
    runs = []
    for seed, taps in enumerate((2, 3, 3)):
        e = bits(700, seed)
        line = delay_line(e, taps) + 0.5 * np.random.default_rng(seed).normal(size=(700, taps))
        runs.append(memory_capacity(line, e, 5))
    found = memory_over_runs(runs, 0.8)
    assert found.bound == 3
    assert found.corrected == mean_over_runs([run.corrected for run in runs], 0.8, bounds=(0, 5)).at_most(3)
    for at, low, high, *values in zip(
        found.profile, *found.profile_interval, *(run.profile for run in runs), strict=True
    ):
        expected = mean_over_runs(values, 0.8, bounds=(0, 1))
        np.testing.assert_array_equal([at, low, high], [expected.mean, expected.low, expected.high])
    other = memory_over_runs(runs)
    assert other.total.high - other.total.low > found.total.high - found.total.low
    assert other.total == mean_over_runs([run.total for run in runs], 0.95, bounds=(0, 5))


def test_an_exponent_counts_what_is_close_for_the_first_time():
    """It grows by 2 in the range, leaves it by 30, comes back, and halves there: the return is chance."""
    rise = 1e-4 * 2.0 ** np.arange(6)
    gone = np.array([30 * rise[-1], 0.5, 0.005, 0.0025, 0.00125])
    far = np.full(11, 0.3)
    distance = np.array([np.concatenate([rise, gone]), np.concatenate([rise, gone]) * 1.5, far])
    growth, error = _exponent(distance)
    steps = [np.log(2)] * 5 + [np.log(30)]
    assert growth == pytest.approx(np.mean(steps))
    assert error == pytest.approx(np.std(steps, ddof=1) / np.sqrt(6))
    # Twelve steps are counted here; of nine nothing is told.
    assert np.isnan(_exponent(distance[:1])).all()
    assert _exponent(np.vstack([1e-4 * 2.0 ** np.arange(6)] * 2))[0] == pytest.approx(np.log(2))
    assert np.isnan(_exponent(np.vstack([1e-4 * 2.0 ** np.arange(4)] * 3))).all()
    # What meets to the last digit has no logarithm, and one sample of many pairs no error.
    met = np.vstack([[1e-3, 5e-4, 0.0, 0.0]] * 10)
    assert _exponent(met)[0] == pytest.approx(-np.log(2))
    assert np.isnan(_exponent(met)[1])
    # The range is from rounding to a hundredth, both left out.
    for edge, inside in ((1e-11, 1.001e-11), (0.01, 0.00999)):
        assert np.isnan(_exponent(np.tile([edge, edge / 2, edge], (10, 1)) * [1, 100, 1e6])[0]) == (edge == 0.01)
        assert not np.isnan(_exponent(np.tile([inside, 3 * inside], (10, 1)))[0])
        assert np.isnan(_exponent(np.tile([edge, 0.5], (10, 1)))[0])


@pytest.mark.filterwarnings("ignore:fewer than 10 samples")
def test_features_that_stand_still_tell_nothing_of_meeting():
    rng = np.random.default_rng(0)
    states = rng.normal(size=(3, 50, 2))
    still = np.concatenate([states, np.full((3, 50, 1), 7.0)], axis=2)
    one, other = echo_state_property(states), echo_state_property(still)
    np.testing.assert_allclose(other.distance, one.distance)
    assert other.consistency == pytest.approx(one.consistency)
    half = still.copy()
    half[1:, :, 2] = rng.normal(size=(2, 50))
    assert echo_state_property(half).consistency == pytest.approx(one.consistency)
    apart = np.stack([np.zeros((50, 1)), np.arange(50.0)[:, None]])
    assert np.isnan(echo_state_property(apart).consistency)
    # Two samples after the washout are enough.
    assert echo_state_property(states, washout=48).consistency == pytest.approx(plain_consistency(states[:, 48:]))


def plain_consistency(states):
    pairs = [(0, 1), (0, 2), (1, 2)]
    return np.mean([np.corrcoef(states[i, :, f], states[j, :, f])[0, 1] for i, j in pairs for f in range(2)])


def test_states_of_usual_size_are_left_and_others_brought_to_one():
    for size in (2.0**-299, 1.0, 2.0**299, 0.0):
        for states in (np.array([[size, 0.0]]), np.array([[-size, size / 2]])):
            assert of_usual_size(states) is states
    for size in (2.0**-300, 3 * 2.0**-400, 2.0**300, 5e-324, 1.5 * 2.0**1000):
        for sign in (1, -1):
            states = sign * np.array([[size, -size / 4]])
            found = of_usual_size(states)
            assert 0.5 <= np.abs(found).max() < 1
            ratio = found[0, 0] / states[0, 0] if size > 1e-300 else found[0, 0] * 2.0**-1000 / states[0, 0]
            assert np.frexp(ratio)[0] == 0.5


def test_a_whitening_is_the_inverse_of_cholesky_s_factor():
    x = np.random.default_rng(0).normal(size=(50, 4)) * [1, 1e3, 1e-3, 5]
    white = whitening(x.T @ x)
    np.testing.assert_allclose((x @ white.map).T @ (x @ white.map), np.eye(4), atol=1e-12)
    assert not np.tril(white.map, -1).any()
    unit = x / np.linalg.norm(x, axis=0)
    inverse = np.linalg.inv(np.linalg.cholesky(unit.T @ unit))
    assert white.departure == pytest.approx(4 * EPS * np.sum(inverse**2))
    assert white._replace(departure=0.99e-9).nine_digits
    assert not white._replace(departure=1e-9).nine_digits


def test_columns_are_repaired_up_to_a_half_of_departure():
    for share, repaired in ((0.499, True), (0.501, False)):
        gram = np.eye(3) + share * np.diag([0.6, -0.8, 0])
        triangle = repair(gram)
        assert (triangle is not None) == repaired
        if repaired:
            np.testing.assert_allclose(triangle.T @ triangle, gram)
    assert repair(np.full((2, 2), np.nan)) is None


def test_a_direction_counts_from_a_hundred_roundings():
    rng = np.random.default_rng(0)
    basis = np.linalg.qr(rng.normal(size=(400, 3)) - rng.normal(size=3))[0]
    basis -= basis.mean(axis=0)
    one, other = basis[:, 0] / np.linalg.norm(basis[:, 0]), basis[:, 1] / np.linalg.norm(basis[:, 1])
    for roundings, rank in ((60, 1), (170, 2)):
        # Of two nearly equal columns the lesser singular value is a half of their difference's norm, times root 2.
        small = roundings * EPS * np.sqrt(2) * other
        assert state_rank(np.column_stack([one, one + small])) == rank


def test_ranks_of_what_never_moves_with_noise():
    found = ranks(np.ones((5, 3)), np.zeros((5, 3)), noise=20.0)
    assert (found.kernel_rank, found.generalisation_rank, found.threshold) == (0, 0, pytest.approx(0.1))
    assert ranks(np.ones((5, 3)), np.zeros((2, 5, 3)), threshold=0.2).threshold == 0.2


@pytest.mark.parametrize("nodes", [3, 6, 10, 24, 60])
def test_the_signs_of_a_cycle_begin_at_the_first_digit_that_will_do(nodes):
    digits = _signs_of_pi(nodes + 60)
    turns = np.exp(-2j * np.pi * np.outer(np.arange(nodes), np.arange(nodes)) / nodes)
    first = next(k for k in range(60) if np.abs(turns @ digits[k : k + nodes]).min() > 0.05)
    np.testing.assert_array_equal(_aperiodic_signs(nodes), digits[first : first + nodes])


def test_as_many_shuffles_as_the_significance_needs_and_twenty_at_least():
    u = bits(300)
    states = np.random.default_rng(1).standard_t(3, size=(300, 3)) + u[:, None]
    usual = {"threshold": "surrogates", "max_degree": 1, "washout": 40, "patience": None}
    for delays, significance, shuffles in ((5, 0.01, 200), (60, 0.05, 20), (5, 1e-6, 2000), (30, 0.01, 34)):
        asked = usual | {"delays": delays, "significance": significance}
        one, other = (information_processing_capacity(states, u, **asked, surrogates=each) for each in (None, shuffles))
        assert one.thresholds == other.thresholds
        with pytest.raises(ValueError, match=r"^surrogates must be "):
            information_processing_capacity(states, u, **asked, surrogates=min(shuffles, 17) - 1)


def test_five_hundred_functions_of_a_degree_are_pooled():
    rare = (np.random.default_rng(0).random(300) < 0.15).astype(float)
    states = np.random.default_rng(1).standard_t(2, size=(300, 2)) + rare[:, None]
    arguments = {"threshold": "surrogates", "max_degree": 2, "delays": [40, 34], "washout": 40, "significance": 0.03}
    found = information_processing_capacity(states, rare, **arguments, surrogates=25, patience=1)
    assert sum(range(34)) > 500
    expected = plain.information(states, rare, **arguments, surrogates=25, patience=1)
    assert found.thresholds == pytest.approx(expected["thresholds"])
    assert found.thresholds[2] > found.thresholds[1]


def test_what_is_exact_has_an_interval_of_no_length():
    z = 2 * bits(800) - 1
    found = information_processing_capacity(delay_line(z, 3), z, delays=5)
    np.testing.assert_allclose(found.capacity_interval, 1, atol=1e-9)
    assert found.total_interval == pytest.approx((3, 3), abs=1e-6)
    assert found.by_degree() == pytest.approx({1: 3, 2: 0, 3: 0}, abs=1e-9)
    assert {degree: len(each) for degree, each in found.profile().items()} == {1: 5, 2: 5, 3: 5}


def test_the_error_of_leaving_one_out_is_that_of_leaving_one_out():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(20, 3)) + 1
    y = x @ rng.normal(size=(3, 2)) + rng.normal(size=(20, 2)) + 2
    for intercept in (True, False):
        centred = x - x.mean(axis=0) * intercept
        readout = RidgeReadout([0.1, 2.0], fit_intercept=intercept).fit(x, y)
        for penalty, errors in zip((0.1, 2.0), readout.leave_one_out_error_, strict=True):
            alpha = penalty * np.sum(centred**2) / 3
            missed = []
            for k in range(20):
                rest, target = np.delete(x, k, 0), np.delete(y, k, 0)
                at, level = rest.mean(axis=0) * intercept, target.mean(axis=0) * intercept
                gram = (rest - at).T @ (rest - at) + alpha * np.eye(3)
                missed.append(y[k] - level - (x[k] - at) @ np.linalg.solve(gram, (rest - at).T @ (target - level)))
            np.testing.assert_allclose(errors, np.mean(np.square(missed), axis=0))
        best = np.argmin(readout.leave_one_out_error_.sum(axis=1))
        assert readout.penalty_ == [0.1, 2.0][best]


def test_nothing_is_learned_from_nothing():
    readout = RecursiveLeastSquaresReadout().fit(np.zeros((4, 2)), np.ones(4))
    assert not readout.coef_.any()
    assert 0 < readout.intercept_ < 1
    single = RecursiveLeastSquares(2, 3, ridge=0.5)
    np.testing.assert_array_equal(single.covariance, 2 * np.eye(2))
    np.testing.assert_array_equal(single.learn([0.0, 0.0], [1.0, 2.0, 3.0]), np.zeros(3))
    assert single.scale is None
    single.learn([3.0, 4.0], [1.0, 2.0, 3.0])
    assert single.scale == pytest.approx(np.sqrt(12.5))
    scaled = RecursiveLeastSquares(2, 1, ridge=0.5, scale=2.0)
    np.testing.assert_array_equal(scaled.covariance, np.eye(2) / 2)


def test_a_kernel_is_measured_at_its_least():
    seed = next(seed for seed in range(20) if np.ptp(np.random.default_rng(seed).integers(0, 2, (2, 2, 1))[0]))
    found = kernel_quality(lambda u: delay_line(u, 1), inputs=2, length=1, shared=0, endings=1, seed=seed)
    assert found.kernel_singular_values.shape == (1,)
    assert found.generalisation_singular_values.shape == (1, 1)


def test_a_large_offset_costs_ranks_no_more_than_its_own_digits():
    """Singular values of states that are exact beside it are right to their last digits."""
    rng = np.random.default_rng(0)
    different, similar = np.round(rng.normal(size=(2, 30, 3)) * 1000)
    one, other = ranks(different, similar), ranks(different + 2.0**50, similar + 2.0**50)
    np.testing.assert_allclose(other.kernel_singular_values, one.kernel_singular_values, rtol=1e-12)
    np.testing.assert_allclose(other.generalisation_singular_values, one.generalisation_singular_values, rtol=1e-12)
