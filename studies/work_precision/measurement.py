"""Work and precision: what error each solver makes at each tolerance, and how long it takes."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...common.validation import whole_number
from ...crawler import SolverError
from ...crawler.solvers import solvers_for
from .case import afford, Case, differences, SLIP_RATE
from .reference import Reference, reference_for, TIGHTEST, twin_statistics

__all__ = ["TOLERANCES", "Omission", "Row", "Timing", "WorkPrecision", "measure"]

TOLERANCES = tuple(10.0**-k for k in range(2, 15))
_FEWEST_ROUNDS = 3
_LONGEST_TIMING = 5.0  # seconds over all rounds of one row
# Processor time, where it is fine enough: what else the machine does is no cost of a solver's.
_clock = time.thread_time if time.get_clock_info("thread_time").resolution <= 1e-6 else time.perf_counter


class Timing(NamedTuple):
    """Quartiles over the rounds of the processor time of a call of `simulate`, microseconds per natural time unit."""

    low: float
    median: float
    high: float


@dataclass(frozen=True)
class Row:
    """What one solver does at one tolerance.

    Attributes
    ----------
    solver : str
    tolerance : float or None
        None where the tolerance changes nothing: that solver is as exact as it gets.
    errors : dict of str to float
        By quantity, natural units: largest difference from the reference over the samples, or difference of the means
        over twins where statistics are compared.
    slips : int
    slips_agree : bool
        Whether the count is the reference's, or, where statistics are compared, its mean is within the floor.
    timing : Timing
    """

    solver: str
    tolerance: float | None
    errors: dict[str, float]
    slips: int
    slips_agree: bool
    timing: Timing

    @property
    def name(self) -> str:
        """Solver and tolerance, as they are asked for."""
        return self.solver if self.tolerance is None else f"{self.solver} at tolerance {self.tolerance:.0e}"


class Omission(NamedTuple):
    """A solver and tolerance that could not be measured, and why."""

    solver: str
    tolerance: float
    reason: str


@dataclass(frozen=True)
class WorkPrecision:
    """The rows of one case.

    Attributes
    ----------
    case : Case
    reference : Reference
    rows : tuple of Row
        Solver by solver, from the loosest tolerance to the tightest.
    omissions : tuple of Omission
    call : float
        Median time of a call of `simulate` that advances one hold only, microseconds: mostly Python's own.
    """

    case: Case
    reference: Reference
    rows: tuple[Row, ...]
    omissions: tuple[Omission, ...]
    call: float

    @property
    def title(self) -> str:
        """What was run."""
        return f"errors and time, {self.case.holds} random holds of {self.case.hold:g}, seed {self.case.seed}"

    @property
    def notes(self) -> list[str]:
        """What the numbers rest on, a sentence each."""
        reference = self.reference
        checks = [
            f"{check.solver} at {check.tolerance:.0e} differs by {max(check.differences.values()):.1e}"
            for check in reference.checks
        ]
        sentences = [
            f"Reference: {reference.solver} at {TIGHTEST:.0e}; {', '.join(checks) or 'nothing to check it by'}."
        ]
        if not reference.comparable:
            sentences.append(
                "Trajectories are not comparable here: a change in the last digit grows until nothing is shared. "
                "Compared are statistics, each a mean over twins, runs whose starts differ by a billionth."
            )
        for solver in dict.fromkeys(omission.solver for omission in self.omissions):
            mine = [omission for omission in self.omissions if omission.solver == solver]
            tolerances = ", ".join(f"{omission.tolerance:.0e}" for omission in mine)
            sentences.append(f"Left out: {solver} at {tolerances}: {mine[-1].reason}.")
        sentences.append(
            "Time is processor time of whole calls of simulate, median and quartiles, nothing subtracted; what a call "
            f"costs before the body moves, {self.call:.0f} µs or less, makes {self.call / self.case.duration:.2f} µs "
            "per time unit of it."
        )
        return sentences

    def error(self, row: Row, quantity: str) -> float:
        """Error of a row as far as it can be told: at least the reference's floor."""
        return max(row.errors[quantity], self.reference.floors[quantity])

    def largest_error(self, row: Row) -> float:
        """The largest over the quantities."""
        return max(self.error(row, quantity) for quantity in row.errors)

    def to_dict(self) -> dict[str, Any]:
        """All that was measured, by the names of the attributes, ready for JSON."""
        reference = self.reference
        return {
            "groups": self.case.groups.to_dict(),
            "scene": self.case.scene.to_dict(),
            "hold": self.case.hold,
            "holds": self.case.holds,
            "seed": self.case.seed,
            "compared": "trajectories" if reference.comparable else "statistics",
            "reference": {
                "solver": reference.solver,
                "tolerance": TIGHTEST,
                "slips": reference.slips,
                "values": reference.values,
                "floors": reference.floors,
                "checks": [vars(check) for check in reference.checks],
            },
            "rows": [{**vars(row), "timing": row.timing._asdict()} for row in self.rows],
            "call": self.call,
            "omissions": [omission._asdict() for omission in self.omissions],
        }


def measure(
    case: Case, *, rounds: int = 31, on_progress: Callable[[int, int], Any] = lambda done, total: None
) -> WorkPrecision:
    """Measure error and time of every solver that takes a case, at every tolerance.

    Timed, in processor time, are whole calls of `simulate` on the whole case, with all that they do: arguments checked,
    memory allocated, energy accounted for, events logged. Nothing is subtracted. The calls take turns, round after
    round, so that the machine's drift falls on all alike; one that is slow takes fewer turns, three at least.

    Parameters
    ----------
    case : Case
    rounds : int, >= 1
    on_progress : callable
        Told how many of how many measurements are done.

    Returns
    -------
    WorkPrecision

    Raises
    ------
    ValueError, TypeError
        If `rounds` is no such number.
    SolverError
        If no solver gives a reference, or none can be measured.
    """
    whole_number("rounds", rounds, 1)
    solvers = solvers_for(case.groups, case.scene)
    asked = [(solver, tolerance) for solver in solvers for tolerance in TOLERANCES]
    total = len(asked) + rounds
    on_progress(0, total)
    reference = reference_for(case, comparisons=len(asked))
    judgements: list[_Judgement] = []
    omissions: list[Omission] = []
    for done, (solver, tolerance) in enumerate(asked, 1):
        try:
            judgements.append(_judge(case, reference, solver, tolerance))
        except SolverError as error:
            omissions.append(Omission(solver, tolerance, str(error)))
        on_progress(done, total)
    if not judgements:
        raise SolverError(f"no solver can be measured; the first fails because {omissions[0].reason}")
    distinct = [judgement for solver in solvers for judgement in _distinct(judgements, solver)]
    timings = _timings(case, distinct, rounds, lambda done: on_progress(len(asked) + done, total))
    rows = tuple(Row(*judgement, timing) for judgement, timing in zip(distinct, timings, strict=True))
    call = float(np.median([_seconds(case, distinct[0], holds=1) for _ in range(rounds)]))
    return WorkPrecision(case, reference, rows, tuple(omissions), 1e6 * call)


class _Judgement(NamedTuple):
    """A row that has not been timed."""

    solver: str
    tolerance: float | None
    errors: dict[str, float]
    slips: int
    slips_agree: bool


def _judge(case: Case, reference: Reference, solver: str, tolerance: float) -> _Judgement:
    """Compare one run with the reference."""
    afford(case, solver, tolerance)
    run = case.run(solver, tolerance)
    if reference.comparable:
        errors = differences(case, run, reference.trajectory)
        return _Judgement(solver, tolerance, errors, run.slips, run.slips in reference.slips)
    means = {name: np.mean(found) for name, found in twin_statistics(case, solver, tolerance).items()}
    errors = {name: float(abs(mean - reference.values[name])) for name, mean in means.items()}
    agree = SLIP_RATE not in errors or errors[SLIP_RATE] <= reference.floors[SLIP_RATE]
    return _Judgement(solver, tolerance, errors, run.slips, agree)


def _distinct(judgements: list[_Judgement], solver: str) -> list[_Judgement]:
    """The judgements of one solver, or one alone where its tolerance changes nothing."""
    mine = [judgement for judgement in judgements if judgement.solver == solver]
    if len(mine) > 1 and all(judgement.errors == mine[0].errors for judgement in mine):
        return [mine[0]._replace(tolerance=None)]
    return mine


def _seconds(case: Case, judgement: _Judgement, *, holds: int | None = None) -> float:
    """Time of one call, for the whole case or its first holds."""
    tolerance = TOLERANCES[0] if judgement.tolerance is None else judgement.tolerance
    start = _clock()
    case.run(judgement.solver, tolerance, holds=holds)
    return _clock() - start


def _timings(case: Case, judgements: list[_Judgement], rounds: int, on_round: Callable[[int], Any]) -> list[Timing]:
    """Time every run in turn, round after round."""
    seconds: list[list[float]] = [[] for _ in judgements]
    turns = range(len(judgements))
    for done in range(rounds):
        # Every other round runs backward, so that none is always the first.
        for turn in turns if done % 2 == 0 else reversed(turns):
            if len(seconds[turn]) >= _FEWEST_ROUNDS and sum(seconds[turn]) > _LONGEST_TIMING:
                continue
            seconds[turn].append(_seconds(case, judgements[turn]))
        on_round(done + 1)
    quartiles = [1e6 / case.duration * np.quantile(each, [0.25, 0.5, 0.75]) for each in seconds]
    return [Timing(*map(float, each)) for each in quartiles]
