"""Many crawlers, one hold of their valves each: the batched counterpart of `advance`.

By Taylor series crawlers advance in lanes of vector arithmetic. A lane whose crawler has reached the end of its hold
takes the next crawler at once, so that none waits for a neighbour that takes more steps. A step on which something
happens to a crawler, an event or a defect, is taken by the single crawler's own functions.
"""

from typing import Any

import numpy as np
from numba.extending import overload
from numpy.typing import NDArray

from ...compiling.compilation import allocating, compiled, OPTIONS
from ...compiling.vectors import aligned_zeros, LANES
from ..closed_form.affine_lanes import advance_anchored_lanes
from ..loop import advance
from ..model.columns import body_of, coefficients_at, write_body
from ..model.state import Body, NOTHING_YET
from ..motion.sampling import moment_of
from ..steps.options import ClosedForm, DIVERGED, FINISHED, Hold, is_taylor, method_of, Options, OUT_OF_STEPS, Recording
from ..steps.workspace import ROWS, WIDTH
from .alone import load_crawler, step_alone, turn_valve
from .step import (
    COLUMNS,
    CRAWLER,
    DONE,
    ELAPSED,
    HOLD,
    LANE_ROWS,
    REACHED,
    SAMPLE,
    sample_lanes,
    SAMPLING,
    STATE,
    step_lanes,
)

__all__ = ["advance_lanes", "lane_workspace", "one_by_one"]

_BODY = len(Body._fields)


def lane_workspace() -> NDArray[np.float64]:
    """Scratch of one thread, at a cache line's start."""
    return aligned_zeros(LANE_ROWS, COLUMNS, LANES)


def advance_lanes(
    bodies: NDArray[np.float64],
    columns: NDArray[np.float64],
    valves: NDArray[np.int64],
    skip: NDArray[np.bool_],
    begin: int,
    end: int,
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    workspace: NDArray[np.float64],
    statuses: NDArray[np.int8],
    elapsed: NDArray[np.float64],
) -> None:
    """Advance some of n crawlers by one hold each, in compiled code alone.

    Parameters
    ----------
    bodies : (7, n) array
        Fields of `Body` in order, a crawler a column; updated.
    columns : (11, n) array
        Fields of `Coefficients` in order.
    valves : (n,) array
        0 or 1.
    skip : (n,) array of bool
        Crawlers that are left as they are, though in the slice.
    begin, end : int
        Slice of crawlers to advance. Threads take disjoint ones.
    hold : float
    options : Options
        Neither energies nor events are kept. Its step budget is each crawler's own.
    samples : (3, V, n) array
        Receives z, v, p at the times hold (j + 1) / V.
    workspace : array of three axes
        For Taylor series that of `lane_workspace`, one a thread; for the other methods the solver's own, one for each
        crawler or one for all.
    statuses : (n,) array of int8
        Receives FINISHED, DIVERGED or OUT_OF_STEPS.
    elapsed : (n,) array
        Receives the time into the hold that was reached.
    """
    raise NotImplementedError


@overload(advance_lanes, jit_options=OPTIONS | {"_nrt": True})
def _compiled_lanes(
    bodies: NDArray[np.float64],
    columns: NDArray[np.float64],
    valves: NDArray[np.int64],
    skip: NDArray[np.bool_],
    begin: int,
    end: int,
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    workspace: NDArray[np.float64],
    statuses: NDArray[np.int8],
    elapsed: NDArray[np.float64],
) -> Any:
    if is_taylor(options):
        kernel: Any = _in_lanes
    else:
        kernel = _in_closed_form if method_of(options) is ClosedForm else one_by_one
    return kernel.py_func


@allocating
def _in_closed_form(
    bodies: NDArray[np.float64],
    columns: NDArray[np.float64],
    valves: NDArray[np.int64],
    skip: NDArray[np.bool_],
    begin: int,
    end: int,
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    workspace: NDArray[np.float64],
    statuses: NDArray[np.int8],
    elapsed: NDArray[np.float64],
) -> None:
    alike = len(workspace) == 1
    coefficients = coefficients_at(columns, begin)
    opened = np.empty(LANES)
    first = begin
    while first < end:
        last = min(first + LANES, end)
        if alike and coefficients.anchored and last == first + LANES and not skip[first:last].any():
            for lane in range(LANES):
                opened[lane] = valves[first + lane]
            advance_anchored_lanes(first, coefficients, bodies, opened, hold, samples, workspace[0], statuses, elapsed)
        else:
            one_by_one(
                bodies,
                columns,
                valves,
                skip,
                first,
                last,
                hold,
                options,
                samples,
                workspace,
                statuses,
                elapsed,
            )
        first = last


@allocating
def one_by_one(
    bodies: NDArray[np.float64],
    columns: NDArray[np.float64],
    valves: NDArray[np.int64],
    skip: NDArray[np.bool_],
    begin: int,
    end: int,
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    workspace: NDArray[np.float64],
    statuses: NDArray[np.int8],
    elapsed: NDArray[np.float64],
) -> None:
    """`advance_lanes` by the single crawler's functions, whatever the method; `workspace` is then the solver's."""
    count = samples.shape[1]
    own = np.empty((5, count))
    for i in range(begin, end):
        if skip[i]:
            continue
        outcome = advance(
            body_of(bodies, i),
            NOTHING_YET,
            coefficients_at(columns, i),
            Hold(float(valves[i]), hold, 0.0, hold, 0.0),
            options,
            Recording(own, own[:0]),  # no events are kept
            workspace[i if len(workspace) > 1 else 0],
        )
        write_body(outcome.body, bodies, i)
        for j in range(count):
            for row in range(3):
                samples[row, j, i] = own[row, j]
        statuses[i] = outcome.status
        elapsed[i] = outcome.elapsed


@allocating
def _in_lanes(
    bodies: NDArray[np.float64],
    columns: NDArray[np.float64],
    valves: NDArray[np.int64],
    skip: NDArray[np.bool_],
    begin: int,
    end: int,
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    workspace: NDArray[np.float64],
    statuses: NDArray[np.int8],
    elapsed: NDArray[np.float64],
) -> None:
    lanes = workspace
    count = samples.shape[1]
    series = np.empty((ROWS, WIDTH))
    steps = np.zeros(LANES, np.int64)
    queue = _next(begin, end, skip)
    if queue == end:
        return
    active = 0
    for lane in range(LANES):
        # Without enough crawlers the lanes left over idle on the first.
        _load(queue if queue < end else begin, bodies, columns, valves, hold, lanes, lane)
        if queue < end:
            active |= 1 << lane
            queue = _next(queue + 1, end, skip)

    while active:
        calm, last, due, sure = step_lanes(options.method, (options.tolerance, float(count)), lanes)
        rough = active & ~calm
        last &= calm
        due &= active & calm
        lost = 0
        for lane in range(LANES):
            if (rough >> lane) & 1:
                status = step_alone(options, (sure >> lane) & 1 == 1, lanes, lane, series)
                last |= (status == FINISHED) << lane
                lost |= (status == DIVERGED) << lane
                due |= (moment_of(lanes[SAMPLING, DONE, lane], count, hold) <= lanes[SAMPLING, REACHED, lane]) << lane
        while due:
            (more,) = sample_lanes(options.method, (float(count),), lanes)
            for lane in range(LANES):
                if (due >> lane) & 1:
                    i = int(lanes[HOLD, CRAWLER, lane])
                    j = int(lanes[SAMPLING, DONE, lane]) - 1
                    for row in range(3):
                        samples[row, j, i] = lanes[SAMPLE, row, lane]
            due &= more
        for lane in range(LANES):
            steps[lane] += 1
            over = ((last | lost) >> lane) & 1 or steps[lane] >= options.max_steps
            if not (over and (active >> lane) & 1):
                continue
            i = int(lanes[HOLD, CRAWLER, lane])
            for row in range(_BODY):
                bodies[row, i] = lanes[STATE, row, lane]
            elapsed[i] = lanes[STATE, ELAPSED, lane]
            statuses[i] = FINISHED if (last >> lane) & 1 else DIVERGED if (lost >> lane) & 1 else OUT_OF_STEPS
            if queue < end:
                _load(queue, bodies, columns, valves, hold, lanes, lane)
                steps[lane] = 0
                queue = _next(queue + 1, end, skip)
            else:
                active &= ~(1 << lane)


@compiled
def _next(i: int, end: int, skip: NDArray[np.bool_]) -> int:
    """The first crawler from `i` on that is not left as it is; `end` if there is none."""
    while i < end and skip[i]:
        i += 1
    return i


@compiled
def _load(
    i: int,
    bodies: NDArray[np.float64],
    columns: NDArray[np.float64],
    valves: NDArray[np.int64],
    hold: float,
    lanes: NDArray[np.float64],
    lane: int,
) -> None:
    load_crawler(i, bodies, columns, hold, lanes, lane)
    lanes[HOLD, CRAWLER, lane] = i
    turn_valve(float(valves[i]), 0.0, hold, lanes, lane)
