import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stickslip.reservoir import nrmse, squared_correlation

SERIES = arrays(float, 12, elements=st.floats(-1e6, 1e6).map(lambda v: round(v, 3)))


def varied(target):
    return np.ptp(target) > 0.1


def test_nrmse_by_hand():
    assert nrmse([1.0, 2.0, 3.0, 5.0], [1.0, 2.0, 3.0, 4.0]) == pytest.approx(np.sqrt(0.25 / 1.25))


@given(SERIES.filter(varied))
def test_nrmse_of_the_mean_is_one(target):
    assert nrmse(np.full_like(target, target.mean()), target) == pytest.approx(1)


@given(SERIES, SERIES.filter(varied))
def test_squared_correlation_is_that_of_numpy_where_positive(prediction, target):
    score = squared_correlation(prediction, target)
    if varied(prediction):
        rho = np.corrcoef(prediction, target)[0, 1]
        assert score == pytest.approx(max(rho, 0) ** 2, abs=1e-9)
    assert 0 <= score <= 1


@given(SERIES.filter(varied), st.floats(0.01, 100), st.floats(-100, 100))
def test_squared_correlation_ignores_scale_and_offset_but_not_sign(target, scale, offset):
    assert squared_correlation(scale * target + offset, target) == pytest.approx(1)
    assert squared_correlation(-scale * target + offset, target) == 0


def test_squared_correlation_of_a_constant_is_zero_and_columns_are_scored_apart():
    target = np.random.default_rng(0).normal(size=(50, 2))
    prediction = np.column_stack([np.full(50, 0.1), target[:, 1]])
    np.testing.assert_allclose(squared_correlation(prediction, target), [0, 1], atol=1e-12)


@pytest.mark.parametrize("metric", [nrmse, squared_correlation])
def test_bad_input(metric):
    with pytest.raises(ValueError, match="target must vary to be scored, got a constant over 3 samples"):
        metric([1.0, 2.0, 3.0], [0.3, 0.3, 0.3])
    with pytest.raises(ValueError, match=r"prediction must have the shape of target, \(3,\), got \(2,\)"):
        metric([1.0, 2.0], [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"prediction must be finite, got inf at index \(1,\)"):
        metric([1.0, np.inf], [1.0, 2.0])
