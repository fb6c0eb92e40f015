"""Straight-line code against the Python it was made from."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from stickslip.unrolling import fma, sum_of_products, unrolled

numbers = st.floats(-1e3, 1e3)


def powers(order, _rows, x, y):
    row = [x]
    for _ in range(order):
        row.append(row[-1] * y)
    return {0: row, 1: [abs(x).smaller(y), abs(x).larger(y), x / y, fma(x, y, 1.0), x - y]}


write_powers = unrolled(powers)


@njit
def written(x, y, rows):
    write_powers(5, (x, y), rows)


@given(x=numbers, y=st.floats(0.1, 10.0))
def test_rows_are_written_as_the_recurrence_says(x, y):
    rows = np.full((2, 7), np.nan)
    written(x, y, rows)
    np.testing.assert_allclose(rows[0, :6], x * y ** np.arange(6), rtol=1e-14, atol=1e-300)
    # One rounding: the exact value, rounded.
    fused = float(Fraction(x) * Fraction(y) + 1)
    assert rows[1, :5].tolist() == [min(abs(x), y), max(abs(x), y), x / y, fused, x - y]
    assert np.isnan(rows[:, 6]).all()


@pytest.mark.parametrize("count", range(12))
def test_sum_of_products(count):
    left, right = (np.random.default_rng(seed).integers(-9, 10, count).tolist() for seed in (count, count + 100))
    assert sum_of_products(left, right, 7) == 7 + int(np.dot(left, right))
    if count:
        assert sum_of_products(left, right) == int(np.dot(left, right))


def estimates(_order, _rows, x):
    return {0: [x.log2(), (x * 0.01).exp2()]}


write_estimates = unrolled(estimates)


@njit
def estimated(x, rows):
    write_estimates(1, (x,), rows)


@given(x=st.floats(1e-300, 1e4))
def test_estimates_are_as_good_as_they_say(x):
    rows = np.empty((1, 2))
    estimated(x, rows)
    assert rows[0, 0] == pytest.approx(np.log2(x), abs=0.05)
    assert rows[0, 1] == pytest.approx(2.0 ** (0.01 * x), rel=0.004)


def test_the_logarithm_of_nothing_and_of_infinity_can_be_compared():
    rows = np.empty((1, 2))
    estimated(0.0, rows)
    assert rows[0, 0] < -1000.0
    estimated(np.inf, rows)
    assert rows[0, 0] > 1000.0


def quadratic_at_four_places(_order, rows, scale):
    t = scale.times_each([1.0, 2.0, 3.0, 4.0])
    return {1: [t.fma(rows[0][2], rows[0][1]).fma(t, rows[0][0]).weighted_sum([1.0, 10.0, 100.0, 1000.0])]}


write_quadratic = unrolled(quadratic_at_four_places)


@njit
def quadratic(scale, rows):
    write_quadratic(1, (scale,), rows)


def test_a_vector_reads_rows_and_is_summed():
    rows = np.array([[2.0, 3.0, 5.0], [np.nan] * 3])
    quadratic(0.5, rows)
    places = 0.5 * np.arange(1, 5)
    assert rows[1, 0] == (2.0 + 3.0 * places + 5.0 * places**2) @ 10.0 ** np.arange(4)
