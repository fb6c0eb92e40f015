"""Straight-line code against the Python it was made from."""

from fractions import Fraction
from typing import NamedTuple

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from numba.core.errors import TypingError

from stickslip.compiling.arithmetic import exp, fma, sum_of_products, where
from stickslip.compiling.tracing import unrolled, unrolled_in_lanes

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


def every_operation(_order, rows, scale):
    """Each operation with a number on either side, and with a constant."""
    x, y, z = rows[0][0], rows[0][1], rows[0][2]
    numbers = [
        *(x + y, x - y, x * y, x / y, -x, abs(x)),
        *(x + 3.0, x - 3.0, x * 3.0, x / 3.0),
        *(3.0 + x, 3.0 - x, 3.0 * x, 3.0 / x),
        *(x + scale, scale - x, scale * x, scale / x),
        *(x.fma(y, z), x.fma(3.0, z), x.fma(y, 3.0), fma(scale, x, y)),
        *(x.smaller(y), x.larger(y), x.smaller(0.5), x.larger(0.5)),
        *(where(x < y, x, y), where(x < y, 1.0, z), where(x > 0.5, scale, 2.0)),
        sum_of_products([x, y, z], [y, z, x], scale),
    ]
    masks = [
        *(x < y, x <= y, x > y, x >= y, x == y, x != y),
        *(x < 0.5, x <= 0.5, x > 0.5, x >= 0.5, x == 0.5, x != 0.5),
        *((x < y) & (y < z), (x < y) | (y < z), (x < y) & (x > 0.5) | (z == y)),
    ]
    return {1: numbers}, masks


def by_hand(x, y, z, scale):
    def fused(a, b, c):
        if not np.isfinite([a, b, c]).all():
            return a * b + c
        return float(Fraction(a) * Fraction(b) + Fraction(c))

    numbers = [
        *(x + y, x - y, x * y, x / y, -x, abs(x)),
        *(x + 3.0, x - 3.0, x * 3.0, x / 3.0),
        *(3.0 + x, 3.0 - x, 3.0 * x, 3.0 / x),
        *(x + scale, scale - x, scale * x, scale / x),
        *(fused(x, y, z), fused(x, 3.0, z), fused(x, y, 3.0), fused(scale, x, y)),
        *(x if x < y else y, x if x > y else y, x if x < 0.5 else 0.5, x if x > 0.5 else 0.5),
        *(x if x < y else y, 1.0 if x < y else z, scale if x > 0.5 else 2.0),
        fused(z, x, fused(y, z, fused(x, y, scale))),
    ]
    masks = [
        *(x < y, x <= y, x > y, x >= y, x == y, x != y),
        *(x < 0.5, x <= 0.5, x > 0.5, x >= 0.5, x == 0.5, x != 0.5),
        *((x < y) and (y < z), (x < y) or (y < z), ((x < y) and (x > 0.5)) or (z == y)),
    ]
    return numbers, masks


OPERATIONS = len(by_hand(1.0, 2.0, 3.0, 4.0)[0])
write_every_operation = unrolled(lambda order, rows, scale: every_operation(order, rows, scale)[0])
write_every_operation_in_lanes = unrolled_in_lanes(every_operation, 8, len(by_hand(1.0, 2.0, 3.0, 4.0)[1]))


@njit(error_model="numpy")
def operated(scale, rows):
    write_every_operation(1, (scale,), rows)


@njit(error_model="numpy")
def operated_in_lanes(scale, rows):
    return write_every_operation_in_lanes(1, (scale,), rows)


def test_every_operation_of_numbers_and_lanes_is_that_of_floats():
    """Where numbers are equal, zero of either sign, infinite or none; a truth a bit a lane, the first lowest."""
    special = [
        *((0.5, 0.5, 0.5), (-0.0, 0.0, 1.0), (0.3, -0.2, -0.2), (0.7, 0.9, 0.9)),
        *((np.nan, 1.0, 2.0), (1.0, np.nan, 2.0), (np.inf, 1.0, -np.inf), (1e200, 1e50, -np.inf)),
    ]
    drawn = np.random.default_rng(0).normal(size=(8, 3)).tolist()
    for sets in (special, drawn):
        rows = np.zeros((2, OPERATIONS, 8))
        rows[0, :3] = np.array(sets).T
        masks = operated_in_lanes(0.7, rows)
        single = np.zeros((2, OPERATIONS))
        with np.errstate(all="ignore"):
            expected = [by_hand(*(np.float64(each) for each in one), np.float64(0.7)) for one in sets]
        for lane, (numbers, _) in enumerate(expected):
            single[0, :3] = sets[lane]
            operated(0.7, single)
            np.testing.assert_array_equal(rows[1, :, lane], single[1], err_msg=str(sets[lane]))
            np.testing.assert_array_equal(single[1], numbers, err_msg=str(sets[lane]))
            nonzero = ~np.isnan(single[1])
            np.testing.assert_array_equal(np.signbit(single[1])[nonzero], np.signbit(numbers)[nonzero])
        assert list(masks) == [
            sum(int(truths[i]) << lane for lane, (_, truths) in enumerate(expected)) for i in range(len(masks))
        ]


def test_plain_numbers_take_the_same_way():
    """What is traced is an ordinary function, of floats and of numbers of any kind."""
    assert where(True, 1, 2) == 1
    assert where(False, 1, 2) == 2
    assert fma(2, 3, 4) == 10
    assert exp(1.0) == np.exp(1.0)
    assert sum_of_products([Fraction(1, 3)], [Fraction(3, 5)], Fraction(1, 5)) == Fraction(2, 5)


class Recorded:
    """A term that keeps the order in which it was summed."""

    def __init__(self, told):
        self.told = told

    def __mul__(self, other):
        return Recorded(self.told + other.told)

    def __add__(self, other):
        return Recorded(f"({self.told}+{other.told})")


def test_the_last_pair_is_summed_last_and_chains_do_not_wait_for_each_other():
    def order(count, start=None):
        pairs = [[Recorded(letter) for letter in kind[:count]] for kind in ("abcdefghijk", "ABCDEFGHIJK")]
        return sum_of_products(*pairs, start and Recorded(start)).told

    # A product joins a chain by fma: it stands before what it is added to.
    assert order(1) == "aA"
    assert order(3) == "(cC+(bB+aA))"
    assert order(3, "s") == "(cC+(bB+(aA+s)))"
    assert order(5) == "(eE+((cC+aA)+(dD+bB)))"
    assert order(9, "s") == "(iI+(((eE+(aA+s))+(fF+bB))+((gG+cC)+(hH+dD))))"


def test_only_what_can_be_traced_is():
    @njit
    def of(order, rows):
        write_estimates(order, (1.0,), rows)

    @njit
    def in_lanes(rows):
        write_exponentials(1, (), rows)

    with pytest.raises(TypingError):
        of(1, np.zeros((1, 2)))  # an order that is known only when it runs
    for rows in (np.zeros(8), np.zeros((2, 8)), np.zeros((8, 2, 2)).T):
        with pytest.raises(TypingError):
            in_lanes(rows)
    for rows in (np.zeros(5), np.zeros((2, 2, 2)), np.zeros((2, 9)).T):
        with pytest.raises(TypingError):
            estimated(1.0, rows)


class Order(NamedTuple):
    any: float

    @staticmethod
    def order():
        return 3


write_order = unrolled(lambda order, _rows, x: {0: [x] * order})


@njit
def ordered(order, rows):
    write_order(order, (2.5,), rows)


def test_the_order_may_be_told_by_a_class():
    rows = np.zeros((1, 5))
    ordered(Order(0.0), rows)
    assert rows.tolist() == [[2.5, 2.5, 2.5, 0.0, 0.0]]
