"""Products of functions of past inputs: a complete orthonormal basis of what a reservoir could compute.

If inputs are independent from step to step, and f_1, f_2, ... are orthonormal under the law of one input, each with
zero mean, then the products ``f_a(u(k - i)) f_b(u(k - j)) ...`` over distinct delays are orthonormal, and with the
constant they span every function of the past [1]_. For a bit there is a single f, so the products are the
parities of sets of past bits (Walsh functions) [2]_; for uniform inputs f_n is the Legendre polynomial of degree n.

References
----------
.. [1] J. Dambre, D. Verstraeten, B. Schrauwen and S. Massar, "Information processing capacity of dynamical systems",
   Scientific Reports 2, 514, 2012.
.. [2] R. O'Donnell, "Analysis of Boolean functions", 2014, chapters 1 and 8 (the latter for biased bits).
"""

from collections.abc import Iterator
from itertools import combinations
from math import comb

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]

Term = tuple[tuple[int, int], ...]
"""A product: pairs of a delay and the degree of the function of that input, delays ascending."""

# Distance from a value, relative to the spread, at which inputs still have that value.
_SAME = 1e-9


def walsh(inputs: Array) -> Array:
    """The one function of an input of two values, ``(u - p) / sqrt(p (1 - p))`` for a bit that is 1 with probability p.

    Parameters
    ----------
    inputs : ndarray of shape (samples,)
        Of two values, whatever they are; p is their share. Or the innovations of a bit that is flipped at a rate q, of
        the four values ±q and ±(1 - q), one of which may be absent: their law at each step is that of such a bit or of
        its negative.

    Returns
    -------
    ndarray of shape (1, samples)

    Raises
    ------
    ValueError
        If the inputs have other values.
    """
    values = np.unique(inputs)
    spread = values[-1] - values[0]
    values = values[np.append(True, np.diff(values) > _SAME * spread)]
    if len(values) == 2:
        high = inputs > values.mean()
        p = high.mean()
        return np.where(high, np.sqrt((1 - p) / p), -np.sqrt(p / (1 - p)))[None]
    # Of ±q and ±(1 - q) one may be missing where flips are few.
    sizes = np.unique(np.abs(values))
    sizes = sizes[np.append(True, np.diff(sizes) > _SAME * spread)]
    if len(values) in (3, 4) and len(sizes) == 2 and sizes[0] > _SAME * spread:
        return inputs[None] / np.sqrt(sizes[0] * sizes[1])
    raise ValueError(
        f"inputs must have two values for the Walsh basis, or the four of a dithered bit's innovation, "
        f"got {len(values)}; for uniform inputs there is basis='legendre'"
    )


def legendre_polynomials(inputs: Array, degree: int, support: tuple[float, float] | None = None) -> Array:
    """Legendre polynomials of an input that is uniform over an interval, to unit variance.

    ``sqrt(2 n + 1) P_n(x)`` with x the input moved to [-1, 1].

    Parameters
    ----------
    inputs : ndarray of shape (samples,)
    degree : int
        The highest.
    support : tuple of two floats, optional
        The interval; from the least to the largest input by default, which misses about ``2 / samples`` of it.

    Returns
    -------
    ndarray of shape (degree, samples)
        Degrees 1 to `degree`.

    Raises
    ------
    ValueError
        If an input lies outside of the interval.
    """
    low, high = (inputs.min(), inputs.max()) if support is None else support
    if not low < high or inputs.min() < low or inputs.max() > high:
        raise ValueError(f"support must hold all inputs, from {inputs.min()} to {inputs.max()}, got {support}")
    x = (2 * inputs - low - high) / (high - low)
    return np.sqrt(2 * np.arange(1, degree + 1) + 1)[:, None] * legendre.legvander(x, degree).T[1:]


def terms(degree: int, latest: int, highest: int) -> Iterator[Term]:
    """All products of one degree that reach back to one delay, and no further.

    Parameters
    ----------
    degree : int
        Sum of the degrees of the factors.
    latest : int
        The largest delay in the product.
    highest : int
        Degree that one factor may have; 1 for bits.

    Yields
    ------
    Term
    """
    for factors in range(1, min(degree, latest + 1) + 1):
        for degrees in _compositions(degree, factors, highest):
            for delays in combinations(range(latest), factors - 1):
                yield tuple(zip((*delays, latest), degrees, strict=True))


def count_terms(degree: int, latest: int, highest: int) -> int:
    """Count what `terms` yields."""
    return sum(
        sum(1 for _ in _compositions(degree, factors, highest)) * comb(latest, factors - 1)
        for factors in range(1, min(degree, latest + 1) + 1)
    )


def products(functions: Array, wanted: list[Term], start: int) -> Array:
    """Evaluate products of functions of past inputs.

    Parameters
    ----------
    functions : ndarray of shape (degrees, samples)
        Functions of the input at each sample, of degree 1 and up.
    wanted : list of Term
    start : int
        First sample at which the products are wanted: at least the largest delay.

    Returns
    -------
    ndarray of shape (wanted, samples - start)
    """
    samples = functions.shape[1]
    rows = np.empty((len(wanted), samples - start))
    for row, term in zip(rows, wanted, strict=True):
        for factor, (delay, degree) in enumerate(term):
            shifted = functions[degree - 1, start - delay : samples - delay]
            if factor == 0:
                row[:] = shifted
            else:
                row *= shifted
    return rows


def _compositions(total: int, parts: int, highest: int) -> Iterator[tuple[int, ...]]:
    """Ways to write a number as an ordered sum of so many, each from 1 to `highest`."""
    if parts == 1:
        if 1 <= total <= highest:
            yield (total,)
        return
    for first in range(max(1, total - highest * (parts - 1)), min(highest, total - parts + 1) + 1):
        for rest in _compositions(total - first, parts - 1, highest):
            yield (first, *rest)
