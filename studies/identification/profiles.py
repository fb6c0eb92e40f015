"""How well a fit is known: its covariance, linearised, and bodies beside it that may fit as well.

Where a slip is won or lost a run has a kink or a jump, which no slope tells: what is found is compared with bodies
beside it along each parameter.
"""

import numpy as np
from numpy.typing import NDArray

from .problem import Problem

__all__ = ["beside", "linearised"]

# Where bodies beside a fit are compared with it, in standard errors.
_BESIDE = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0, 3.5, 4.0, 5.0, 7.0, 10.0, 15.0, 25.0])


def beside(problem: Problem, point: NDArray[np.float64], holds: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points beside one, (free, beside, free), and by how much more they leave, in squares of the noise.

    A row is a parameter of the body, moved by so many standard errors. The others follow as the covariance has it,
    or, where that leaves less, by a Gauss-Newton step from there.
    """
    covariance, scale, _, _ = linearised(problem, point, holds)
    turned = problem.coordinates.turned(point)
    back = np.linalg.pinv(turned)
    slopes = problem.slopes(point, holds) @ back
    errors = np.sqrt(np.diag(turned @ covariance @ turned.T))
    ways = turned @ covariance / np.where(errors > 0.0, errors, 1.0)[:, np.newaxis]
    offsets = np.concatenate([-_BESIDE, _BESIDE])
    low, high = problem.coordinates.bounds()
    found, costs = [], []
    for i, way in enumerate(ways):
        points = np.clip(point + np.outer(offsets, way), low, high)
        left = problem.residuals(points, holds)
        step = -np.linalg.pinv(np.delete(slopes, i, axis=1)) @ left.T
        moved = np.clip(points + np.insert(step, i, 0.0, axis=0).T @ back.T, low, high)
        both = np.stack([np.mean(each**2, axis=1) for each in (left, problem.residuals(moved, holds))])
        found.append(np.where((both[1] < both[0])[:, np.newaxis], moved, points))
        costs.append(both.min(axis=0))
    least = problem.costs(point[np.newaxis], holds)[0]
    return np.array(found), (np.array(costs) - least) * problem.samples / scale


def linearised(
    problem: Problem, point: NDArray[np.float64], holds: int
) -> tuple[NDArray[np.float64], float, NDArray[np.float64], NDArray[np.float64]]:
    """Covariance of the point, the mean square that is left, and the slopes' singular values and directions."""
    slopes = problem.slopes(point, holds)
    left = problem.residuals(point[np.newaxis], holds)[0]
    scale = float(left @ left) / (problem.samples - len(problem.coordinates.names))
    _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    known = np.maximum(singular, 1e-12 * max(singular[0], 1.0))
    return (directions.T / known**2) @ directions * scale, scale, known, directions
