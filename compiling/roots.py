"""First descent of a polynomial through zero, isolated with certainty.

A polynomial on an interval lies within the range of its Bernstein coefficients, and has as many roots there as
their signs vary, less an even number (Descartes' rule). Halving the interval (de Casteljau) until the variation is
0 or 1 therefore finds every root to rounding, however close two of them are: Lane and Riesenfeld, BIT 21 (1981);
Collins and Akritas, SYMSAC (1976).
"""

import math

import numpy as np
from numpy.typing import NDArray

from .arithmetic import fma
from .compilation import allocating, compiled

__all__ = ["LARGEST_DEGREE", "first_downcrossing", "horner", "horner_derivative", "sharp_descent"]

LARGEST_DEGREE = 24
# Sums of a step's terms are right to a few units in the last place; a dip shallower than that is no descent.
_NOISE = 16.0 * np.finfo(np.float64).eps
# At 2^-52 of the step neighbouring coefficients agree to rounding, so nothing is left to split.
_DEEPEST = 52
# Halving does not add variations (Schoenberg), and an interval that is split has two at least.
_LOOKS = (_DEEPEST + 1) * LARGEST_DEGREE
_REFINEMENTS = 100

_BINOMIAL = np.array(
    [[math.comb(n, k) for k in range(LARGEST_DEGREE + 1)] for n in range(LARGEST_DEGREE + 1)],
    dtype=np.float64,
)


@compiled
def horner(coefficients: NDArray[np.float64], degree: int, t: float) -> float:
    """Value at `t` of the polynomial with the given ascending coefficients; `degree` at least 1.

    Even and odd powers are summed apart, so that neither sum waits for the other.
    """
    square = t * t
    last = coefficients[degree]
    other = coefficients[degree - 1]
    for n in range(degree - 2, 0, -2):
        last = fma(last, square, coefficients[np.uintp(n)])
        other = fma(other, square, coefficients[np.uintp(n - 1)])
    if degree % 2 == 0:
        return fma(other, t, fma(last, square, coefficients[0]))
    return fma(last, t, other)


@compiled
def horner_derivative(coefficients: NDArray[np.float64], degree: int, t: float) -> float:
    """Derivative at `t` of the polynomial with the given ascending coefficients."""
    square = t * t
    last = degree * coefficients[degree]
    other = (degree - 1) * coefficients[degree - 1]
    for n in range(degree - 2, 1, -2):
        last = fma(last, square, n * coefficients[np.uintp(n)])
        other = fma(other, square, (n - 1) * coefficients[np.uintp(n - 1)])
    if degree % 2 == 0:
        return fma(last, t, other)
    return last if degree == 1 else fma(other, t, fma(last, square, coefficients[1]))


@compiled
def first_downcrossing(coefficients: NDArray[np.float64], degree: int, length: float) -> float:
    """First time in [0, length] from which a polynomial is negative.

    Parameters
    ----------
    coefficients : (>= degree + 1,) array
        Ascending coefficients.
    degree : int, in [1, LARGEST_DEGREE]
    length : float
        End of the interval that starts at 0.

    Returns
    -------
    float
        0 where the polynomial starts negative, inf where it stays non-negative. Values within rounding of zero
        count as zero: a graze is no descent.
    """
    size = abs(coefficients[0])
    end = lowest = coefficients[0]
    steepest = flattest = coefficients[1] * length
    power = 1.0
    for n in range(1, degree + 1):
        power *= length
        term = coefficients[n] * power
        size += abs(term)
        end += term
        lowest += min(term, 0.0)
        if n > 1:
            steepest += n * min(term, 0.0)
            flattest += n * max(term, 0.0)
    noise = _NOISE * size
    if lowest >= -noise:
        return np.inf
    if coefficients[0] < -noise:
        return 0.0
    # Most polynomials are monotone on the step, and bounds of the slope show it at once.
    if steepest >= 0.0 or (flattest <= 0.0 and end >= -noise):
        return np.inf
    if flattest <= 0.0:
        return _bracketed_root(coefficients, degree, noise, 0.0, length)
    return _isolate(coefficients, degree, length, noise)


@compiled
def sharp_descent(coefficients: NDArray[np.float64], degree: int, length: float) -> float:
    """First descent, early in the interval as sharply as if the interval ended soon after; arguments as above.

    Rounding is judged by the terms at the interval's end, which may be larger by orders of magnitude than those at an
    early root.
    """
    moment = first_downcrossing(coefficients, degree, length)
    if not 0.0 < moment < 0.5 * length:
        return moment
    # Where a pass does not halve the moment the terms at its end, and with them the rounding, hardly change any more.
    for _ in range(_DEEPEST):
        length = 2.0 * moment
        nearer = first_downcrossing(coefficients, degree, length)
        if nearer > length:
            break
        settled = nearer >= 0.5 * moment
        moment = nearer
        if settled:
            break
    return moment


@allocating
def _isolate(coefficients: NDArray[np.float64], degree: int, length: float, noise: float) -> float:
    """First descent below `-noise` in [0, length], or inf."""
    pending = np.empty((_DEEPEST + 2, degree + 1))
    left = np.empty(_DEEPEST + 2)
    depth = np.empty(_DEEPEST + 2, np.int64)
    power = 1.0
    for n in range(degree + 1):
        pending[0, n] = coefficients[n] * power / _BINOMIAL[degree, n]
        power *= length
    for k in range(degree):
        for i in range(degree, k, -1):
            pending[0, i] += pending[0, i - 1]
    left[0] = 0.0
    depth[0] = 0

    top = 0
    for _ in range(_LOOKS):
        if top < 0:
            break
        options = pending[top]
        variations = 0
        below = False
        for i in range(degree + 1):
            if (options[i] < -noise) != below:
                below = not below
                variations += 1
        if variations == 0:
            top -= 1
            continue
        width = length * 2.0 ** -depth[top]
        if variations == 1:
            return _bracketed_root(coefficients, degree, noise, left[top], left[top] + width)
        if depth[top] == _DEEPEST:
            return left[top]
        # The right half keeps this place on the stack and the left half, to be looked at first, goes above it.
        half = pending[top + 1]
        for k in range(degree + 1):
            half[k] = options[0]
            for i in range(degree - k):
                options[i] = 0.5 * (options[i] + options[i + 1])
        # De Casteljau leaves the right half in place, last coefficient first to settle.
        left[top + 1] = left[top]
        left[top] += 0.5 * width
        depth[top] += 1
        depth[top + 1] = depth[top]
        top += 1
    return left[top] if top >= 0 else np.inf


@compiled
def _bracketed_root(coefficients: NDArray[np.float64], degree: int, noise: float, low: float, high: float) -> float:
    """Where the polynomial passes `-noise`, once, between `low` and `high`: Newton kept inside the bracket."""
    above = horner(coefficients, degree, low) + noise
    below = horner(coefficients, degree, high) + noise
    t = low + (high - low) * (above / (above - below))
    if not low < t < high:  # the values at the ends are themselves rounding
        t = 0.5 * (low + high)
    for _ in range(_REFINEMENTS):
        value = horner(coefficients, degree, t) + noise
        if abs(value) <= 0.25 * noise:
            return t
        if value > 0.0:
            low = t
        else:
            high = t
        slope = horner_derivative(coefficients, degree, t)
        following = t - value / slope if slope < 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if following == t or not low < following < high:
            return following
        t = following
    return t
