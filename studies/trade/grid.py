"""A function of the body's state, known at the points of a grid and interpolated between them."""

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

__all__ = ["Grid", "reachable_pressures"]

Array = NDArray[np.float64]

# Velocity of a foot that has just begun to slide.
_BARELY = 1e-9


class Grid:
    """Points over deformation, velocity, pressure and foot velocity, with multilinear interpolation.

    A foot that sticks may stay where one that slides ever so slowly, under the same pull, is torn along: static
    friction is larger than kinetic. So the function jumps at foot velocity 0, and the grid has a sheet of its own
    there, across which nothing is interpolated. Beyond the outermost points the function is that of the nearest.

    Parameters
    ----------
    deformations, velocities, pressures : sequences of float
        Ascending, two at least.
    speeds : sequence of float
        Of the sliding foot, ascending, above 0, two at least.
    """

    def __init__(
        self,
        deformations: Sequence[float] | Array,
        velocities: Sequence[float] | Array,
        pressures: Sequence[float] | Array,
        speeds: Sequence[float] | Array,
    ) -> None:
        self.axes = tuple(
            np.asarray(axis, np.float64) for axis in (deformations, velocities, pressures, [_BARELY, *speeds])
        )
        self.shape = tuple(len(axis) + (k == 3) for k, axis in enumerate(self.axes))

    @property
    def points(self) -> Array:
        """All points, shape (4, n)."""
        axes = (*self.axes[:3], np.append(0.0, self.axes[3]))
        return np.stack([each.ravel() for each in np.meshgrid(*axes, indexing="ij")])

    def interpolation(self, states: Array) -> csr_matrix:
        """Matrix that takes values at the points to values at states.

        Parameters
        ----------
        states : (4, m) array

        Returns
        -------
        (m, n) sparse matrix
            Rows sum to 1, none of its entries is negative.
        """
        count = states.shape[1]
        lower, share = np.empty((4, count), np.int64), np.empty((4, count))
        for k, (axis, state) in enumerate(zip(self.axes, states, strict=True)):
            lower[k] = np.clip(np.searchsorted(axis, state, side="right") - 1, 0, len(axis) - 2)
            share[k] = np.clip((state - axis[lower[k]]) / (axis[lower[k] + 1] - axis[lower[k]]), 0.0, 1.0)
        sticks = states[3] <= 0.0
        lower[3] = np.where(sticks, 0, lower[3] + 1)
        share[3] = np.where(sticks, 0.0, share[3])
        strides = np.cumprod([1, *self.shape[:0:-1]])[::-1]
        corner = strides @ lower
        columns, weights = np.empty((count, 16), np.int32), np.ones((count, 16))
        for j, up in enumerate(product((0, 1), repeat=4)):
            columns[:, j] = corner + int(strides @ up)
            for k in range(4):
                weights[:, j] *= share[k] if up[k] else 1.0 - share[k]
        columns[:, 1::2][sticks] -= 1  # what lies above the sheet has no weight, and may not be there
        rows = np.arange(0, 16 * count + 1, 16)
        return csr_matrix((weights.ravel(), columns.ravel(), rows), (count, int(np.prod(self.shape))))

    def outside(self, states: Array) -> NDArray[np.bool_]:
        """Which of m states, shape (4, m), lie beyond the outermost points."""
        low = np.array([axis[0] for axis in self.axes[:3]])[:, np.newaxis]
        high = np.array([axis[-1] for axis in self.axes])[:, np.newaxis]
        below = np.any(states[:3] < low - _BARELY, axis=0)
        return np.logical_or(below, np.any(states > high + _BARELY, axis=0))


def reachable_pressures(hold: float, deborah: float, count: int) -> Array:
    """Pressures between which all those lie that a sequence of holds ends with.

    The pressure goes a share of the way to 0 or to 1 in each hold. Where that share is above a half, no pressure
    between the two images of [0, 1] is ever reached, and so on within each: points are spent where the body can be.

    Parameters
    ----------
    hold, deborah : float
    count : int, >= 2
        Points wanted; there are no more.

    Returns
    -------
    (m,) array
        Ascending from 0 to 1.
    """
    kept = float(np.exp(-hold / deborah))
    if kept >= 0.5:
        return np.linspace(0.0, 1.0, count)
    points = np.array([0.0, 1.0])
    while 2 * len(points) <= count:
        points = np.concatenate([kept * points, 1.0 - kept + kept * points])
    return points
