"""The area that a front dominates."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...common.validation import finite_array
from ...train.schedules import pareto_front

__all__ = ["hypervolume"]


def hypervolume(points: ArrayLike, reference: Sequence[float] = (0.0, 0.0)) -> float:
    """Area of what is above a reference point in both coordinates, and below a point of a set in both [1]_.

    Parameters
    ----------
    points : (n, 2) array_like
        More is better. Those that are not above the reference in both coordinates add nothing.
    reference : (float, float)

    Returns
    -------
    float
        At least 0.

    Raises
    ------
    ValueError, TypeError
        If an argument has another shape, or is not finite.

    References
    ----------
    .. [1] E. Zitzler and L. Thiele, "Multiobjective evolutionary algorithms: a comparative case study and the strength
       Pareto approach", IEEE Transactions on Evolutionary Computation 3, 257, 1999.
    """
    given, origin = finite_array("points", points, 2), finite_array("reference", reference, 1)
    if given.shape[1] != 2:
        raise ValueError(f"points must have shape (n, 2), got {given.shape}")
    if origin.shape != (2,):
        raise ValueError(f"reference must have shape (2,), got {origin.shape}")
    above = np.maximum(given - origin, 0.0)
    # By the first coordinate, falling, so that the second rises.
    first, second = above[pareto_front(above)].T
    return float(first @ np.diff(second, prepend=0.0))
