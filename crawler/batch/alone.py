"""What happens to one lane by itself: a crawler that enters it, its valve that turns, and a step with an event."""

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, inlined
from ..model.columns import body_of, coefficients_at, write_body
from ..model.equations import pressure_after
from ..model.state import Body, Coefficients
from ..motion.events import jump, next_event
from ..motion.sampling import end_of_step, is_near
from ..steps.options import DIVERGED, FINISHED, Options
from ..steps.taylor import state_at, trusted
from ..steps.workspace import FORCE, LENGTH, STEP, V, Z
from .step import (
    CLOSE,
    COEFFICIENTS,
    DONE,
    ELAPSED,
    END,
    HOLD,
    OPENING,
    REACHED,
    SAMPLING,
    SPAN,
    STATE,
    TURNED,
    VALVE,
)

__all__ = ["UNFINISHED", "load_crawler", "step_alone", "turn_valve"]

_BODY = len(Body._fields)
_COEFFICIENTS = len(Coefficients._fields)
UNFINISHED = -1  # a run that was left out, too, since one before it has failed


@compiled
def load_crawler(
    i: int,
    bodies: NDArray[np.float64],
    columns: NDArray[np.float64],
    hold: float,
    lanes: NDArray[np.float64],
    lane: int,
) -> None:
    """Put the crawler of a column into a lane, at the start of a hold."""
    for row in range(_BODY):
        lanes[STATE, row, lane] = bodies[row, i]
    for row in range(_COEFFICIENTS):
        lanes[COEFFICIENTS, row, lane] = columns[row, i]
    lanes[HOLD, SPAN, lane] = hold
    lanes[SAMPLING, DONE, lane] = 0.0


@compiled
def turn_valve(valve: float, turned: float, close: float, lanes: NDArray[np.float64], lane: int) -> None:
    """Let the valve of a lane be open or shut between two times into the hold, the first of which is now."""
    lanes[STATE, ELAPSED, lane] = turned
    lanes[HOLD, OPENING, lane] = lanes[STATE, 2, lane]
    lanes[HOLD, VALVE, lane] = valve
    lanes[HOLD, TURNED, lane] = turned
    lanes[HOLD, CLOSE, lane] = close


@inlined
def step_alone(
    options: Options,
    sure: bool,
    lanes: NDArray[np.float64],
    lane: int,
    series: NDArray[np.float64],
) -> int:
    """Take a lane's step as `advance` would, from the series that the lane has; return the status.

    Its samples are left to be taken with those of the other lanes.
    """
    order = options.order
    for row in (Z, V, FORCE, STEP):
        for n in range(order + 2):
            series[row, n] = lanes[row, n, lane]
    coefficients = coefficients_at(lanes[COEFFICIENTS], lane)
    body = body_of(lanes[STATE], lane)
    before = lanes[STATE, ELAPSED, lane]
    valve, turned, close = lanes[HOLD, VALVE, lane], lanes[HOLD, TURNED, lane], lanes[HOLD, CLOSE, lane]
    opening = Body(body.deformation, body.velocity, lanes[HOLD, OPENING, lane], body.foot, 0.0, 0, 0)
    if sure:
        longest = series[STEP, LENGTH]
        end = Body(
            lanes[END, 0, lane],
            lanes[END, 1, lane],
            lanes[END, 2, lane],
            lanes[END, 3, lane],
            lanes[END, 4, lane],
            body.mode,
            body.slips,
        )
    else:
        longest, end = trusted(opening, body, coefficients, valve, before - turned, options.tolerance, order, series)
        if not longest >= 0.0:
            return DIVERGED
    length, mode = next_event(body, end, coefficients, valve, order, longest, options.tolerance, 0.0, series)
    reached, last = end_of_step(body, close, before, length, mode)
    following = end
    if length < longest:
        pressure = pressure_after(opening, coefficients, valve, reached - turned)
        following = state_at(body, coefficients, pressure, order, length, series)
    lanes[STEP, LENGTH, lane] = length
    lanes[SAMPLING, REACHED, lane] = reached
    if not is_near(following):
        return DIVERGED
    if mode != body.mode:
        following = jump(following, mode, coefficients)
    write_body(following, lanes[STATE], lane)
    lanes[STATE, ELAPSED, lane] = reached
    return FINISHED if last else UNFINISHED
