"""One step of several crawlers at once, a crawler a lane, as straight-line vector arithmetic.

The arithmetic is that of the single crawler's step, written by the very same functions, so that a lane's numbers are
the single crawler's to the last bit.
"""

from typing import Any

from ...compiling.tracing import unrolled_in_lanes, where
from ...compiling.vectors import LANES
from ..model.equations import moved, pressure_after
from ..model.state import Body, Coefficients
from ..motion.events import is_quiet
from ..motion.loop import is_near, moment_of
from ..steps.taylor import is_sound, step_inputs
from ..steps.taylor_series import step, value
from ..steps.workspace import END_FORCE, END_V, END_Z, FORCE, LENGTH, STEP, V, WIDTH, Z

__all__ = [
    "BEGIN",
    "COEFFICIENTS",
    "COLUMNS",
    "CRAWLER",
    "DONE",
    "ELAPSED",
    "END",
    "HOLD",
    "LANE_ROWS",
    "MOTION",
    "OPENING",
    "REACHED",
    "SAMPLE",
    "SAMPLING",
    "SLIPS",
    "STATE",
    "VALVE",
    "sample_lanes",
    "step_lanes",
]

COLUMNS = WIDTH
# Rows of the lanes' array after Z, V, (P) and FORCE.
STATE, HOLD, COEFFICIENTS, SAMPLING, SAMPLE, END = range(STEP + 1, STEP + 7)
LANE_ROWS = STEP + 7
# Columns of the row STATE: the fields of `Body`, and the time into the hold.
MOTION, SLIPS, ELAPSED = 5, 6, 7
# Columns of the row HOLD: the pressure at its start, its valve, and which crawler this is.
OPENING, VALVE, CRAWLER = range(3)
# Columns of the row SAMPLING: samples taken, and the times at which the step began and ended.
DONE, BEGIN, REACHED = range(3)


def _step(order: int, rows: Any, tolerance: Any, hold: Any, count: Any) -> tuple[dict[int, list[Any]], list[Any]]:
    """The step, taken where nothing happens on it.

    Truths: the lanes that have taken it, those that reach the end of the hold if they have, those with samples on the
    way, and those whose series can be trusted to the end of the step.
    """
    body, coefficients = _lane(rows)
    elapsed = rows[STATE][ELAPSED]
    valve = rows[HOLD][VALVE]
    remaining = hold - elapsed
    series = step(order, None, *step_inputs(body, coefficients, valve, tolerance, remaining))
    reach: Any = series[STEP]
    length, z, v, expected = (reach[column] for column in (LENGTH, END_Z, END_V, END_FORCE))

    opening = body._replace(pressure=rows[HOLD][OPENING])
    pressure = pressure_after(opening, coefficients, valve, elapsed + length)
    end = moved(body, coefficients, z, v, pressure, length)
    quiet = is_quiet(body, coefficients, series[FORCE][0], reach)
    finite = abs(series[V][order + 1]) < float("inf")
    sound = is_sound(coefficients, body.mode, z, v, pressure, expected, tolerance)
    sure = finite & sound
    calm = sure & (coefficients.anchored | quiet) & is_near(end)

    last = length >= remaining
    reached = where(last, hold, elapsed + length)
    state = [where(calm, after, before) for after, before in zip(end[:MOTION], body[:MOTION], strict=True)]
    state += [body.mode, body.slips, where(calm, reached, elapsed)]
    done = rows[SAMPLING][DONE]
    reached = where(calm, reached, -1.0)
    due = moment_of(done, count, hold) <= reached
    sampling = [done, elapsed, reached]
    written = {row: series[row] for row in (Z, V, FORCE, STEP)}
    return {**written, STATE: state, SAMPLING: sampling, END: list(end[:MOTION])}, [calm, last, due, sure]


def _sample(order: int, rows: Any, hold: Any, count: Any) -> tuple[dict[int, list[Any]], list[Any]]:
    """The next sample of the step that has been taken. Truth: the lanes with yet another."""
    body, coefficients = _lane(rows)
    done, begin, reached = (rows[SAMPLING][column] for column in (DONE, BEGIN, REACHED))
    moment = moment_of(done, count, hold)
    t = (moment - begin).smaller(rows[STEP][LENGTH])
    square = t * t
    z, v = (value([rows[row][n] for n in range(order + 2)], t, square) for row in (Z, V))
    opening = body._replace(pressure=rows[HOLD][OPENING])
    pressure = pressure_after(opening, coefficients, rows[HOLD][VALVE], moment)
    done = where(moment <= reached, done + 1.0, done)
    return {SAMPLE: [z, v, pressure], SAMPLING: [done]}, [moment_of(done, count, hold) <= reached]


def _lane(rows: Any) -> tuple[Body, Coefficients]:
    body = Body(*(rows[STATE][n] for n in range(len(Body._fields))))
    numbers: list[Any] = [rows[COEFFICIENTS][n] for n in range(len(Coefficients._fields))]
    return body, Coefficients(*numbers[:-2], *(flag != 0.0 for flag in numbers[-2:]))


step_lanes = unrolled_in_lanes(_step, LANES, 4)
sample_lanes = unrolled_in_lanes(_sample, LANES, 1)
