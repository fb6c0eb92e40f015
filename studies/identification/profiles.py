"""How well a fit is known: its covariance, linearised, and bodies beside it that may fit as well.

Where a slip is won or lost a run has a kink or a jump, which no slope tells: what is found is compared with bodies
beside it along each parameter.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .problem import mean_squares, Problem

__all__ = ["Profiles", "profiles_of"]

# Where bodies beside a fit are compared with it, in standard errors.
_BESIDE = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0, 3.5, 4.0, 5.0, 7.0, 10.0, 15.0, 25.0])


class Profiles(NamedTuple):
    """What lies about a point.

    Attributes
    ----------
    least : float
        Mean square of the residuals there.
    covariance : (free, free) array
        Of the body's parameters, linearised, with the errors of each channel taken from what is left of it.
    errors : (free,) array
        Standard errors along `directions`, in units of the guess.
    directions : (free, free) array
        Of the coordinates, a row each: the singular ones of the slopes.
    points : (free, beside, free) array
        Beside it. A row is a parameter of the body, moved by so many standard errors. The others follow as the
        covariance has it, or, where that leaves less, by a Gauss-Newton step from there.
    rises : (free, beside) array
        By how much more these leave, in squares of the noise.
    """

    least: float
    covariance: NDArray[np.float64]
    errors: NDArray[np.float64]
    directions: NDArray[np.float64]
    points: NDArray[np.float64]
    rises: NDArray[np.float64]


def profiles_of(problem: Problem, point: NDArray[np.float64]) -> Profiles:
    """Compare the body at a point with those beside it.

    Parameters
    ----------
    problem : Problem
    point : (free,) array

    Returns
    -------
    Profiles
    """
    left = problem.residuals(point[np.newaxis])[0]
    least, scale = float(mean_squares(left)), float(left @ left) / (problem.samples - len(point))
    slopes = problem.slopes(point)
    _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    known = np.maximum(singular, 1e-12 * max(singular[0], 1.0))
    covariance = (directions.T / known**2) @ directions * scale
    turned = problem.coordinates.jacobian(point)
    of_body = turned @ covariance @ turned.T
    errors = np.sqrt(np.diag(of_body))
    ways = turned @ covariance / np.where(errors > 0.0, errors, 1.0)[:, np.newaxis]
    back = np.linalg.pinv(turned)
    slopes_of_body = slopes @ back
    offsets = np.concatenate([-_BESIDE, _BESIDE])
    low, high = problem.coordinates.bounds()
    points, costs = [], []
    for i, way in enumerate(ways):
        beside = np.clip(point + np.outer(offsets, way), low, high)
        beyond = problem.residuals(beside)
        step = -np.linalg.pinv(np.delete(slopes_of_body, i, axis=1)) @ beyond.T
        moved = np.clip(beside + np.insert(step, i, 0.0, axis=0).T @ back.T, low, high)
        both = np.stack([np.mean(each**2, axis=1) for each in (beyond, problem.residuals(moved))])
        points.append(np.where((both[1] < both[0])[:, np.newaxis], moved, beside))
        costs.append(both.min(axis=0))
    rises = (np.array(costs) - least) * problem.samples / scale
    return Profiles(least, of_body, np.sqrt(scale) / known, directions, np.array(points), rises)
