"""Many crawlers through their schedules on all processors, in lanes where their method has them."""

from itertools import pairwise
from threading import Event
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.sharing import share
from ...compiling.vectors import LANES
from ..model.state import Coefficients
from ..motion import progress
from ..stability.lyapunov import COUNTS, GROWTH_ROWS, start_growth
from ..steps.options import FINISHED, Options
from ..steps.workspace import CHANGES, ROWS, WIDTH
from .advance import lane_workspace
from .growth import Growth
from .lane_runs import ACTIVE, ADMITTED, blank_log, CALL, go_on_in_lanes, Log, LOGGED, QUEUED, Runs, STATE_ROWS

__all__ = ["drive_in_lanes", "grow_in_lanes", "parts_of"]

# Crawlers that one thread takes at once: as many as keep lanes full but for the last few, where there are enough.
_CROWD = 32 * LANES
# Holds that are driven before another thread has woken.
_LEAST_HOLDS = 1000
# Events of a call of compiled code.
_EVENTS = 16_384


def parts_of(count: int, holds: int, threads: int) -> list[slice]:
    """Shares of `count` crawlers that threads take in turn, each of whole blocks of lanes but the last."""
    if threads == 1 or count * holds < _LEAST_HOLDS:
        return [slice(0, count)]
    parts = min(-(-count // LANES), max(threads, -(-count // _CROWD)))
    ends = [min(count, LANES * round(-(-count // LANES) * part / parts)) for part in range(parts + 1)]
    return [slice(begin, end) for begin, end in pairwise(ends)]


def drive_in_lanes(
    crawlers: NDArray[np.int64],
    schedule: NDArray[Any],
    runs: Runs,
    options: Options,
    threads: int,
    growth: Growth | None = None,
) -> list[Log]:
    """Drive crawlers through their schedules by Taylor series, as `drive` does each alone, to the bit.

    Parameters
    ----------
    crawlers : (m,) array
        Places in `runs`, ascending.
    schedule : (n, holds) array
        Duty cycles of all n.
    runs : Runs
        Updated. Once a run has failed those of later crawlers may be left out.
    options : Options
        Events are logged if `options.log`.
    threads : int
        Most that share the work.
    growth : Growth, optional
        Small changes of all n crawlers, which are carried along.

    Returns
    -------
    list of Log
        Those of one crawler in order of time.
    """
    failures: list[int] = []  # where the parts begin that hold one

    def work(part: slice, over: Event) -> list[Log]:
        logs: list[Log] = []
        if any(begin < part.start for begin in failures):
            return logs
        queue = crawlers[part]
        duties = schedule[queue].astype(np.float64)
        state = np.zeros((STATE_ROWS, LANES), np.int64)
        lanes, series, log = lane_workspace(), np.empty((ROWS, WIDTH)), blank_log(_EVENTS)
        state[0, ADMITTED] = len(queue)
        while not over.is_set():
            # Looked up here, so that a test can have more pauses.
            state[0, CALL] = progress.PAUSE_AFTER
            go_on_in_lanes(state, queue, duties, runs, options, log, lanes, series, growth)
            some = slice(int(state[0, LOGGED]))
            logs.append(Log(log.times[some].copy(), log.modes[some].copy(), log.crawlers[some].copy()))
            if state[0, ACTIVE] == 0:
                break
            if (runs.statuses[queue] > FINISHED).any():
                failures.append(part.start)
                state[0, ADMITTED] = state[0, QUEUED]  # those who are in may fail too, and one of them be the first
        return logs

    return [log for logs in share(work, parts_of(len(crawlers), schedule.shape[1], threads), threads) for log in logs]


def grow_in_lanes(
    runs: Runs, schedule: NDArray[Any], washout: int, ends: NDArray[np.int64], options: Options, threads: int
) -> NDArray[np.float64]:
    """Drive crawlers through their schedules by Taylor series, and small changes of them along, as `run_growth` does.

    Parameters
    ----------
    runs : Runs
        Of n crawlers; updated. Once one has failed those of later ones may be left out.
    schedule : (n, holds) array
        Duty cycles.
    washout : int
        Holds after which the changes begin, in the direction that they have turned to.
    ends : (m,) array
        Numbers of holds after the washout, each at least 1, ascending.
    options : Options
    threads : int

    Returns
    -------
    (n, GROWTH_ROWS, m) array
        The rows of `note_growth` after so many holds.
    """
    count, holds = schedule.shape
    growth = Growth(
        np.zeros((count, CHANGES, COUNTS + 1)), np.full(holds, -1), np.zeros((count, GROWTH_ROWS, len(ends)))
    )
    growth.marks[washout + ends - 1] = np.arange(len(ends))
    steps, finished = np.zeros(count, np.int64), np.zeros(count, np.int64)
    for part in (slice(0, washout), slice(washout, None)):
        if (runs.statuses > FINISHED).any() or not len(growth.marks[part]):
            continue
        for changes, *coefficients in zip(growth.changes, *runs.coefficients.tolist(), strict=True):
            start_growth(Coefficients(*coefficients), changes)
        some = growth._replace(marks=growth.marks[part])
        drive_in_lanes(np.arange(count), schedule[:, part], runs, options, threads, some)
        runs.budgets[:] -= runs.steps
        steps, finished = steps + runs.steps, finished + runs.finished
    runs.steps[:], runs.finished[:] = steps, finished
    return growth.grown
