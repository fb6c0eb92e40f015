import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.reservoir import fit_readout, RecursiveLeastSquares


def stream(samples, features, outputs, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(samples, features)), rng.normal(size=(samples, outputs))


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 8), st.integers(1, 4), st.floats(1e-2, 1e2), st.integers(0, 2**32 - 1))
def test_after_any_prefix_it_is_the_batch_ridge_solution(features, outputs, ridge, seed):
    x, y = stream(40, features, outputs, seed)
    readout = RecursiveLeastSquares(features, outputs, ridge=ridge)
    for k in range(40):
        readout.learn(x[k], y[k])
        seen = x[: k + 1]
        relative = ridge * np.sum(x[0] ** 2) / np.sum(seen**2)
        batch = fit_readout(seen, y[: k + 1], ridge=relative, fit_intercept=False)
        np.testing.assert_allclose(readout.weights, np.atleast_2d(batch.coef_), rtol=0, atol=1e-9)


def test_a_first_row_with_a_zero_in_it_is_learned_and_one_of_zeros_is_not():
    x, y = np.array([[0.0, 0.0], [0.0, 2.0], [3.0, 1.0]]), np.array([[5.0], [7.0], [-1.0]])
    readout = RecursiveLeastSquares(2, 1, ridge=0.5)
    readout.learn(x[0], y[0])
    np.testing.assert_array_equal(readout.weights, 0)
    for k in (1, 2):
        readout.learn(x[k], y[k])
        gram = x[: k + 1].T @ x[: k + 1] + 0.5 * 2.0 * np.eye(2)  # the mean square of the first row is 2
        np.testing.assert_allclose(readout.weights[0], np.linalg.solve(gram, x[: k + 1].T @ y[: k + 1, 0]), rtol=1e-12)


def test_forgetting_weighs_samples_geometrically_and_keeps_the_penalty():
    x, y = stream(50, 3, 2)
    readout = RecursiveLeastSquares(3, 2, ridge=0.5, forgetting=0.9, scale=2.0)
    for row, target in zip(x, y, strict=True):
        readout.learn(row, target)
    weight = 0.9 ** np.arange(49, -1, -1)
    renewed = [weight[feature::3].sum() * 0.1 * 3 for feature in range(3)]
    assert np.abs(np.add(renewed, 0.9**50) - 1).max() < 0.15
    gram = (x * weight[:, None]).T @ x + 0.5 * 4 * np.diag(np.add(renewed, 0.9**50))
    np.testing.assert_allclose(readout.weights, np.linalg.solve(gram, (x * weight[:, None]).T @ y).T, rtol=0, atol=1e-9)


def test_collinear_features_and_forgetting_do_not_run_away():
    """Without its penalty renewed it predicted 4096 at step 10,300, for a target of the order of 1."""
    rng = np.random.default_rng(0)
    for forgetting in (0.9, 0.99, 0.999):
        readout = RecursiveLeastSquares(4, 1, ridge=1e-3, forgetting=forgetting, scale=1.0)
        z = rng.normal(size=20_000)
        worst = max(abs(readout.learn([each, 2 * each, -each, 1.0], [each])[0] - each) for each in z)
        assert worst < 10
        assert np.linalg.eigvalsh(readout.covariance)[-1] < 1 / (forgetting**4 * 1e-3)
        assert np.linalg.eigvalsh(readout.covariance)[0] > 0


def test_a_feature_that_stops_is_not_forgotten_for_ever():
    """The penalty's prediction of it is 0 then, and what comes after is learned anew."""
    readout = RecursiveLeastSquares(2, 1, forgetting=0.9, scale=1.0)
    rng = np.random.default_rng(0)
    for x in rng.normal(size=(5000, 2)) * [1, 0]:
        readout.learn(x, [x[0]])
    assert np.linalg.eigvalsh(readout.covariance)[-1] < 1 / 0.9**2
    for x in rng.normal(size=(200, 2)):
        readout.learn(x, [x[0] - 3 * x[1]])
    np.testing.assert_allclose(readout.weights[0], [1, -3], atol=0.5)


@pytest.mark.parametrize("forgetting", [1.0, 0.95])
def test_the_unit_of_the_features_does_not_matter(forgetting):
    x, y = stream(300, 3, 2)
    x[:5] = 0
    one, other, odd = (RecursiveLeastSquares(3, 2, ridge=0.1, forgetting=forgetting) for _ in range(3))
    for row, target in zip(x, y, strict=True):
        expected = one.learn(row, target)
        np.testing.assert_array_equal(other.learn(2.0**-40 * row, target), expected)
        np.testing.assert_allclose(odd.learn(1e9 * row, target), expected, rtol=0, atol=1e-9)


def test_it_predicts_before_it_learns():
    x, y = stream(10, 3, 2)
    readout = RecursiveLeastSquares(3, 2)
    for row, target in zip(x, y, strict=True):
        before = readout.predict(row)
        np.testing.assert_allclose(readout.learn(row, target), before, atol=1e-14)
        assert np.abs(readout.predict(row) - target).sum() < np.abs(before - target).sum()


def test_the_covariance_stays_symmetric_and_positive_over_a_long_collinear_stream():
    rng = np.random.default_rng(5)
    x = rng.normal(size=(20_000, 1)) + 1e-4 * rng.normal(size=(20_000, 6))
    readout = RecursiveLeastSquares(6, 1, ridge=1e-3, forgetting=0.999)
    for row in x:
        readout.learn(row, row[:1])
    np.testing.assert_array_equal(readout.covariance, readout.covariance.T)
    assert np.linalg.eigvalsh(readout.covariance)[0] > 0


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"features": 0}, ValueError, "features must be a whole number >= 1, got 0"),
        ({"outputs": 1.0}, TypeError, "outputs must be a whole number >= 1, got 1.0"),
        ({"ridge": 0}, ValueError, r"ridge must be in \(0, inf\), got 0"),
        ({"ridge": "1"}, TypeError, r"ridge must be a number in \(0, inf\), got '1'"),
        ({"scale": 0}, ValueError, r"scale must be in \(0, inf\), got 0"),
        ({"forgetting": 1.1}, ValueError, r"forgetting must be in \(0, 1\], got 1.1"),
        ({"forgetting": np.nan}, ValueError, r"forgetting must be in \(0, 1\], got nan"),
    ],
)
def test_bad_arguments(arguments, error, message):
    with pytest.raises(error, match=message):
        RecursiveLeastSquares(**{"features": 2, "outputs": 1, **arguments})


def test_a_bad_sample_is_refused_and_not_learned():
    readout = RecursiveLeastSquares(2, 1)
    with pytest.raises(ValueError, match=r"features must have shape \(2,\), got \(3,\)"):
        readout.predict([1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"targets must be finite, got nan at index \(0,\)"):
        readout.learn([1.0, 2.0], [np.nan])
    assert not readout.weights.any()


def test_the_first_sample_that_is_not_all_zero_sets_the_scale_and_is_learned():
    """Ridge regression on it alone: the penalty weighs as much as a sample of its root mean square."""
    readout = RecursiveLeastSquares(4, 1, ridge=0.5)
    readout.learn([0.0, 0.0, 0.0, 0.0], [7.0])
    assert (readout.scale, readout.weights.any()) == (None, False)
    first = np.array([0.0, 3.0, 0.0, -4.0])
    readout.learn(first, [7.0])
    assert readout.scale == 2.5
    np.testing.assert_allclose(readout.weights[0], 7.0 * first / (0.5 * 2.5**2 + 25.0), rtol=1e-12)
