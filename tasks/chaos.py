"""Chaotic series to be foretold: Mackey-Glass and Lorenz, integrated until only chaos limits what is known of them.

The Santa Fe laser series is not among them: it comes without a licence that would let a package ship it.
"""

import math
from functools import cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within, whole_number
from ..compiling.compilation import allocating

__all__ = ["lorenz", "mackey_glass"]

# Over a delay of 17 the polynomials of Mackey-Glass err by some 1e-13; with 48 nodes by 1e-10.
_NODES = 64
_RATE, _GAIN, _POWER = 0.1, 0.2, 10
# A fifth of the least distance of a singularity of Lorenz's motion from the real axis.
_LONGEST, _ORDER = 0.02, 24
_STEPS_OF_A_CALL = 10_000


def mackey_glass(
    length: int, *, delay: float = 17.0, step: float = 1.0, start: float = 1.2, transient: float = 1000.0
) -> NDArray[np.float64]:
    """Integrate the equation of Mackey and Glass [1]_.

    ``x'(t) = 0.2 x(t - delay) / (1 + x(t - delay)^10) - 0.1 x(t)``

    from ``x = start`` at all times up to 0. Delay by delay x is a polynomial, at whose Chebyshev nodes
    ``x = x_0 + int (g - 0.1 x) dt`` holds with the known g of the delay before (the method of steps, with the integral
    collocation of L. Greengard, SIAM J. Numer. Anal. 28, 1071, 1991). The error over one delay
    is some 1e-13; chaos then multiplies it by e about every 140 units of time.

    Parameters
    ----------
    length : int, at least 1
        Samples.
    delay : float, in (0, 100]
        At 17 the motion is mildly chaotic.
    step : float, in (0, inf)
        Time between samples.
    start : float, in (0, 1.5]
    transient : float, in [0, inf)
        Time before the first sample.

    Returns
    -------
    ndarray of shape (length,)
        In (0, 1.5).

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    References
    ----------
    .. [1] M. C. Mackey and L. Glass, "Oscillation and chaos in physiological control systems", Science 197, 287, 1977.
    """
    length = whole_number("length", length, 1)
    delay, step = number_within("delay", delay, "(0, 100]"), number_within("step", step, "(0, inf)")
    start = number_within("start", start, "(0, 1.5]")
    times = number_within("transient", transient, "[0, inf)") + step * np.arange(length)
    # Enough nodes for the shortest wave of the motion, however long the delay.
    nodes, integral, transform = _collocation(max(_NODES, int(_NODES * delay / 17.0)))
    half = 0.5 * delay
    solve = np.linalg.inv(np.eye(len(nodes)) + _RATE * half * integral)
    spans = np.floor(times / delay).astype(int)
    series = np.empty(length)
    x = np.full(len(nodes), start)
    for span in range(spans[-1] + 1):
        production = _GAIN * x / (1.0 + x**_POWER)
        x = solve @ (x[-1] + half * (integral @ production))
        here = np.flatnonzero(spans == span)
        if len(here):
            series[here] = chebyshev.chebval((times[here] - span * delay) / half - 1.0, transform @ x)
    return series


@cache
def _collocation(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Chebyshev nodes in [-1, 1], ascending, and what turns values there into integrals from -1 and coefficients."""
    nodes = chebyshev.chebpts2(count)
    transform = np.linalg.inv(chebyshev.chebvander(nodes, count - 1)).astype(np.float64)
    basis = chebyshev.chebint(np.eye(count), lbnd=-1.0)
    integral: NDArray[np.float64] = chebyshev.chebvander(nodes, count) @ basis @ transform
    return nodes, integral, transform


def lorenz(
    length: int, *, step: float = 0.05, start: ArrayLike = (1.0, 1.0, 1.0), transient: float = 50.0
) -> NDArray[np.float64]:
    """Integrate the equations of Lorenz [1]_, by Taylor series of order 24 in steps of 0.02 at most.

    ``x' = 10 (y - x), y' = x (28 - z) - y, z' = x y - 8/3 z``

    Each step is right to rounding; chaos then multiplies errors by e about every 1.1 units of time, so that after 40
    no digit is left that another computer would repeat, and the statistics are still the attractor's.

    Parameters
    ----------
    length : int, at least 1
        Samples.
    step : float, in (0, inf)
        Time between samples.
    start : array_like of shape (3,)
        x, y and z at time 0.
    transient : float, in [0, inf)
        Time before the first sample.

    Returns
    -------
    ndarray of shape (length, 3)

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    References
    ----------
    .. [1] E. N. Lorenz, "Deterministic nonperiodic flow", J. Atmospheric Sciences 20, 130, 1963.
    """
    length, step = whole_number("length", length, 1), number_within("step", step, "(0, inf)")
    transient = number_within("transient", transient, "[0, inf)")
    state = finite_array("start", start, 1).copy()
    if len(state) != 3:
        raise ValueError(f"start must have 3 numbers, got {len(state)}")
    motion = np.empty((length, 3))
    _flow(state, transient)
    for k in range(length):
        motion[k] = state
        _flow(state, step)
    return motion


def _flow(state: NDArray[np.float64], time: float) -> None:
    """Carry Lorenz's x, y, z a time on, in place."""
    steps = math.ceil(time / _LONGEST)
    # An interrupt is heard between two calls of compiled code.
    for done in range(0, steps, _STEPS_OF_A_CALL):
        _take(state, time / steps, min(_STEPS_OF_A_CALL, steps - done))


@allocating
def _take(state: NDArray[np.float64], h: float, steps: int) -> None:
    """Take steps of length h: Taylor coefficients by Cauchy's rule, summed by Horner's."""
    x, y, z = np.empty((3, _ORDER + 1))
    for _ in range(steps):
        x[0], y[0], z[0] = state
        for n in range(_ORDER):
            xz = 0.0
            xy = 0.0
            for j in range(n + 1):
                xz += x[j] * z[n - j]
                xy += x[j] * y[n - j]
            x[n + 1] = 10.0 * (y[n] - x[n]) / (n + 1)
            y[n + 1] = (28.0 * x[n] - xz - y[n]) / (n + 1)
            z[n + 1] = (xy - 8.0 / 3.0 * z[n]) / (n + 1)
        state[0], state[1], state[2] = x[_ORDER], y[_ORDER], z[_ORDER]
        for n in range(_ORDER - 1, -1, -1):
            state[0] = state[0] * h + x[n]
            state[1] = state[1] * h + y[n]
            state[2] = state[2] * h + z[n]
