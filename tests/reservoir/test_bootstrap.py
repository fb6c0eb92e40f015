import warnings

import numpy as np
import pytest
from scipy import stats

from stickslip.reservoir import mean_over_runs, squared_correlation
from stickslip.reservoir.bootstrap import basic_interval, resampled_correlations, squared_interval, usual_block


def test_the_interval_over_runs_is_students():
    values = [-2.0, 0.0, -1.0, 3.0]
    found = mean_over_runs(values, 0.9)
    low, high = stats.t.interval(0.9, 3, loc=0, scale=stats.sem(values))
    assert (found.mean, found.low, found.high, found.runs) == pytest.approx((0, low, high, 4))


def test_scores_of_one_sign_are_skewed_away_from_zero():
    values = np.array([3.0, 5.0, 4.0, 8.0])
    found, turned = mean_over_runs(values, 0.9), mean_over_runs(-values, 0.9)
    low, high = stats.t.interval(0.9, 3, loc=5, scale=stats.sem(values))
    assert found.low == pytest.approx(low)
    spread = stats.t.ppf(0.95, 3) * np.log(values).std(ddof=1) / 2
    assert found.high == pytest.approx(5 * np.exp(spread))
    assert found.high > high
    assert (turned.low, turned.high) == (-found.high, -found.low)


def test_the_interval_over_runs_of_a_bounded_score_stays_in_bounds():
    found = mean_over_runs([0.0, 0.0, 0.0, 0.1], bounds=(0, 1))
    assert (found.low, found.mean) == (0, 0.025)
    assert 0.025 < found.high <= 1
    turned = mean_over_runs([1.0, 1.0, 1.0, 0.9], bounds=(0, 1))
    assert (1 - turned.high, 1 - turned.low) == pytest.approx((found.low, found.high))
    narrow = [10.0, 10.1, 9.9]
    assert mean_over_runs(narrow).high == pytest.approx(10 + stats.t.ppf(0.975, 2) * 0.1 / np.sqrt(3), rel=1e-3)
    with pytest.raises(ValueError, match=r"bounds must hold all values, from -1.0 to 2.0, got \(0, 5\)"):
        mean_over_runs([-1.0, 2.0], bounds=(0, 5))


@pytest.mark.parametrize("bounds", [None, (0, 1), (0, np.inf)])
def test_equal_runs_tell_no_interval(bounds):
    for values in ([0.0, 0.0, 0.0], [0.7] * 5, [1.0, 1.0 - 2e-16]):
        found = mean_over_runs(values, bounds=bounds)
        assert found.mean == pytest.approx(values[0])
        assert np.isnan([found.low, found.high]).all()
    assert mean_over_runs([0.7, 0.7, 0.7 + 1e-9], bounds=bounds).high > 0.7


@pytest.mark.parametrize("runs", [3, 5])
def test_intervals_that_are_given_hold_the_mean_of_a_rare_score(runs):
    """Were equal runs given one, 48% and 67% would hold it; where 950 of 1000 hold it the standard deviation is 7."""
    values = (np.random.default_rng(runs).random((1000, runs)) < 0.2).astype(float)
    found = [mean_over_runs(each, bounds=(0, 1)) for each in values]
    given = [each for each in found if not np.isnan(each.low)]
    assert len(given) < 0.75 * len(found)
    assert sum(each.low <= 0.2 <= each.high for each in given) > 0.95 * len(given) - 4 * 7


@pytest.mark.parametrize("runs", [3, 5, 10])
@pytest.mark.parametrize("law", ["even", "skewed", "mostly small"])
def test_intervals_over_runs_hold_the_mean_as_often_as_they_say(law, runs):
    """Student's holds that of the skewed ones 82% to 90%; 950 of 1000 have standard deviation 7."""
    rng = np.random.default_rng(runs)
    x, mean = {
        "even": (rng.normal(5, 1, (1000, runs)), 5),
        "skewed": (rng.exponential(1, (1000, runs)), 1),
        "mostly small": (rng.gamma(0.5, 1, (1000, runs)), 0.5),
    }[law]
    found = [mean_over_runs(values) for values in x]
    assert sum(each.low <= mean <= each.high for each in found) > 950 - 4 * 7


def test_bad_runs():
    with pytest.raises(ValueError, match="values must hold two runs at least to tell how much they differ, got 1"):
        mean_over_runs([1.0])
    with pytest.raises(ValueError, match=r"confidence must be in \(0, 1\), got 95"):
        mean_over_runs([1.0, 2.0], 95)


def test_a_single_block_of_all_samples_is_the_series_itself():
    """Wherever on the circle it starts."""
    rng = np.random.default_rng(0)
    target = rng.normal(size=(3, 50))
    prediction = target + rng.normal(size=(3, 50)) + 4
    drawn = resampled_correlations(prediction, target, 50, 20, 0)
    np.testing.assert_allclose(drawn**2, np.tile(squared_correlation(prediction.T, target.T), (20, 1)), atol=1e-12)


def test_resamples_are_scored_as_if_they_were_written_out():
    rng = np.random.default_rng(0)
    target = rng.normal(size=(2, 23))
    prediction = target + rng.normal(size=(2, 23))
    drawn = resampled_correlations(prediction, target, 5, 4, seed=3)
    starts = np.random.default_rng(3).integers(0, 23, (4, 5))
    for found, each in zip(drawn, starts, strict=True):
        index = (each[:, None] + np.arange(5)).ravel() % 23
        expected = [np.corrcoef(p[index], t[index])[0, 1] for p, t in zip(prediction, target, strict=True)]
        np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_intervals_hold_the_truth_as_often_as_they_say(memory):
    """Prediction and target of correlation 0.6, both with memory in time: 90 of 100 with standard deviation 3."""
    from scipy.signal import lfilter

    hits = 0
    for seed in range(100):
        rng = np.random.default_rng(seed)
        common, first, second = lfilter([1], [1, -memory], rng.normal(size=(3, 2000)), axis=1)
        a, b = np.sqrt(0.6), np.sqrt(0.4)
        prediction, target = (a * common + b * first)[None], (a * common + b * second)[None]
        drawn = resampled_correlations(prediction, target, 40, 200, seed)
        low, high = squared_interval(drawn, np.corrcoef(prediction[0], target[0])[:1, 1], 0.9, 10**6)[:, 0]
        hits += low < 0.36 < high
    assert 90 - 5 * 3 < hits <= 100


def test_the_interval_of_a_perfect_or_a_missing_correlation():
    drawn = np.tile([1.0, 0.0, -0.3], (50, 1))
    np.testing.assert_allclose(squared_interval(drawn, drawn[0], 0.9, 10**6), [[1, 0, 0], [1, 0, 0]], atol=1e-12)


def test_blocks_span_the_delays_but_leave_blocks_to_draw():
    assert usual_block(8000, [0, 1]) == 20
    assert usual_block(8000, range(50)) == 50
    assert usual_block(100, range(50)) == 10
    assert usual_block(5, [0]) == 1


def test_intervals_of_a_few_blocks_are_students():
    """Of the mean of ten numbers: resampling them alone covers 90%; 1900 of 2000 have standard deviation 10."""
    rng = np.random.default_rng(0)
    hits = 0
    for _ in range(2000):
        x = rng.normal(size=10)
        drawn = x[rng.integers(0, 10, (400, 10))].mean(axis=1)
        low, high = basic_interval(drawn, x.mean(), 0.95, 10)
        hits += low <= 0 <= high
    assert abs(hits - 1900) < 4 * 10


def test_resampled_correlations_know_no_units():
    """A row of any size beside any other, offset and all."""
    rng = np.random.default_rng(0)
    target = rng.normal(size=(3, 40))
    prediction = target + rng.normal(size=(3, 40))
    expected = resampled_correlations(prediction, target, 4, 6, 0)
    sizes, offsets = np.array([[1e-100], [1.0], [1e100]]), np.array([[0.0], [1e6], [0.0]])
    found = resampled_correlations(prediction * sizes + offsets, target * sizes[::-1] - offsets, 4, 6, 0)
    np.testing.assert_allclose(found, expected, atol=1e-7)


def test_what_came_out_constant_has_no_correlation():
    """A message that moves once is constant in most resamples: 0, and no division by its spread."""
    rng = np.random.default_rng(0)
    target = np.concatenate([np.eye(1, 30, 7), rng.normal(size=(1, 30)), np.ones((1, 30))])
    prediction = np.concatenate([rng.normal(size=(1, 30)), np.zeros((1, 30)), rng.normal(size=(1, 30))])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drawn = resampled_correlations(prediction, target, 3, 50, 0)
    assert not drawn[:, 1:].any()
    starts = np.random.default_rng(0).integers(0, 30, (50, 10))
    holds = ((7 - starts) % 30 < 3).any(axis=1)
    assert 0 < holds.sum() < 50
    np.testing.assert_array_equal(abs(drawn[:, 0]) > 1e-6, holds)  # but for rounding
