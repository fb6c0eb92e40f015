"""Straight-line code against the Python it was made from."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from stickslip.compiling.tracing import exp, fma, sum_of_products, unrolled, unrolled_in_lanes

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


@njit
def exponential(x):
    return exp(x)


write_exponentials = unrolled_in_lanes(lambda _order, rows: ({1: [exp(rows[0][0])]}, []), 8, 0)


@njit
def exponentials(rows):
    write_exponentials(1, (), rows)


# The last are halfway between two powers of two, where the series is longest.
@given(
    x=st.floats(-708.0, 709.0) | st.floats(-1.0, 1.0) | st.integers(-1020, 1021).map(lambda k: (k + 0.5) * np.log(2.0))
)
@settings(max_examples=500)
def test_the_exponential_is_within_one_unit_in_the_last_place(x):
    with mpmath.workprec(160):
        exact = mpmath.exp(x)
        assert abs(exponential(x) - exact) <= np.spacing(float(exact))


@pytest.mark.parametrize(
    ("x", "nearest"), [(709.5, 709.0), (np.inf, 709.0), (-708.5, -708.0), (-np.inf, -708.0), (np.nan, -708.0)]
)
def test_the_exponential_beyond_its_range_is_that_of_the_nearest_in_it(x, nearest):
    assert exponential(x) == exponential(nearest)


def test_the_exponential_of_nothing_and_of_next_to_nothing_is_one():
    for x in (0.0, -0.0, 5e-324, -5e-324, 1e-17):
        assert exponential(x) == 1.0


@given(st.lists(st.floats(-800.0, 800.0), min_size=8, max_size=8))
def test_lanes_have_the_bits_of_single_exponentials(numbers):
    rows = np.zeros((2, 1, 8))
    rows[0, 0] = numbers
    exponentials(rows)
    assert rows[1, 0].tolist() == [exponential(x) for x in numbers]
