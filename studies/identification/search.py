"""The search for the body that fits: many starts on the first holds, and the run lengthened as it closes in."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .problem import Problem
from .profiles import beside

__all__ = ["STRUCTURED", "search"]

_FIRST = 12  # holds on which starts are compared
_LENGTHENED = 3.0  # the run grows by this factor
_KEPT = 8  # starts that are followed
_VALLEYS = np.geomspace(0.8, 1.25, 64)  # ratios of static frictions that are compared at the end
_DEEPEST = 4  # valleys among them that are descended
_ROUNDS = 4  # descents that may follow one that was not the lowest
STRUCTURED = 5.0  # standard errors of a correlation above which what is left is no noise
_AGAIN = (_FIRST, 2 * _FIRST)  # holds on which a fit that leaves more than noise is sought once more


def search(problem: Problem, starts: int, seed: int) -> NDArray[np.float64]:
    """The point that fits best, of all that are found."""
    longest = max(run.valve.size for run in problem.runs)
    points = problem.coordinates.about_the_guess(starts, seed)
    kept, holds = _KEPT, _FIRST
    while True:
        holds = min(holds, longest)
        costs = problem.costs(points, holds)
        best = np.argsort(costs)[:kept]
        if not np.isfinite(costs[best[0]]):
            raise RuntimeError("no body about the guess can be simulated; guess another")
        points = np.array([_descend(problem, points[i], holds) for i in best if np.isfinite(costs[i])])
        if holds == longest:
            break
        kept, holds = max(1, kept // 2), round(_LENGTHENED * holds)
    point = points[np.argmin(problem.costs(points, longest))]
    point = _polished(problem, point, longest)
    if problem.structure(point) > STRUCTURED:  # a wrong count of slips leaves more than noise
        ends = [point]
        for begin in _AGAIN:
            valleys = _about_the_static_friction(problem, point, begin)
            holds = begin
            while holds < longest:
                valleys = np.array([_descend(problem, each, holds) for each in valleys])
                holds = round(_LENGTHENED * holds)
            ends += [_descend(problem, each, longest) for each in valleys]
        point = _polished(problem, ends[np.argmin(problem.costs(np.array(ends), longest))], longest)
    return point


def _about_the_static_friction(problem: Problem, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
    """A point, and the deepest valleys along its static friction, whose sum of squares has a kink a slip."""
    if "static_friction" not in problem.coordinates.names:
        return point[np.newaxis]
    points = problem.coordinates.along_the_static_friction(point, _VALLEYS)
    costs = problem.costs(points, holds)
    walls = np.concatenate([[np.inf], costs, [np.inf]])
    valleys = np.flatnonzero((costs < walls[:-2]) & (costs <= walls[2:]))
    deepest = valleys[np.argsort(costs[valleys])[:_DEEPEST]]
    return np.concatenate([point[np.newaxis], points[deepest]])


def _descend(problem: Problem, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
    """The least sum of squares that is found from a point."""
    low, high = problem.coordinates.bounds()
    inside = np.clip(point, low + 1e-9, high - 1e-9)
    found = least_squares(
        lambda x: problem.residuals(x[np.newaxis], holds)[0],
        inside,
        jac=lambda x: problem.slopes(x, holds),
        bounds=(low, high),
        xtol=1e-10,
        ftol=1e-10,
        gtol=1e-12,
        max_nfev=30,
    )
    return np.asarray(found.x)


def _polished(problem: Problem, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
    """The lowest of what is found beside a point, weighed by what it leaves."""
    for _ in range(2):  # weights by what is left, then the fit by these weights
        problem.weigh(point)
        starts = _about_the_static_friction(problem, point, holds)
        ends = np.array([_descend(problem, start, holds) for start in starts])
        point = ends[np.argmin(problem.costs(ends, holds))]
    for _ in range(_ROUNDS):
        points, rises = beside(problem, point, holds)
        lowest = np.unravel_index(np.argmin(rises), rises.shape)
        if rises[lowest] >= 0.0:
            break
        lower = _descend(problem, points[lowest], holds)
        costs = problem.costs(np.array([point, lower]), holds)
        if not costs[1] < costs[0]:
            break
        point = lower
        problem.weigh(point)
    return point
