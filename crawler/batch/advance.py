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
from ..model.columns import body_of, coefficients_at, Crawlers, Share, write_body
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
    crawlers: Crawlers, some: Share, hold: float, options: Options, workspace: NDArray[np.float64]
) -> None:
    """Advance some crawlers by one hold each, in compiled code alone.

    Parameters
    ----------
    crawlers : Crawlers
        Updated.
    some : Share
        Those to advance. Threads take disjoint ones.
    hold : float
    options : Options
        Neither energies nor events are kept. Its step budget is each crawler's own.
    workspace : array of three axes
        For Taylor series that of `lane_workspace`, one a thread; for the other methods the solver's own, one for each
        crawler or one for all.
    """
    raise NotImplementedError


@overload(advance_lanes, jit_options=OPTIONS | {"_nrt": True})
def _compiled_lanes(
    crawlers: Crawlers, some: Share, hold: float, options: Options, workspace: NDArray[np.float64]
) -> Any:
    if is_taylor(options):
        kernel: Any = _in_lanes
    else:
        kernel = _in_closed_form if method_of(options) is ClosedForm else one_by_one
    return kernel.py_func


@allocating
def _in_closed_form(
    crawlers: Crawlers, some: Share, hold: float, options: Options, workspace: NDArray[np.float64]
) -> None:
    alike = len(workspace) == 1
    coefficients = coefficients_at(crawlers.coefficients, some.begin)
    opened = np.empty(LANES)
    first = some.begin
    while first < some.end:
        last = min(first + LANES, some.end)
        if alike and coefficients.anchored and last == first + LANES and not some.skip[first:last].any():
            for lane in range(LANES):
                opened[lane] = crawlers.valves[first + lane]
            advance_anchored_lanes(first, crawlers, coefficients, opened, hold, workspace[0])
        else:
            one_by_one(crawlers, Share(first, last, some.skip), hold, options, workspace)
        first = last


@allocating
def one_by_one(crawlers: Crawlers, some: Share, hold: float, options: Options, workspace: NDArray[np.float64]) -> None:
    """`advance_lanes` by the single crawler's functions, whatever the method; `workspace` is then the solver's."""
    count = crawlers.samples.shape[1]
    own = np.empty((5, count))
    for i in range(some.begin, some.end):
        if some.skip[i]:
            continue
        outcome = advance(
            body_of(crawlers.bodies, i),
            NOTHING_YET,
            coefficients_at(crawlers.coefficients, i),
            Hold(float(crawlers.valves[i]), hold, 0.0, hold, 0.0),
            options,
            Recording(own, own[:0]),  # no events are kept
            workspace[i if len(workspace) > 1 else 0],
        )
        write_body(outcome.body, crawlers.bodies, i)
        for j in range(count):
            for row in range(3):
                crawlers.samples[row, j, i] = own[row, j]
        crawlers.statuses[i] = outcome.status
        crawlers.elapsed[i] = outcome.elapsed


@allocating
def _in_lanes(crawlers: Crawlers, some: Share, hold: float, options: Options, workspace: NDArray[np.float64]) -> None:
    lanes = workspace
    count = crawlers.samples.shape[1]
    series = np.empty((ROWS, WIDTH))
    steps = np.zeros(LANES, np.int64)
    queue = _next(some.begin, some)
    if queue == some.end:
        return
    active = 0
    for lane in range(LANES):
        # Without enough crawlers the lanes left over idle on the first.
        _load(queue if queue < some.end else some.begin, crawlers, hold, lanes, lane)
        if queue < some.end:
            active |= 1 << lane
            queue = _next(queue + 1, some)

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
                        crawlers.samples[row, j, i] = lanes[SAMPLE, row, lane]
            due &= more
        for lane in range(LANES):
            steps[lane] += 1
            over = ((last | lost) >> lane) & 1 or steps[lane] >= options.max_steps
            if not (over and (active >> lane) & 1):
                continue
            i = int(lanes[HOLD, CRAWLER, lane])
            for row in range(_BODY):
                crawlers.bodies[row, i] = lanes[STATE, row, lane]
            crawlers.elapsed[i] = lanes[STATE, ELAPSED, lane]
            crawlers.statuses[i] = FINISHED if (last >> lane) & 1 else DIVERGED if (lost >> lane) & 1 else OUT_OF_STEPS
            if queue < some.end:
                _load(queue, crawlers, hold, lanes, lane)
                steps[lane] = 0
                queue = _next(queue + 1, some)
            else:
                active &= ~(1 << lane)


@compiled
def _next(i: int, some: Share) -> int:
    """The first crawler from `i` on that is not left as it is; the end of the slice if there is none."""
    while i < some.end and some.skip[i]:
        i += 1
    return i


@compiled
def _load(i: int, crawlers: Crawlers, hold: float, lanes: NDArray[np.float64], lane: int) -> None:
    load_crawler(i, crawlers.bodies, crawlers.coefficients, hold, lanes, lane)
    lanes[HOLD, CRAWLER, lane] = i
    turn_valve(float(crawlers.valves[i]), 0.0, hold, lanes, lane)
