"""The work of a block of cells: a plan in, numbers out. Nothing is written here."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.threads import library_threads
from ...crawler import simulate
from ...tasks import BodyReservoir
from ..halving import by_halves
from .inputs import Driving
from .measures import Driven, MEASURES
from .plan import Block, Plan

__all__ = ["FINISHED", "GAVE_UP", "NO_SUCH_BODY", "UNFINISHED", "Job", "measured"]

UNFINISHED, FINISHED, NO_SUCH_BODY, GAVE_UP = range(4)
"""What a cell can be: to be done, done, of a body that cannot be, or of a run that the solver gave up."""


class Job(NamedTuple):
    """A block and what its work depends on."""

    plan: Plan
    block: Block
    threads: int | None = None
    """Most that share it; all processors by default."""


class _Run(NamedTuple):
    body: BodyReservoir
    dither: float
    driving: Driving


def measured(job: Job) -> dict[str, NDArray[Any]]:
    """Drive the crawlers of a block and measure them: the same to the bit wherever and however often it is done.

    Parameters
    ----------
    job : Job

    Returns
    -------
    dict of str to ndarray of shape (cells, seeds) or (cells, seeds, points)
        By variable, not a number where a cell is of no body or the solver gave up; and "status" of shape (cells,).
    """
    plan, block = job.plan, job.block
    cells, seeds = block.last - block.first, len(plan.seeds)
    runs: list[_Run] = []
    places: list[int] = []
    status = np.full(cells, FINISHED, np.int8)
    drawn: dict[float, list[Driving]] = {}
    for cell in range(cells):
        numbers = plan.numbers(block.row, block.first + cell)
        dither = numbers.pop("dither", plan.inputs.dither)
        if dither not in drawn:
            inputs = replace(plan.inputs, dither=dither)
            drawn[dither] = [inputs.drawn(plan.holds, seed) for seed in plan.seeds]
        if not _possible(plan.body, numbers):
            status[cell] = NO_SUCH_BODY
            continue
        body = plan.body.varied(numbers)
        runs += [_Run(body, dither, driving) for driving in drawn[dither]]
        places += range(cell * seeds, (cell + 1) * seeds)
    found = {
        name: np.full((cells * seeds, *([len(plan.points[each.along])] if each.along else [])), np.nan)
        for name, each in plan.variables.items()
    }

    def told(some: Sequence[_Run]) -> dict[str, NDArray[Any]]:
        driven = _drive(plan, some, job.threads)
        return {name: each for measure in plan.measures for name, each in MEASURES[measure].compute(driven).items()}

    with library_threads(1):
        for rows, values in by_halves(told, runs):
            for name, each in values.items():
                found[name][places[rows]] = each
    finished = np.ones(cells * seeds, np.bool_)
    for name, each in found.items():
        finished &= ~np.isnan(each.reshape(cells * seeds, -1)).any(axis=1)
        found[name] = each.reshape(cells, seeds, *each.shape[1:])
    status[(status == FINISHED) & ~finished.reshape(cells, seeds).all(axis=1)] = GAVE_UP
    return {**found, "status": status}


def _possible(body: BodyReservoir, numbers: dict[str, float]) -> bool:
    own = body.groups.to_dict() | numbers
    return own["kinetic_friction"] <= own["static_friction"]


def _drive(plan: Plan, runs: Sequence[_Run], threads: int | None) -> Driven:
    bodies = [run.body for run in runs]
    valve = np.array([run.driving.valve for run in runs])
    motion = simulate(
        [body.groups for body in bodies],
        valve,
        [body.hold for body in bodies],
        scene=[body.scene for body in bodies],
        tolerance=plan.body.tolerance,
        samples_per_hold=plan.body.samples_per_hold,
        threads=threads,
    )
    return Driven(
        bodies=bodies,
        dithers=np.array([run.dither for run in runs]),
        valve=valve,
        messages=np.array([run.driving.message for run in runs]),
        motion=motion,
        delays=plan.delays,
        washout=plan.washout,
        threads=threads,
    )
