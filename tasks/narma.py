"""NARMA: nonlinear autoregressive moving averages, the standard targets that need memory and nonlinearity.

Entry t of every result is y(t+1), the first value that depends on u(t): the target for the state that has absorbed
u(t). Before the start, y and u are zero. The equations, as their papers print them, with 10 inputs u(t-9) to u(t) at
order 10 and not the 11 of much published code::

    2:  y(t+1) = 0.4 y(t) + 0.4 y(t) y(t-1) + 0.6 u(t)^3 + 0.1                                     [1]_
    5:  y(t+1) = 0.3 y(t) + 0.05 y(t) sum_{i=0..4} y(t-i) + 1.5 u(t-4) u(t) + 0.1                  [2]_
    10: y(t+1) = 0.3 y(t) + 0.05 y(t) sum_{i=0..9} y(t-i) + 1.5 u(t-9) u(t) + 0.1                  [1]_
    20: y(t+1) = tanh(0.3 y(t) + 0.05 y(t) sum_{i=0..19} y(t-i) + 1.5 u(t-19) u(t) + 0.01) + 0.2   [3]_

Order 10 can diverge, under uniform inputs in [0, 0.5] rarely and under bits of height 0.5 always. A diverging series
is refused, and where the inputs are drawn here they are drawn again; none is ever clipped. Order 20 cannot diverge:
its tanh saturates instead, on any usual input, and from then on y stays in [1.1, 1.2] with a standard deviation of
0.01. That is the canonical target, and an error relative to it is as meaningful as any.

References
----------
.. [1] A. F. Atiya and A. G. Parlos, "New results on recurrent network training: unifying the algorithms and
   accelerating convergence", IEEE Trans. Neural Networks 11, 697, 2000.
.. [2] K. Nakajima, H. Hauser, T. Li and R. Pfeifer, "Information processing via physical soft body", Scientific
   Reports 5, 10487, 2015: order n of [1]_'s tenth.
.. [3] A. Rodan and P. Tino, "Minimum complexity echo state network", IEEE Trans. Neural Networks 22, 131, 2011.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within, whole_number
from .streams import random_bits, random_uniform

__all__ = ["BITS_HEIGHT", "ORDERS", "UNIFORM_HEIGHT", "narma", "random_narma"]

UNIFORM_HEIGHT = 0.5
"""Top of the uniform inputs, as in the papers."""

BITS_HEIGHT = 0.2
"""Height of the bits. At 0.5 they make order 10 diverge in every run of 4000 steps."""

_DIVERGED = 10.0
"""Past this the quadratic term alone sustains the growth; y stays below 2 otherwise."""
_DRAWS = 100

_Vector = NDArray[np.float64]
_Successor = Callable[[_Vector, _Vector], float]


def _second(y: _Vector, u: _Vector) -> float:
    return 0.4 * y[-1] + 0.4 * y[-1] * y[-2] + 0.6 * u[-1] ** 3 + 0.1


def _nth(y: _Vector, u: _Vector) -> float:
    return 0.3 * y[-1] + 0.05 * y[-1] * y.sum() + 1.5 * u[0] * u[-1] + 0.1


def _twentieth(y: _Vector, u: _Vector) -> float:
    return math.tanh(0.3 * y[-1] + 0.05 * y[-1] * y.sum() + 1.5 * u[0] * u[-1] + 0.01) + 0.2


_SUCCESSORS: dict[int, _Successor] = {2: _second, 5: _nth, 10: _nth, 20: _twentieth}

ORDERS = tuple(_SUCCESSORS)
"""The orders that have a canonical equation here."""


def narma(u: ArrayLike, order: int) -> NDArray[np.float64]:
    """Compute the target of the given order.

    Parameters
    ----------
    u : array_like of shape (samples,)
        Usually uniform in [0, 0.5], or bits of height 0.2.
    order : int
        One of 2, 5, 10 and 20.

    Returns
    -------
    ndarray of shape (samples,)
        Entry t is y(t+1), for the state that has absorbed u(t).

    Raises
    ------
    ValueError
        If `u` has a wrong shape, is not finite, or makes y diverge, or the order has no equation here.
    """
    inputs = finite_array("u", u, 1)
    targets, diverged = _iterated(inputs, _known_order(order))
    if diverged is not None:
        raise ValueError(
            f"u must be small enough for NARMA-{order} to stay bounded, got values up to "
            f"{np.abs(inputs).max():g}, which drive y to {targets[diverged]:g} at step {diverged}"
        )
    return targets


def random_narma(
    length: int, order: int, seed: int, *, bits: bool = False, height: float | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Draw inputs and compute their target; inputs that make it diverge are drawn again, whole.

    Parameters
    ----------
    length : int, at least 1
    order : int
        One of 2, 5, 10 and 20.
    seed : int, at least 0
    bits : bool
        Whether the inputs are bits rather than uniform.
    height : float, in (0, inf)
        Top of the inputs; by default 0.5 for uniform ones and 0.2 for bits.

    Returns
    -------
    inputs, targets : ndarray of shape (length,)

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, or a hundred draws diverged: `height` is then too large.
    """
    top = (BITS_HEIGHT if bits else UNIFORM_HEIGHT) if height is None else number_within("height", height, "(0, inf)")
    order, seed = _known_order(order), whole_number("seed", seed, 0)
    for attempt in range(_DRAWS):
        fresh = seed if attempt == 0 else [seed, attempt]
        drawn = random_bits(length, fresh).astype(np.float64) if bits else random_uniform(length, fresh)
        inputs = top * drawn
        targets, diverged = _iterated(inputs, order)
        if diverged is None:
            return inputs, targets
    raise ValueError(f"height must be small enough for NARMA-{order} to stay bounded over {length} steps, got {top:g}")


def _known_order(order: int) -> int:
    if order not in _SUCCESSORS:
        raise ValueError(f"order must be one of {list(ORDERS)}, got {order!r}")
    return order


def _iterated(u: _Vector, order: int) -> tuple[_Vector, int | None]:
    """``y(t+1) = successor(y(t-order+1..t), u(t-order+1..t))``, oldest first, from zeros, and where it diverged."""
    successor = _SUCCESSORS[order]
    past = np.zeros(order)
    u = np.concatenate([past, u])
    y = np.concatenate([past, np.empty(len(u) - order)])
    for end in range(order, len(u)):
        y[end] = successor(y[end - order : end], u[end - order + 1 : end + 1])
        if abs(y[end]) > _DIVERGED:
            return y[order:], end - order
    return y[order:], None
