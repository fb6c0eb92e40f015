"""The reference that solvers are judged by, and how far it can be trusted."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from ...crawler import REST, SolverError, Trajectory
from ...crawler.solvers import solvers_for
from .case import afford, Case, differences, quantities, statistics

__all__ = ["Check", "Reference", "reference_for", "twin_statistics"]

TIGHTEST = 1e-15
_CHECKS = tuple(10.0**-k for k in range(14, 8, -1))
_MOST_ACCURATE_FIRST = ("closed_form", "taylor", "radau")
# Two runs that differ by more, though asked for the last digit, are not the same trajectory computed twice.
_COMPARABLE = 1e-6
_TWINS = 16
_TWIN_SPACING = 1e-9
_FALSE_ALARM = 0.01


@dataclass(frozen=True)
class Check:
    """A run that the reference was compared with.

    Attributes
    ----------
    solver : str
    tolerance : float
    differences : dict of str to float
        Largest difference from the reference, by quantity, natural units.
    slips : int
        Slips of this run.
    """

    solver: str
    tolerance: float
    differences: dict[str, float]
    slips: int


@dataclass(frozen=True)
class Reference:
    """The most accurate run there is of a case.

    Attributes
    ----------
    solver : str
    trajectory : Trajectory
        Of `solver` at tolerance 1e-15.
    checks : tuple of Check
        Every other solver at tolerance 1e-15, and the same one at the tightest tolerance that changes anything.
    comparable : bool
        Whether trajectories can be compared. They cannot where all checks differ from the reference by more than
        1e-6: the motion is chaotic, or grazes the threshold of a slip, and statistics are compared instead.
    values : dict of str to float
        The statistics to compare, means over twins; empty where trajectories are compared.
    floors : dict of str to float
        Error, by quantity, below which nothing can be told. Of a trajectory: its smallest difference from a check, and
        at least its rounding. Of a statistic: the difference of two means over twins, of which one in a hundred
        studies would see a larger one though the solver is right (Student's t, shared among all comparisons).
    slips : tuple of int
        The numbers of slips that count as right: those of the reference and of the check that agrees best.
    """

    solver: str
    trajectory: Trajectory
    checks: tuple[Check, ...]
    comparable: bool
    values: dict[str, float]
    floors: dict[str, float]
    slips: tuple[int, ...]


def reference_for(case: Case, comparisons: int = 1) -> Reference:
    """Run a case as accurately as there is a solver for, and find out how accurate that is.

    Parameters
    ----------
    case : Case
    comparisons : int, >= 1
        Number of runs that will be compared with it.

    Returns
    -------
    Reference

    Raises
    ------
    SolverError
        If no solver finishes the case at tolerance 1e-15; the message says why.
    """
    solver, trajectory = _most_accurate(case)
    checks = tuple(_checks(case, solver, trajectory))
    closest = min(checks, key=_largest, default=None)
    comparable = closest is None or _largest(closest) <= _COMPARABLE
    if comparable:
        values: dict[str, float] = {}
        floors = {
            name: max(rounding, closest.differences[name] if closest else 0.0)
            for name, rounding in _rounding(case, trajectory).items()
        }
    else:
        ensemble = twin_statistics(case, solver, TIGHTEST)
        values = {name: float(np.mean(found)) for name, found in ensemble.items()}
        quantile = student.ppf(1.0 - 0.5 * _FALSE_ALARM / (comparisons * len(ensemble)), _TWINS - 1)
        floors = {
            name: float(quantile * np.std(found, ddof=1) * np.sqrt(2.0 / _TWINS)) for name, found in ensemble.items()
        }
    slips = {trajectory.slips, closest.slips if closest else trajectory.slips}
    return Reference(solver, trajectory, checks, comparable, values, floors, tuple(sorted(slips)))


def twin_statistics(case: Case, solver: str, tolerance: float) -> dict[str, list[float]]:
    """Statistics of twins, runs whose starts differ by a billionth: one where motion is chaotic, and then independent.

    Parameters
    ----------
    case : Case
    solver : str
    tolerance : float

    Returns
    -------
    dict of str to list of float
        By statistic, one value a twin.
    """
    starts = [REST._replace(deformation=_TWIN_SPACING * twin) for twin in range(_TWINS)]
    each = [statistics(case, case.run(solver, tolerance, initial=start)) for start in starts]
    return {name: [found[name] for found in each] for name in each[0]}


def _most_accurate(case: Case) -> tuple[str, Trajectory]:
    """The first solver, from the most accurate on, that finishes the case, and its run."""
    available = solvers_for(case.groups, case.scene)
    preferred = [solver for solver in _MOST_ACCURATE_FIRST if solver in available]
    reasons = []
    for solver in preferred:
        try:
            afford(case, solver, TIGHTEST)
            return solver, case.run(solver, TIGHTEST)
        except SolverError as error:
            reasons.append(f"{solver}: {error}")
    raise SolverError(f"no solver gives a reference at tolerance {TIGHTEST:g} ({'; '.join(reasons)})")


def _checks(case: Case, reference_solver: str, trajectory: Trajectory) -> Iterator[Check]:
    """Compare the reference with what else can be run."""
    for solver in solvers_for(case.groups, case.scene):
        for tolerance in _CHECKS if solver == reference_solver else (TIGHTEST,):
            try:
                afford(case, solver, tolerance)
                other = case.run(solver, tolerance)
            except SolverError:
                break  # one that cannot be run checks nothing
            found = differences(case, trajectory, other)
            # The same digits from the same solver are no second opinion.
            if solver != reference_solver or any(found.values()):
                yield Check(solver, tolerance, found, other.slips)
                break


def _largest(check: Check) -> float:
    return max(check.differences.values())


def _rounding(case: Case, trajectory: Trajectory) -> dict[str, float]:
    """Spacing of floating-point numbers at the largest value of each quantity, and at one natural unit at least."""
    return {
        name: float(np.spacing(max(np.abs(values).max(), 1.0))) for name, values in quantities(case, trajectory).items()
    }
