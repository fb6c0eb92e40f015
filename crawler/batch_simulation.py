"""The crawlers of a batch for `simulate`, each by the way that suits it: in lanes, or one by one, on all processors."""

from __future__ import annotations

from collections.abc import Sequence
from threading import Event
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.sharing import share
from .batch.alone import UNFINISHED
from .batch.driving import drive_in_lanes
from .batch.lane_runs import blank_log, blank_runs, Log, Runs
from .model.columns import coefficients_of_each, coefficients_of_one, units_of
from .model.groups import Groups
from .model.scene import Scene
from .model.state import Body, Coefficients
from .motion.balance import Store, store_between, stored_by_crawler
from .runs import run_chain, run_crawler
from .solvers import choose_for_each, NAMES, SOLVERS
from .steps.options import FINISHED, MAX_STEPS, STEPS_A_HOLD

__all__ = ["UNFINISHED", "Batch", "Driven", "drive_batch", "most_steps"]

# The budget is one of work: a chain of many segments may take fewer steps.
_SEGMENTS_A_STEP = 10
_MOST_STEPS = int(np.iinfo(np.int64).max)


class Batch(NamedTuple):
    """Who is driven, row by row."""

    crawlers: Sequence[Groups]
    scenes: Sequence[Scene]
    holds: NDArray[np.float64]
    schedule: NDArray[Any]  # (n, holds): duty cycles
    chains: NDArray[np.bool_]  # (n,): which are chains


class Driven(NamedTuple):
    """What came of n crawlers."""

    runs: Runs
    parts: NDArray[np.float64]  # (n, 2, segments, samples): stretches and rates of segments
    store: Store
    conditions: NDArray[np.float64]  # (n,): nan where not asked for
    solvers: NDArray[np.int8]  # (n,): places of their names in `NAMES`
    logs: list[Log]


def drive_batch(
    batch: Batch,
    body: Body,
    stretches: NDArray[np.float64],
    *,
    solver: str,
    tolerance: float,
    samples_per_hold: int,
    max_steps: int | None,
    condition: bool,
    threads: int,
) -> Driven:
    """Drive all crawlers of a batch; the arguments are those of `simulate`, checked, and where each begins.

    Once a run has failed, later ones may be left out.
    """
    bodies, grounds, units = units_of(batch.crawlers, batch.scenes)
    columns = coefficients_of_each(bodies, grounds)
    solvers = choose_for_each(solver, batch.crawlers, batch.scenes, columns, batch.holds, units, tolerance)
    runs = _runs(batch, body, samples_per_hold, max_steps)
    segments = batch.scenes[0].segments
    parts = runs.samples[:, :2, None]
    if batch.chains.any():
        parts = np.empty((len(units), 2, segments, runs.samples.shape[2]))
    elif segments > 1:
        parts = np.empty(0)

    together = (solvers == NAMES.index("taylor")) & ~batch.chains
    if condition or np.count_nonzero(together) == 1:
        together[:] = False
    growth, size, conditions = np.zeros(len(units)), np.zeros(len(units)), np.full(len(units), np.nan)
    logs = []
    if together.any():
        # In each one's own unit of time.
        inside = runs._replace(coefficients=columns, holds=batch.holds / units)
        inside.bodies[[1, 4]] *= units
        start = stored_by_crawler(Body(*inside.bodies), Coefficients(*columns))
        options = SOLVERS["taylor"].options(tolerance, energy=True, log=True)
        logs = drive_in_lanes(together.nonzero()[0], batch.schedule, inside, options, threads)
        store = store_between(start, stored_by_crawler(Body(*inside.bodies), Coefficients(*columns)))
        growth, size = store
        _to_units_of_groups(runs, logs, units, together)

    def one(i: int, over: Event) -> Log:
        if (runs.statuses[:i] > FINISHED).any():
            return blank_log(0)
        by = SOLVERS[NAMES[solvers[i]]]
        options = by.options(tolerance, energy=True, log=True, tangents=condition, max_steps=int(runs.budgets[i]))
        groups, scene, hold = batch.crawlers[i], batch.scenes[i], float(batch.holds[i])
        duties, samples = batch.schedule[i].astype(np.float64), runs.samples[i]
        if batch.chains[i]:
            chain = run_chain(body, stretches, groups, scene, duties, hold, options, samples, parts[i])
            outcome, finished, events, stored = chain
        else:
            run = run_crawler(
                body, coefficients_of_one(columns, i), float(units[i]), duties, hold, options, samples, by
            )
            outcome, finished, events, stored, conditions[i] = run
        runs.bodies[:, i], runs.ledgers[:, i] = outcome.body, outcome.ledger
        runs.statuses[i], runs.elapsed[i], runs.steps[i] = outcome.status, outcome.elapsed, outcome.steps
        runs.finished[i], runs.events[i] = finished, len(events)
        growth[i], size[i] = stored
        return Log(events[:, 0].copy(), events[:, 1].astype(np.int8), np.full(len(events), i))

    logs += share(one, (~together).nonzero()[0].tolist(), threads)
    if segments > 1:
        uneven = batch.chains if len(parts) else None
        if uneven is None:
            parts = np.repeat(runs.samples[:, :2, None] / segments, segments, axis=2)
        elif not uneven.all():
            parts[~uneven] = runs.samples[~uneven, :2, None] / segments
    return Driven(runs, parts, Store(growth, size), conditions, solvers, logs)


def most_steps(holds: int, segments: int) -> int:
    """Steps that a body may take in all, where nobody says how many."""
    return (MAX_STEPS + STEPS_A_HOLD * holds) // max(1, segments // _SEGMENTS_A_STEP)


def _runs(batch: Batch, body: Body, samples_per_hold: int, max_steps: int | None) -> Runs:
    count, holds = batch.schedule.shape
    if max_steps is None:
        max_steps = most_steps(holds, batch.scenes[0].segments)
    bodies = np.empty((len(body), count))
    bodies.T[:] = body
    try:
        samples = np.empty((count, 5, holds * samples_per_hold))
    except (ValueError, MemoryError):
        schedules = f"{count} schedules of {holds} holds" if count > 1 else f"{holds} holds"
        raise ValueError(
            f"samples_per_hold must leave the samples of {schedules} room in memory, got {samples_per_hold}"
        ) from None
    coefficients = np.empty((len(Coefficients._fields), count))
    return blank_runs(bodies, coefficients, batch.holds, samples, min(max_steps, _MOST_STEPS))


def _to_units_of_groups(runs: Runs, logs: list[Log], units: NDArray[np.float64], together: NDArray[np.bool_]) -> None:
    """Bring what was found in each crawler's own unit of time into that of its groups."""
    other = np.flatnonzero((units != 1.0) & together)
    if len(other) == 0:
        return
    runs.elapsed[other] *= units[other]
    for row in (1, 4):
        runs.samples[other, row] /= units[other, np.newaxis]
    for log in logs:
        log.times[:] *= units[log.crawlers]
