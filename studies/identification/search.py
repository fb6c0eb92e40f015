"""The search for the body that fits: many starts on the first holds, and the run lengthened as it closes in.

A wrong guess gets the slips wrong, and then the sum of squares has many valleys. So the search starts from many bodies
about the guess on the first few holds, where few slips can be wrong, and goes on to longer runs with the best of them.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .problem import mean_squares, Problem
from .profiles import Profiles, profiles_of

__all__ = ["STRUCTURED", "Fit", "search"]

_FIRST = 12  # holds on which starts are compared
_LENGTHENED = 3.0  # the run grows by this factor
_KEPT = 8  # starts that are followed
_ALIKE = 1e-3  # relative difference of sums of squares below which two points lie in one valley
_ROUGH = 0.01  # squares of the noise: a descent that others follow ends where a step gains less
_VALLEYS = np.geomspace(0.8, 1.25, 64)  # ratios of static frictions that are compared at the end
_DEEPEST = 4  # valleys among them that are descended
_HOPELESS = 100.0  # times the least sum of squares, above which no valley is descended
_ROUNDS = 6  # of weighing anew and looking for what fits better
STRUCTURED = 5.0
"""Standard errors of a correlation above which what is left is no noise."""
_AGAIN = (_FIRST, 2 * _FIRST)  # holds on which a fit that leaves more than noise is sought once more


class Fit(NamedTuple):
    """The point that fits best, of all that were found.

    Attributes
    ----------
    problem : Problem
        With the weights of this fit.
    point : (free,) array
    profiles : Profiles
        About it.
    structure : float
        Of what is left, see `Problem.structure`.
    """

    problem: Problem
    point: NDArray[np.float64]
    profiles: Profiles
    structure: float


class _End(NamedTuple):
    """Where a descent has ended, and the mean square of the residuals there."""

    point: NDArray[np.float64]
    cost: float


def search(problem: Problem, starts: int, seed: int) -> Fit:
    """Find the point that fits best.

    Parameters
    ----------
    problem : Problem
    starts : int
        Points about the guess that are compared.
    seed : int
        Of these.

    Returns
    -------
    Fit

    Raises
    ------
    RuntimeError
        If no start can be simulated.
    """
    points = problem.coordinates.about_the_guess(starts, seed)
    kept, holds = _KEPT, _FIRST
    while True:
        part = problem.until(holds)
        costs = mean_squares(part.residuals(points))
        best = _of_different_valleys(costs)[:kept]
        if not best:
            raise RuntimeError("no body about the guess can be simulated; guess another")
        ends = [_descended(part, points[i], _ROUGH) for i in best]
        if holds >= problem.holds:
            break
        points = np.array([end.point for end in ends])
        kept, holds = max(1, kept // 2), round(_LENGTHENED * holds)
    fit = _polished(problem, _lowest(ends).point)
    if fit.structure <= STRUCTURED:
        return fit
    ends = [_End(fit.point, fit.profiles.least)]  # a wrong count of slips leaves more than noise
    for begin in _AGAIN:
        points = _about_the_static_friction(fit.problem.until(begin), fit.point)
        holds = begin
        while holds < problem.holds:
            part = fit.problem.until(holds)
            points = np.array([_descended(part, each, _ROUGH).point for each in points])
            holds = round(_LENGTHENED * holds)
        ends += [_descended(fit.problem, each, _ROUGH) for each in points]
    return _polished(fit.problem, _lowest(ends).point)


def _of_different_valleys(costs: NDArray[np.float64]) -> list[int]:
    """Places of sums of squares, the least first, without those that are as good as equal to one before."""
    places: list[int] = []
    for i in np.argsort(costs).tolist():
        if np.isfinite(costs[i]) and (not places or costs[i] > (1.0 + _ALIKE) * costs[places[-1]]):
            places.append(i)
    return places


def _lowest(ends: list[_End]) -> _End:
    return min(ends, key=lambda end: end.cost)


def _descended(problem: Problem, point: NDArray[np.float64], rough: float = 0.0) -> _End:
    """The least sum of squares that is found from a point, to so many squares of the noise."""
    low, high = problem.coordinates.bounds()
    found = least_squares(
        lambda x: problem.residuals(x[np.newaxis])[0],
        np.clip(point, low + 1e-9, high - 1e-9),
        jac=problem.slopes,
        bounds=(low, high),
        xtol=1e-10,
        ftol=max(1e-10, rough / problem.samples),
        gtol=1e-12,
        max_nfev=30,
    )
    return _End(np.asarray(found.x), float(mean_squares(found.fun)))


def _about_the_static_friction(problem: Problem, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """A point, and the deepest valleys along its static friction, whose sum of squares has a kink a slip."""
    if "static_friction" not in problem.coordinates.names:
        return point[np.newaxis]
    points = problem.coordinates.along_the_static_friction(point, _VALLEYS)
    costs = mean_squares(problem.residuals(points))
    walls = np.concatenate([[np.inf], costs, [np.inf]])
    valleys = np.flatnonzero((costs < walls[:-2]) & (costs <= walls[2:]) & (costs < _HOPELESS * costs.min()))
    deepest = valleys[np.argsort(costs[valleys])[:_DEEPEST]]
    return np.concatenate([point[np.newaxis], points[deepest]])


def _polished(problem: Problem, point: NDArray[np.float64]) -> Fit:
    """The lowest of what is found about a point, weighed by what it leaves."""
    searching, rounds = True, 0
    while True:
        rounds += 1
        problem = problem.weighed(point)
        if searching:
            ends = [_descended(problem, each, _ROUGH) for each in _about_the_static_friction(problem, point)]
            lowest = _lowest(ends)
            searching = _ROUGH / problem.samples * lowest.cost < ends[0].cost - lowest.cost and rounds < _ROUNDS
            point = lowest.point
            continue
        point = _descended(problem, point).point
        profiles = profiles_of(problem, point)
        lower = _lower_beside(problem, profiles)
        if lower is None or rounds >= _ROUNDS:
            return Fit(problem, point, profiles, problem.structure(point))
        point = lower


def _lower_beside(problem: Problem, profiles: Profiles) -> NDArray[np.float64] | None:
    """A point beyond a slip that was won or lost, to which a descent from a body beside leads, if it fits better."""
    lowest = np.unravel_index(np.argmin(profiles.rises), profiles.rises.shape)
    if profiles.rises[lowest] >= 0.0:
        return None
    end = _descended(problem, profiles.points[lowest], _ROUGH)
    return end.point if end.cost < profiles.least else None
