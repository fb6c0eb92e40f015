"""NARMA: nonlinear autoregressive moving averages, the standard targets that need memory and nonlinearity.

Entry t of every result is y(t+1), the first value that depends on u(t): the target for the state that has
absorbed u(t). Before the start, y and u are zero.

References
----------
A. F. Atiya and A. G. Parlos, "New results on recurrent network training: unifying the algorithms and
accelerating convergence", IEEE Trans. Neural Networks 11, 697, 2000.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import finite_array

AMPLITUDE = 0.2
"""Height of the bits that drive NARMA. At 0.5, the usual bound of a uniform input, bits make NARMA-10 diverge
in most runs of 2000 steps."""

_DIVERGED = 10.0
"""Past this the quadratic term alone sustains the growth; y stays below 2 otherwise."""


def narma2(u: ArrayLike) -> NDArray[np.float64]:
    """Compute the target of order 2.

    ``y(t+1) = 0.4 y(t) + 0.4 y(t) y(t-1) + 0.6 u(t)^3 + 0.1``

    Parameters
    ----------
    u : array_like of shape (samples,)
        Usually ``AMPLITUDE * bits``.

    Returns
    -------
    ndarray of shape (samples,)
        Entry t is y(t+1), for the state that has absorbed u(t).

    Raises
    ------
    ValueError
        If `u` has a wrong shape, is not finite, or makes y diverge.
    """
    return _run(u, 2, lambda y, u: 0.4 * y[-1] + 0.4 * y[-1] * y[-2] + 0.6 * u[-1] ** 3 + 0.1)


def narma10(u: ArrayLike) -> NDArray[np.float64]:
    """Compute the target of order 10.

    ``y(t+1) = 0.3 y(t) + 0.05 y(t) sum_{i=0..9} y(t-i) + 1.5 u(t-9) u(t) + 0.1``

    Parameters
    ----------
    u : array_like of shape (samples,)
        Usually ``AMPLITUDE * bits``.

    Returns
    -------
    ndarray of shape (samples,)
        Entry t is y(t+1), for the state that has absorbed u(t).

    Raises
    ------
    ValueError
        If `u` has a wrong shape, is not finite, or makes y diverge.
    """
    return _run(u, 10, lambda y, u: 0.3 * y[-1] + 0.05 * y[-1] * y.sum() + 1.5 * u[0] * u[-1] + 0.1)


_Vector = NDArray[np.float64]


def _run(u: ArrayLike, order: int, successor: Callable[[_Vector, _Vector], float]) -> _Vector:
    """Iterate ``y(t+1) = successor(y(t-order+1..t), u(t-order+1..t))``, oldest first, from zeros."""
    past = np.zeros(order)
    u = np.concatenate([past, finite_array("u", u, 1)])
    y = np.concatenate([past, np.empty(len(u) - order)])
    for end in range(order, len(u)):
        y[end] = successor(y[end - order : end], u[end - order + 1 : end + 1])
        if abs(y[end]) > _DIVERGED:
            raise ValueError(
                f"u must be small enough for NARMA-{order} to stay bounded, got values up to "
                f"{np.abs(u).max():g}, which drive y to {y[end]:g} at step {end - order}"
            )
    return y[order:]
