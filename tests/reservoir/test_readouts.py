from itertools import product

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.linear_model import RidgeCV
from sklearn.model_selection import cross_val_score, GridSearchCV, TimeSeriesSplit
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.estimator_checks import parametrize_with_checks

from stickslip.reservoir import fit_readout, RecursiveLeastSquaresReadout, RidgeReadout
from stickslip.reservoir.ridge import leave_one_out

ESTIMATORS = [
    RidgeReadout(),
    RidgeReadout(1e-6),
    RidgeReadout([0.1, 1.0], per_output=True, fit_intercept=False),
    RecursiveLeastSquaresReadout(1e-3),
    RecursiveLeastSquaresReadout(fit_intercept=False, forgetting=0.99),
]


@parametrize_with_checks(ESTIMATORS)
def test_scikit_learns_own_checks(estimator, check):
    check(estimator)


def data(samples=60, features=5, outputs=3, seed=0):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(samples, features)) + 0.3
    noise = rng.normal(size=(samples, outputs)) * [0.01, 1, 10][:outputs]
    return x, x @ rng.normal(size=(features, outputs)) + noise + 2


@pytest.mark.parametrize("fit_intercept", [True, False])
@pytest.mark.parametrize("ridge", [0.0, 0.1, 30.0])
def test_leaving_one_out_in_closed_form_is_leaving_one_out(ridge, fit_intercept):
    x, y = data(30)

    def squares(x):
        return np.sum((x - x.mean(axis=0) * fit_intercept) ** 2)

    def without(k):
        rest = np.delete(x, k, 0)
        same = ridge * squares(x) / squares(rest)
        return fit_readout(rest, np.delete(y, k, 0), ridge=same, fit_intercept=fit_intercept).predict(x[[k]])[0]

    expected = [without(k) for k in range(30)]
    np.testing.assert_allclose(leave_one_out(x, y, ridge, fit_intercept), expected, atol=1e-10)


@pytest.mark.parametrize("per_output", [True, False])
@pytest.mark.parametrize("fit_intercept", [True, False])
def test_the_penalty_is_that_of_scikit_learns_generalized_cross_validation(per_output, fit_intercept):
    x, y = data()
    candidates = np.geomspace(1e-3, 1e3, 13)
    unit = np.sum((x - x.mean(axis=0) * fit_intercept) ** 2) / x.shape[1]
    judge = RidgeCV(unit * candidates, fit_intercept=fit_intercept, alpha_per_target=per_output).fit(x, y)
    readout = RidgeReadout(candidates, fit_intercept=fit_intercept, per_output=per_output).fit(x, y)
    np.testing.assert_allclose(unit * readout.penalty_, judge.alpha_)
    np.testing.assert_allclose(readout.coef_, judge.coef_, atol=1e-8)
    np.testing.assert_allclose(readout.intercept_, judge.intercept_, atol=1e-8)
    assert readout.leave_one_out_error_.shape == (13, 3)


# Recursive least squares holds the inverse of the states' squares, which must be a number.
@pytest.mark.parametrize(
    ("readout", "factor"),
    [
        *product(
            [RidgeReadout(), RidgeReadout(0.1), RidgeReadout([1e-3, 0.1], fit_intercept=False)],
            [2.0**-700, 1e-8, 3.0, 2.0**20, 1e250],
        ),
        *product(
            [RecursiveLeastSquaresReadout(), RecursiveLeastSquaresReadout(fit_intercept=False, forgetting=0.9)],
            [1e-8, 3.0, 2.0**20],
        ),
    ],
    ids=str,
)
def test_the_unit_of_the_states_does_not_matter(readout, factor):
    """To the bit, where the factor is a power of two."""
    x, y = data()
    one, other = clone(readout).fit(x, y).predict(x), clone(readout).fit(factor * x, y).predict(factor * x)
    exact = np.frexp(factor)[0] == 0.5
    np.testing.assert_allclose(other, one, rtol=0, atol=0 if exact else 1e-9)


def test_a_noisy_target_is_penalized_and_a_clean_one_is_not():
    x, y = data(40, 30, 1)
    noise = np.random.default_rng(5).normal(size=(40, 1))
    readout = RidgeReadout(per_output=True).fit(x, np.hstack([y, noise]))
    assert readout.penalty_[0] < 1e-3
    assert readout.penalty_[1] > 0.1


def test_collinear_states_keep_their_digits_where_the_gram_matrix_would_lose_them():
    rng = np.random.default_rng(1)
    common, small = rng.normal(size=(2, 500))
    states = np.column_stack([common, common + 1e-7 * small])
    for readout in (RidgeReadout(0.0), RidgeReadout()):
        assert np.abs(readout.fit(states, small).predict(states) - small).max() < 1e-6


def test_a_large_offset_costs_no_more_than_its_own_digits():
    x, y = data(200, 4, 1)
    prediction = RidgeReadout(1e-9).fit(x + 1e9, y[:, 0]).predict(x + 1e9)
    np.testing.assert_allclose(prediction, RidgeReadout(1e-9).fit(x, y[:, 0]).predict(x), atol=1e-5)


def test_more_features_than_samples_need_a_penalty():
    x, y = data(10, 20, 1)
    assert RidgeReadout().fit(x, y).penalty_ > 0
    with pytest.raises(ValueError, match="penalty must leave an error that is finite with 10 samples of 20 features"):
        RidgeReadout([0.0], fit_intercept=False).fit(np.eye(10, 20), y)


def test_bad_penalties():
    x, y = data()
    with pytest.raises(ValueError, match=r"penalty must be in \[0, inf\), got -1.0"):
        RidgeReadout(-1.0).fit(x, y)
    with pytest.raises(ValueError, match=r"penalty must hold numbers in \[0, inf\), got -2.0"):
        RidgeReadout([1.0, -2.0]).fit(x, y)


def test_recursive_least_squares_is_the_ridge_of_all_samples_so_far():
    x, y = data()

    def judge(x, y, penalty):
        return np.linalg.solve(x.T @ x + penalty * np.eye(x.shape[1]), x.T @ y)

    readout = RecursiveLeastSquaresReadout(0.5, fit_intercept=False)
    penalty = 0.5 * np.mean(x[:2] ** 2)
    for part in (slice(0, 2), slice(2, 20), slice(20, 60)):
        readout.partial_fit(x[part], y[part])
        np.testing.assert_allclose(readout.coef_.T, judge(x[: part.stop], y[: part.stop], penalty), atol=1e-10)
    constant = RecursiveLeastSquaresReadout(0.5).fit(x, y)
    scale = np.sqrt(np.mean(x**2))
    expected = judge(np.column_stack([x, np.full(60, scale)]), y, 0.5 * scale**2)
    expected[-1] *= scale
    np.testing.assert_allclose(np.column_stack([constant.coef_, constant.intercept_]).T, expected, atol=1e-10)


def test_they_work_in_pipelines_and_searches():
    x, y = data(200)
    split = TimeSeriesSplit(4)
    for readout in (RidgeReadout(), RecursiveLeastSquaresReadout(1e-3)):
        scores = cross_val_score(make_pipeline(StandardScaler(), readout), x, y[:, 0], cv=split)
        assert scores.min() > 0.99
    search = GridSearchCV(RidgeReadout(), {"penalty": [1e-6, 1e6]}, cv=split).fit(x, y[:, 0])
    assert search.best_params_ == {"penalty": 1e-6}


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.longdouble, np.int16, bool, object])
@pytest.mark.parametrize("readout", ESTIMATORS, ids=str)
def test_whatever_the_type_of_the_samples_doubles_are_learned_and_told(readout, dtype):
    x, y = data()
    x, y = x.round().astype(dtype), y.round().astype(dtype)
    expected = clone(readout).fit(x.astype(float), y.astype(float))
    found = clone(readout).fit(x, y)
    for one, other in ((found.coef_, expected.coef_), (found.predict(x), expected.predict(x.astype(float)))):
        assert one.dtype == np.float64
        np.testing.assert_array_equal(one, other)
