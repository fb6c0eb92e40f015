"""Many crawlers in lanes, each through its own schedule: the batched counterpart of `drive`.

A lane keeps its crawler from hold to hold and takes the next one when the schedule ends, so that compiled code is left
only to let Python hear of an interrupt, and no crawler waits for another.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, inlined
from ...compiling.vectors import LANES
from ..model.state import Body, Ledger
from ..motion.progress import stretch_at
from ..motion.sampling import moment_of
from ..steps.options import DIVERGED, FINISHED, Options, OUT_OF_STEPS, SAMPLES_A_STEP
from .alone import load_crawler, step_alone, turn_valve, UNFINISHED
from .growth import (
    grow_alone,
    grow_lanes,
    Growth,
    load_changes,
    note_alone,
    rescale_alone,
    saltate_alone,
    write_changes,
)
from .step import (
    account_lanes,
    DONE,
    ELAPSED,
    HOLD,
    LEDGER,
    MOTION,
    REACHED,
    SAMPLE,
    SAMPLING,
    SPAN,
    STATE,
    step_lanes,
    whole_sample_lanes,
)

__all__ = [
    "ACTIVE",
    "ADMITTED",
    "CALL",
    "LOGGED",
    "QUEUED",
    "STATE_ROWS",
    "Log",
    "Runs",
    "blank_log",
    "blank_runs",
    "go_on_in_lanes",
    "write_in_order",
]

_BODY, _LEDGER = len(Body._fields), len(Ledger._fields)
# Of the array that a run in lanes goes on from: the next crawler in the queue, how many of the queue may enter, the
# lanes in use as bits, events written and steps of a call; below, lane by lane, the crawler's place in the queue, the
# stretch of its valve, its steps, and how many it may take.
QUEUED, ADMITTED, ACTIVE, LOGGED, CALL = range(5)
PLACE, STRETCH, STEPS, BUDGET = range(4)
STATE_ROWS = 5


class Runs(NamedTuple):
    """n crawlers that are driven, and what comes of it."""

    bodies: NDArray[np.float64]  # (7, n): the fields of `Body`, updated
    coefficients: NDArray[np.float64]  # (11, n): the fields of `Coefficients`
    holds: NDArray[np.float64]  # (n,)
    budgets: NDArray[np.int64]  # (n,): steps that each may take
    samples: NDArray[np.float64]  # (n, 5, holds * samples_per_hold): z, v, p, x, w
    ledgers: NDArray[np.float64]  # (4, n): the fields of `Ledger`
    statuses: NDArray[np.int8]  # (n,)
    elapsed: NDArray[np.float64]  # (n,): into the last hold begun
    finished: NDArray[np.int64]  # (n,): holds
    steps: NDArray[np.int64]  # (n,)
    events: NDArray[np.int64]  # (n,): how many


def blank_runs(
    bodies: NDArray[np.float64],
    coefficients: NDArray[np.float64],
    holds: NDArray[np.float64],
    samples: NDArray[np.float64],
    budget: int,
) -> Runs:
    """Runs that have not begun, each of which may take as many steps."""
    count = len(holds)
    return Runs(
        bodies,
        coefficients,
        holds,
        np.full(count, budget, np.int64),
        samples,
        np.zeros((_LEDGER, count)),
        np.full(count, UNFINISHED, np.int8),
        np.zeros(count),
        np.zeros(count, np.int64),
        np.zeros(count, np.int64),
        np.zeros(count, np.int64),
    )


class Log(NamedTuple):
    """Events as they come."""

    times: NDArray[np.float64]
    modes: NDArray[np.int8]  # that begin
    crawlers: NDArray[np.int64]


class _Traffic(NamedTuple):
    """Who is to pass through the lanes, and who is in them."""

    queue: NDArray[np.int64]
    schedule: NDArray[np.float64]
    runs: Runs
    lanes: NDArray[np.float64]
    control: NDArray[np.int64]
    places: NDArray[np.int64]


def blank_log(capacity: int) -> Log:
    """Room for so many events."""
    return Log(np.empty(capacity), np.empty(capacity, np.int8), np.empty(capacity, np.int64))


@compiled
def go_on_in_lanes(
    state: NDArray[np.int64],
    queue: NDArray[np.int64],
    schedule: NDArray[np.float64],
    runs: Runs,
    options: Options,
    log: Log,
    lanes: NDArray[np.float64],
    series: NDArray[np.float64],
    growth: Growth | None,
) -> None:
    """Drive crawlers through their schedules, by Taylor series, until the next pause.

    Parameters
    ----------
    state : (STATE_ROWS, LANES) array
        Zero at first but for the steps of a call and the length of the queue. Where its element ACTIVE is zero
        afterwards all is done.
    queue : (m,) array
        The crawlers to be driven.
    schedule : (m, holds) array
        Duty cycles of each in the queue.
    runs : Runs
    options : Options
        Events are logged if `options.log`, and energies kept if `options.energy`. Budgets are those of `runs`.
    log : Log
        Of LANES events at least; written from the first on after each pause.
    lanes : (LANE_ROWS, COLUMNS, LANES) array
        Scratch that the next call goes on with.
    series : (ROWS, WIDTH) array
        Scratch.
    growth : Growth or None
        Small changes of the crawlers, if they are to be carried along.
    """
    count = runs.samples.shape[2] // schedule.shape[1]
    control, places = state[0], state[1:]
    traffic = _Traffic(queue, schedule, runs, lanes, control, places)
    control[LOGGED] = 0
    if control[QUEUED] == 0:
        for lane in range(LANES):
            # Without enough crawlers the lanes left over idle on the first.
            control[ACTIVE] |= (lane < len(queue)) << lane
            _enter(lane if lane < len(queue) else 0, traffic, lane, growth)
        control[QUEUED] = min(LANES, len(queue))
    left = control[CALL]
    while control[ACTIVE] != 0 and left > 0 and control[LOGGED] + LANES <= len(log.times):
        left -= LANES
        active = control[ACTIVE]
        calm, last, due, sure = step_lanes(options.method, (options.tolerance, float(count)), lanes)
        rough = active & ~calm
        last &= active & calm
        due &= active & calm
        lost = turned = 0
        for lane in range(LANES):
            if (rough >> lane) & 1:
                mode = lanes[STATE, MOTION, lane]
                status = step_alone(options, (sure >> lane) & 1 == 1, lanes, lane, series)
                last |= (status == FINISHED) << lane
                lost |= (status == DIVERGED) << lane
                moment = moment_of(lanes[SAMPLING, DONE, lane], count, lanes[HOLD, SPAN, lane])
                due |= (moment <= lanes[SAMPLING, REACHED, lane]) << lane
                turned |= (lanes[STATE, MOTION, lane] != mode) << lane
                if options.log and (turned >> lane) & 1:
                    _write_event(traffic, lane, log)
        sampled = 0
        while due:
            sampled += LANES
            (more,) = whole_sample_lanes(options.method, (float(count),), lanes)
            for lane in range(LANES):
                if (due >> lane) & 1:
                    column = places[STRETCH, lane] // 2 * count + int(lanes[SAMPLING, DONE, lane]) - 1
                    into = runs.samples[queue[places[PLACE, lane]]]
                    for row in range(5):
                        into[row, column] = lanes[SAMPLE, row, lane]
            due &= more
        left -= sampled // SAMPLES_A_STEP
        if options.energy:
            account_lanes(options.method, (), lanes)
        if growth is not None:
            _grow(options, active & ~lost, turned, traffic, series)
        spent = 0
        for lane in range(LANES):
            places[STEPS, lane] += 1
            spent |= (places[STEPS, lane] >= places[BUDGET, lane]) << lane
        for lane in range(LANES):
            if ((active & (last | lost | spent)) >> lane) & 1:
                reached = (last >> lane) & 1 == 1
                status = DIVERGED if (lost >> lane) & 1 else FINISHED
                _go_on(reached, status, traffic, lane, growth)


@compiled
def _grow(options: Options, moved: int, turned: int, traffic: _Traffic, series: NDArray[np.float64]) -> None:
    """Carry the changes of the lanes that have moved over their steps, and over the events that ended some of these."""
    lanes, places = traffic.lanes, traffic.places
    sound, handy = grow_lanes(options.method, (options.tolerance,), lanes)
    alone = moved & ~(sound & handy & ~turned)
    for lane in range(LANES):
        if (alone >> lane) & 1:
            if not (sound >> lane) & 1:
                grow_alone(options.order, lanes, lane, series)
            elif not (handy >> lane) & 1:
                rescale_alone(lanes, lane)
            if (turned >> lane) & 1:
                time = places[STRETCH, lane] // 2 * lanes[HOLD, SPAN, lane] + lanes[STATE, ELAPSED, lane]
                saltate_alone(time, lanes, lane)


@inlined
def _go_on(reached: bool, status: int, traffic: _Traffic, lane: int, growth: Growth | None) -> None:
    """After a step: let the valve turn if its time is `reached`, and the next crawler enter if this one has ended."""
    runs, lanes, control, places = traffic.runs, traffic.lanes, traffic.control, traffic.places
    i, duties = traffic.queue[places[PLACE, lane]], traffic.schedule[places[PLACE, lane]]
    spent = places[STEPS, lane] >= places[BUDGET, lane]
    stretch = places[STRETCH, lane]
    if reached:
        stretch = _next_stretch(stretch + 1, duties, runs.holds[i])
        if growth is not None and stretch // 2 > places[STRETCH, lane] // 2:
            mark = growth.marks[places[STRETCH, lane] // 2]
            if mark >= 0:
                note_alone(lanes, lane, growth.grown[i, :, mark])
        if stretch < 2 * len(duties):
            if stretch // 2 > places[STRETCH, lane] // 2:
                lanes[SAMPLING, DONE, lane] = 0.0
            places[STRETCH, lane] = stretch
            part = stretch_at(stretch, duties, runs.holds[i])
            turn_valve(part.valve, part.begin, part.end, lanes, lane)
            reached = False
    if not reached and status == FINISHED:
        if not spent:
            return
        status = OUT_OF_STEPS
    for row in range(_BODY):
        runs.bodies[row, i] = lanes[STATE, row, lane]
    for row in range(_LEDGER):
        runs.ledgers[row, i] = lanes[LEDGER, row, lane]
    if growth is not None:
        write_changes(lanes, lane, growth.changes[i])
    runs.statuses[i] = status
    runs.elapsed[i] = lanes[STATE, ELAPSED, lane]
    runs.finished[i] = stretch // 2
    runs.steps[i] = places[STEPS, lane]
    if control[QUEUED] < control[ADMITTED]:
        _enter(control[QUEUED], traffic, lane, growth)
        control[QUEUED] += 1
    else:
        control[ACTIVE] &= ~(1 << lane)


@compiled
def _enter(place: int, traffic: _Traffic, lane: int, growth: Growth | None) -> None:
    """Let a crawler of the queue enter a lane."""
    runs, lanes, places = traffic.runs, traffic.lanes, traffic.places
    i, duties = traffic.queue[place], traffic.schedule[place]
    load_crawler(i, runs.bodies, runs.coefficients, runs.holds[i], lanes, lane)
    for row in range(_LEDGER):
        lanes[LEDGER, row, lane] = 0.0
    if growth is not None:
        load_changes(growth.changes[i], lanes, lane)
    stretch = _next_stretch(0, duties, runs.holds[i])
    places[PLACE, lane], places[STRETCH, lane] = place, stretch
    places[STEPS, lane], places[BUDGET, lane] = 0, runs.budgets[i]
    part = stretch_at(stretch, duties, runs.holds[i])
    turn_valve(part.valve, part.begin, part.end, lanes, lane)


@compiled
def _next_stretch(stretch: int, schedule: NDArray[np.float64], hold: float) -> int:
    """The first stretch of the valve from `stretch` on that is not empty; past the last if there is none."""
    for other in range(stretch, 2 * len(schedule)):
        part = stretch_at(other, schedule, hold)
        if part.begin < part.end:
            return other
    return 2 * len(schedule)


@compiled
def _write_event(traffic: _Traffic, lane: int, log: Log) -> None:
    runs, lanes, control, places = traffic.runs, traffic.lanes, traffic.control, traffic.places
    i, k = traffic.queue[places[PLACE, lane]], control[LOGGED]
    log.times[k] = places[STRETCH, lane] // 2 * lanes[HOLD, SPAN, lane] + lanes[STATE, ELAPSED, lane]
    log.modes[k] = int(lanes[STATE, MOTION, lane])
    log.crawlers[k] = i
    runs.events[i] += 1
    control[LOGGED] = k + 1


@compiled
def write_in_order(
    log: Log,
    places: NDArray[np.int64],
    times: NDArray[np.float64],
    modes: NDArray[np.int8],
    crawlers: NDArray[np.int64],
) -> None:
    """Write events crawler by crawler; `places` tells where each crawler's next event belongs, and is updated."""
    for k in range(len(log.times)):
        crawler = log.crawlers[k]
        place = places[crawler]
        times[place], modes[place], crawlers[place] = log.times[k], log.modes[k], crawler
        places[crawler] = place + 1
