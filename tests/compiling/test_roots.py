"""The first descent of a polynomial, against polynomials whose roots are known."""

from fractions import Fraction
from itertools import pairwise
from math import comb

import numpy as np
import pytest
from cases import HUNT
from hypothesis import assume, given
from hypothesis import strategies as st

from stickslip.compiling.roots import first_downcrossing, horner, horner_derivative, LARGEST_DEGREE, sharp_descent

NEVER = np.inf
units = st.fractions(0, 1, max_denominator=1000)
inner = st.fractions(Fraction(1, 10), Fraction(9, 10), max_denominator=500)


def product(roots, sign=1):
    """Exact ascending coefficients of sign * prod (1 - t / root), so that the constant is `sign`."""
    coefficients = [Fraction(sign)]
    for root in roots:
        longer = [*coefficients, Fraction(0)]
        for n, c in enumerate(coefficients):
            longer[n + 1] -= c / Fraction(root)
        coefficients = longer
    return coefficients


def descent(coefficients, length=1.0):
    return first_downcrossing(np.array([float(c) for c in coefficients]), len(coefficients) - 1, length)


def value(coefficients, t):
    return sum(c * Fraction(t) ** n for n, c in enumerate(coefficients))


@pytest.mark.parametrize(
    ("coefficients", "length", "expected"),
    [
        ([1.0, -2.0], 1.0, 0.5),
        ([1.0, -2.0], 0.4, NEVER),  # past the end
        ([1.0, 2.0], 1.0, NEVER),
        ([-1.0, 5.0], 1.0, 0.0),  # negative already
        ([0.0, -1.0], 1.0, 0.0),  # starts at zero and falls
        ([0.0, 1.0], 1.0, NEVER),  # starts at zero and rises
        ([0.0, 1.0, -2.0], 1.0, 0.5),  # zero, up, and down again
        ([0.0, 0.0, -1.0], 1.0, 0.0),
        ([0.0, 0.0, 1.0], 1.0, NEVER),
        ([0.0, 0.0], 1.0, NEVER),  # zero throughout
        ([3.0, 0.0, 0.0], 1.0, NEVER),
        ([0.25, -1.0, 1.0], 1.0, NEVER),  # touches zero at 1/2
        ([0.09, -0.6, 1.0], 1.0, NEVER),  # touches zero at 0.3
        ([1.0, -2.0, 1.0], 1.0, NEVER),  # falls all the way, to zero
        ([1.0, -1.5, 0.6], 1.0, NEVER),  # falls all the way, and stays above
        ([0.1, 1.0, -0.4], 1.0, NEVER),  # rises all the way
        ([0.1, 1.0, -1.6], 1.0, (1.0 + 1.64**0.5) / 3.2),  # rises and falls
        ([0.25 - 1e-10, -1.0, 1.0], 1.0, 0.5 - 1e-5),
        ([0.25 + 1e-10, -1.0, 1.0], 1.0, NEVER),
        ([1.0, -3.0, 3.0, -1.0], 2.0, 1.0),  # a triple root is a descent
        ([1.0, -1.0], 0.0, NEVER),  # an interval of no length
        ([-1.0, 1.0], 0.0, 0.0),
    ],
)
def test_by_hand(coefficients, length, expected):
    # A triple root is found to the cube root of rounding only.
    assert descent(coefficients, length) == pytest.approx(expected, abs=1e-4 if len(coefficients) == 4 else 1e-7)


@HUNT
@given(
    roots=st.lists(units.filter(bool), min_size=1, max_size=5, unique=True),
    outside=st.lists(st.fractions(2, 50), max_size=6),
    sign=st.sampled_from([1, -1]),
    length=st.sampled_from([0.01, 1.0, 4.0]),
)
def test_the_first_of_simple_roots(roots, outside, sign, length):
    roots = sorted(roots)
    assume(all(b - a > Fraction(1, 50) for a, b in pairwise([*roots, Fraction(1)])))
    assume(roots[0] > Fraction(1, 50))
    scaled = [Fraction(length) * root for root in [*roots, *outside]]
    coefficients = product(scaled, sign)
    found = descent(coefficients, length)
    if sign < 0:
        assert found == 0.0
        return
    # A root is known to the rounding of the terms over the slope.
    size = sum(abs(c) * Fraction(length) ** n for n, c in enumerate(coefficients))
    slope = value([n * c for n, c in enumerate(coefficients)][1:], scaled[0])
    assert found == pytest.approx(float(scaled[0]), abs=64.0 * 2.0**-52 * float(size / abs(slope)))


@HUNT
@given(
    at=st.fractions(Fraction(1, 10), Fraction(9, 10), max_denominator=500),
    others=st.lists(st.fractions(2, 9), max_size=8),
)
def test_a_double_root_is_a_graze_and_no_descent(at, others):
    assert descent(product([at, at, *others])) == NEVER or _within_noise(product([at, at, *others]))


def _within_noise(coefficients):
    """Whether the polynomial, its coefficients rounded to floats, does fall below zero by more than rounding."""
    rounded = [Fraction(float(c)) for c in coefficients]
    found = Fraction(descent(coefficients))
    low = min(value(rounded, found + Fraction(step, 10**8)) for step in range(-50, 51))
    return low < -(2.0**-53) * float(sum(abs(c) for c in rounded))


@pytest.mark.parametrize("gap", [1e-3, 1e-5, 1e-6])
@pytest.mark.parametrize("at", [0.1, 0.37, 0.8])
@pytest.mark.parametrize("degree", [2, 5, 12, 20])
def test_two_roots_close_together_are_found(gap, at, degree):
    # The other factors are sums of squares, so these are the only roots.
    rest = [Fraction(1), Fraction(0), Fraction(1, 3)]
    coefficients = product([Fraction(at), Fraction(at) + Fraction(gap)])
    while len(coefficients) <= degree - 1:
        coefficients = [
            sum(coefficients[i] * rest[n - i] for i in range(len(coefficients)) if 0 <= n - i < 3)
            for n in range(len(coefficients) + 2)
        ]
    # The dip is gap^2 / 4 deep, so its edge is known to rounding over gap.
    assert descent(coefficients) == pytest.approx(at, abs=1e-13 / gap)


def test_two_roots_a_billionth_apart_are_found_where_rounding_allows():
    # On a step as short as this the dip between them is deep.
    a, b = 1e-9, 2e-9
    assert first_downcrossing(np.array([a * b, -(a + b), 1.0]), 2, 4e-9) == pytest.approx(a, rel=1e-12)
    # Elsewhere a dip of gap^2 / 4 = 2.5e-19 is far below rounding, and must count as a graze.
    assert descent(product([Fraction(1, 2), Fraction(1, 2) + Fraction(1, 10**9)])) == NEVER


@HUNT
@given(data=st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=LARGEST_DEGREE + 1), length=st.floats(1e-3, 3.0))
def test_no_earlier_point_is_negative_and_a_later_one_is(data, length):
    """Truth in exact arithmetic, on a grid: nothing below zero before the root; just after it, something is."""
    found = first_downcrossing(np.array(data), len(data) - 1, length)
    exact = [Fraction(c) for c in data]
    noise = 64 * 2.0**-52 * sum(abs(c) * length**n for n, c in enumerate(data))
    looks = np.linspace(0.0, min(found, length), 60)
    for look in looks if found == NEVER else looks[: -1 if found else 0]:
        assert value(exact, float(look)) >= -noise
    if found != NEVER:
        assert 0.0 <= found <= length
        assert value(exact, found) <= noise


@HUNT
@given(
    bumps=st.lists(st.floats(0.0, 1.0), min_size=3, max_size=LARGEST_DEGREE + 1),
    place=st.integers(0, LARGEST_DEGREE),
)
def test_a_polynomial_with_no_negative_bernstein_coefficient_never_descends(bumps, place):
    bumps[place % len(bumps)] = 0.0
    degree = len(bumps) - 1
    coefficients = [
        float(sum((-1) ** (n - i) * comb(degree, n) * comb(n, i) * Fraction(bumps[i]) for i in range(n + 1)))
        for n in range(degree + 1)
    ]
    found = first_downcrossing(np.array(coefficients), degree, 1.0)
    # Rounding of alternating sums grows with the degree; what it may hide is within the function's own noise.
    size = sum(abs(c) for c in coefficients)
    assert found == NEVER or abs(horner(np.array(coefficients), degree, found)) < 1e-14 * size


@pytest.mark.parametrize("degree", range(1, LARGEST_DEGREE + 1))
def test_every_degree_and_scale(degree):
    # (1 - t)^degree less a number: falls through it at 1 - number^(1 / degree).
    number = 0.01
    coefficients = np.array([(-1.0) ** n * comb(degree, n) for n in range(degree + 1)])
    coefficients[0] -= number
    expected = 1.0 - number ** (1.0 / degree)
    # Binomial coefficients cancel down from 2^degree, and what is lost counts as zero.
    near = 32.0 * 2.0**-52 * 2.0**degree / (degree * number ** (1.0 - 1.0 / degree)) + 1e-13
    for scale in (1e-200, 1.0, 1e200):
        assert first_downcrossing(scale * coefficients, degree, 1.0) == pytest.approx(expected, abs=near)
    stretched = coefficients * 0.5 ** np.arange(degree + 1)
    assert first_downcrossing(stretched, degree, 2.0) == pytest.approx(2.0 * expected, abs=2.0 * near)


def test_only_as_many_coefficients_are_read_as_the_degree_says():
    assert first_downcrossing(np.array([1.0, -2.0, np.nan, -1e9]), 1, 1.0) == pytest.approx(0.5)


@HUNT
@given(data=st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=LARGEST_DEGREE + 1), t=st.floats(-2.0, 2.0))
def test_horner_and_its_derivative(data, t):
    coefficients, degree = np.array(data), len(data) - 1
    scale = 1e-13 * (1.0 + np.polynomial.polynomial.polyval(abs(t), np.abs(coefficients) * (1 + np.arange(degree + 1))))
    expected = np.polynomial.polynomial.polyval(t, coefficients)
    slope = np.polynomial.polynomial.polyval(t, np.polynomial.polynomial.polyder(coefficients))
    assert horner(coefficients, degree, t) == pytest.approx(expected, abs=scale)
    assert horner_derivative(coefficients, degree, t) == pytest.approx(slope, abs=25.0 * scale)


@pytest.mark.parametrize("gap", [0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-11, 1e-8])
@pytest.mark.parametrize("at", [0.13, 0.3, 0.43174935039170475, 0.49])
def test_near_a_double_root_the_shortening_ends(at, gap):
    # The first of these once took a million passes, a rounding of the root each.
    exact = [Fraction(at) ** 2 - Fraction(gap), -2 * Fraction(at), Fraction(1)]
    coefficients = np.array([float(c) for c in exact])
    found = sharp_descent(coefficients, 2, 1.0)
    depth = Fraction(coefficients[1]) ** 2 / 4 - Fraction(coefficients[0])
    noise = 32 * 2.0**-52 * np.abs(coefficients).sum()
    if depth < -noise:
        assert found == NEVER
    elif depth > noise:
        assert found == pytest.approx(at - float(depth) ** 0.5, abs=noise / float(depth) ** 0.5)
    else:
        assert found == NEVER or found == pytest.approx(at, abs=2.0 * noise**0.5)


def test_the_reported_near_double_root_is_found_once():
    coefficients = np.array([0.18640750156364222, -0.8634987007834094, 1.0, 0.0])
    middle = -coefficients[1] / 2
    assert sharp_descent(coefficients, 3, 1.0) == pytest.approx(middle, abs=1e-6)


@pytest.mark.parametrize("root", [1e-3, 1e-9, 1e-14])
def test_an_early_root_is_as_sharp_as_in_a_short_interval(root):
    # (t - root) (t - 1) ... : the terms at 1 are larger than those at the root by 1 / root.
    coefficients = np.array([float(c) for c in product([Fraction(root), Fraction(3), Fraction(5), Fraction(7)])])
    assert sharp_descent(coefficients * root, 4, 1.0) == pytest.approx(root, rel=1e-13)


@pytest.mark.parametrize(("roundings", "counts"), [(15.0, False), (17.0, True)])
def test_sixteen_roundings_of_the_terms_count_as_zero(roundings, counts):
    """At the start, at the end and between, with terms that sum up to 1, 2 and 4."""
    eps = 2.0**-52
    assert descent([-roundings * eps, 1.0 - roundings * eps]) == (0.0 if counts else NEVER)
    at_end = descent([1.0, -1.0 - 2.0 * roundings * eps])
    assert at_end == (pytest.approx(1.0, abs=1e-14) if counts else NEVER)
    # 1 - 2 t + t^2 touches zero at 1, in the middle of the interval; its terms are 1, 4 and 4 there.
    dip = descent([1.0 - 9.0 * roundings * eps, -2.0, 1.0], length=2.0)
    assert dip == (pytest.approx(1.0, abs=1e-6) if counts else NEVER)


def test_what_is_taken_for_a_root_is_within_a_quarter_of_the_rounding():
    """Newton ends where the value is that of the margin, far below what counts as zero."""
    for k in range(1, 40):
        root = k / 41
        for coefficients in (product([root]), product([root, 2, 3]), product([root, root + 2, -1, 4, 5])):
            rounded = [Fraction(float(c)) for c in coefficients]
            size = sum(abs(c) for c in rounded)
            found = value(rounded, descent(coefficients)) / (size * Fraction(2) ** -52)
            assert -21 < found < -11


@pytest.mark.parametrize("root", [0.2, 0.45, 0.55, 0.9])
def test_a_descent_in_the_first_half_alone_is_sharpened(root):
    """From a half on the interval is nearly as short as it may be, and the answer is that of the first look."""
    coefficients = np.array([float(c) for c in product([root, 3, 5])])
    first, sharp = (each(coefficients, 3, 1.0) for each in (first_downcrossing, sharp_descent))
    assert sharp == pytest.approx(root, rel=1e-14)
    assert (sharp == first) or root < 0.5
    assert sharp_descent(coefficients, 3, 0.5 * root) == NEVER
    assert sharp_descent(-coefficients, 3, 1.0) == 0.0
