import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.reservoir import delay_line, state_rank
from stickslip.reservoir.delayed import delayed_products, delayed_rows, delayed_squared_correlations
from stickslip.reservoir.metrics import squared_correlation
from stickslip.reservoir.orthonormal import centre, orthonormal_basis, surely_full_rank, Whitening, whitening
from stickslip.reservoir.ridge import ridge_weights


def conditioned(samples, features, condition, seed=0):
    """Centred states of a condition number, turned so that no column is alone to blame for it."""
    rng = np.random.default_rng(seed)
    left = np.linalg.qr(centre(rng.normal(size=(samples, features))).states)[0]
    right = np.linalg.qr(rng.normal(size=(features, features)))[0]
    return left * np.geomspace(1, 1 / condition, features) @ right


def exact_prediction(x, y, ridge):
    with mpmath.workdps(60):
        features = mpmath.matrix(x.tolist())
        gram = features.T * features + ridge * mpmath.eye(x.shape[1])
        weights = mpmath.lu_solve(gram, features.T * mpmath.matrix(y.tolist()))
        return np.array([float(value) for value in features * weights])


@pytest.mark.parametrize("condition", [1e1, 1e3, 1e5, 1e7, 1e9, 1e11])
@pytest.mark.parametrize("ridge", [0.0, 1e-10, 1e-3])
def test_ridge_loses_no_more_digits_than_the_condition_number_takes(condition, ridge):
    """Judged by 60 digits. The normal equations lose its square; nine digits are all that is asked for."""
    x = conditioned(60, 5, condition)
    y = np.random.default_rng(1).normal(size=60)
    prediction = x @ ridge_weights(x, y[:, None], ridge)[:, 0]
    error = np.abs(prediction - exact_prediction(x, y, ridge)).max() / np.abs(y).max()
    assert error < 1e-9 + 10 * np.finfo(float).eps * condition


def test_every_way_to_an_orthonormal_basis_is_taken():
    assert whitening(np.eye(3)).nine_digits
    hard, singular = conditioned(500, 8, 1e6), conditioned(500, 8, 1e12)
    assert not whitening(hard.T @ hard).nine_digits
    assert whitening(singular.T @ singular) is None
    assert whitening(np.diag([1.0, 0.0])) is None


@pytest.mark.parametrize("condition", [1, 1e3, 1e6, 1e8, 1e10, 1e12])
def test_the_basis_is_orthonormal_and_spans_the_states(condition):
    x = 1e5 * conditioned(800, 20, condition) + 3
    q = orthonormal_basis(x)
    assert q.shape == (800, 20)
    np.testing.assert_allclose(q.T @ q, np.eye(20), atol=1e-13 + (1e-17 * condition) ** 2)
    np.testing.assert_allclose(q.sum(axis=0), 0, atol=1e-10)
    moved = x - x.mean(axis=0)
    np.testing.assert_allclose(q @ (q.T @ moved), moved, atol=1e-11 * np.abs(x).max())


def test_the_rank_survives_a_large_offset():
    """The mean's own rounding is 1e4 times the states' variation over 1e16, not more."""
    x = np.random.default_rng(0).normal(size=(5000, 6))
    assert state_rank(x + 1e12) == 6
    assert state_rank(np.column_stack([x[:, 0] + 1e12, x[:, 1], 1e-9 * x[:, 2]])) == 3
    assert state_rank(np.full((1000, 3), 0.1) * [1, 1e12, 0]) == 0


def test_copies_do_not_count():
    x = np.random.default_rng(0).normal(size=(3000, 4))
    assert state_rank(np.column_stack([x, 1e4 * x + 7, x[:, :1] + x[:, 1:2], np.ones(3000)])) == 4
    assert state_rank(x[:3]) == 2


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 6), st.integers(0, 3), st.integers(-8, 8), st.integers(0, 2**32 - 1))
def test_the_rank_knows_neither_units_nor_order_nor_mixing(rank, copies, power, seed):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(200, rank))
    x = np.column_stack([x, x @ rng.normal(size=(rank, copies))])
    mixing = np.linalg.qr(rng.normal(size=(rank + copies, rank + copies)))[0]
    assert state_rank(x) == rank
    assert state_rank(rng.permuted(x, axis=0)[:, ::-1] if copies == 0 else x[:, ::-1]) == rank
    assert state_rank(x * 10.0**power) == rank
    assert state_rank(x @ mixing + 5) == rank


@pytest.mark.parametrize("offset", [0.0, 1e9])
@pytest.mark.parametrize("delays", [[0, 3, 1], range(300)])
def test_products_by_blocks_are_those_of_whole_matrices(offset, delays):
    rng = np.random.default_rng(0)
    states, message, lags = rng.normal(size=(3000, 7)), rng.normal(size=3000), np.array(delays)
    gram, cross = delayed_products(states + offset, message, lags, 310, 2500)
    moved, rows = centre(states[310:2500]).states, delayed_rows(message, lags, 310, 2500)
    np.testing.assert_array_equal(rows[1], message[310 - lags[1] : 2500 - lags[1]])
    tolerance = 1e-9 + 1e-4 * (offset > 0)
    np.testing.assert_allclose(gram, moved.T @ moved, atol=tolerance)
    np.testing.assert_allclose(cross, moved.T @ rows.T, atol=tolerance)
    plain, _ = delayed_products(states, message, lags, 310, 2500, centred=False)
    np.testing.assert_allclose(plain, states[310:2500].T @ states[310:2500], atol=1e-9)

    weights = rng.normal(size=(7, len(lags)))
    weights[:, 0] = 0
    scores, scatter = delayed_squared_correlations(states, weights, states[0], message, lags, 310, 2500)
    prediction = states[310:2500] @ weights
    np.testing.assert_allclose(scores, squared_correlation(prediction, rows.T), atol=1e-12)
    assert scores[0] == 0
    p, t = (prediction - prediction.mean(axis=0))[:, 1:], (rows.T - rows.T.mean(axis=0))[:, 1:]
    expected = np.sum((p * t) ** 2, axis=0) / np.sum(p**2, axis=0) / np.sum(t**2, axis=0)
    # The message's mean is left in, which has a standard error of 1/47.
    np.testing.assert_allclose(scatter[1:], expected, rtol=0.1)
    assert scatter[0] == 1 / 2190


def test_a_delay_line_is_its_own_basis():
    bits = np.random.default_rng(0).integers(0, 2, 4000)
    line = delay_line(bits, 4)
    q = orthonormal_basis(line)
    assert q.shape[1] == 4
    assert np.linalg.norm(q.T @ (line[:, 2] - line[:, 2].mean())) ** 2 == pytest.approx(4000 * line[:, 2].var())


@pytest.mark.parametrize("features", [2, 16])
def test_an_offset_takes_a_direction_from_the_basis_as_it_does_from_the_rank(features):
    """From a hundred roundings of the offset on a column no longer counts; the quick way is taken only well below."""
    x = np.random.default_rng(0).normal(size=(3000, features))
    x /= x.std(axis=0)
    rounding = 100 * np.finfo(float).eps
    for offset, rank in ((0.7, features), (1.5, features - 1), (3.0, features - 1), (0.01, features)):
        moved = x.copy()
        moved[:, 0] += offset / rounding
        assert orthonormal_basis(moved).shape[1] == state_rank(moved) == rank
    white = whitening(x.T @ x)
    assert surely_full_rank(white, np.full(features, np.sqrt(3000)))
    for share, sure in ((0.9, True), (1.1, False)):
        # The least singular value against the tolerance, both as badly as they may be, and twice for rounding.
        bound = share / (2 * rounding * np.sqrt(features))
        assert surely_full_rank(Whitening(np.diag(np.eye(features)[0]), 0.0), np.full(features, bound)) == sure


@pytest.mark.parametrize("level", [0.0, 0.1, 1.0])
def test_what_never_moves_spans_nothing(level):
    assert orthonormal_basis(np.full((20, 3), level)).shape == (20, 0)
