"""One step of several crawlers at once, a crawler a lane, as straight-line vector arithmetic.

The arithmetic is that of the single crawler's step, written by the very same functions, so that a lane's numbers are
the single crawler's to the last bit.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ...compiling.arithmetic import fma, where
from ...compiling.tracing import unrolled_in_lanes
from ...compiling.vectors import LANES
from ..model.equations import moved, pressure_after
from ..model.state import Body, Coefficients, Ledger
from ..motion.energy import posted
from ..motion.events import is_quiet
from ..motion.sampling import is_near, moment_of
from ..steps.taylor import is_sound
from ..steps.taylor_series import energy_nodes, step, step_inputs, value
from ..steps.workspace import CHANGES, END_FORCE, END_V, END_Z, FORCE, LENGTH, STEP, V, WIDTH, Z

__all__ = [
    "BEFORE",
    "BEGIN",
    "CLOSE",
    "COEFFICIENTS",
    "COLUMNS",
    "CRAWLER",
    "DONE",
    "ELAPSED",
    "END",
    "HOLD",
    "LANE_ROWS",
    "LEDGER",
    "MOTION",
    "OPENING",
    "REACHED",
    "SAMPLE",
    "SAMPLING",
    "SLIPS",
    "SPAN",
    "STATE",
    "TANGENTS",
    "TURNED",
    "VALVE",
    "account_lanes",
    "lane_of",
    "sample_lanes",
    "step_lanes",
    "whole_sample_lanes",
]

COLUMNS = WIDTH
# Their numbers lie in registers.
_TIMES_AT_ONCE = 4
# Rows of the lanes' array after Z, V, (P) and FORCE.
STATE, HOLD, COEFFICIENTS, SAMPLING, SAMPLE, END, BEFORE, LEDGER, TANGENTS = range(STEP + 1, STEP + 10)
LANE_ROWS = TANGENTS + CHANGES
# Columns of the row STATE: the fields of `Body`, and the time into the hold.
MOTION, SLIPS, ELAPSED = 5, 6, 7
# Columns of the row HOLD: the pressure when the valve turned, its state, which crawler this is, the length of the
# hold, and the times into it between which the valve stays.
OPENING, VALVE, CRAWLER, SPAN, TURNED, CLOSE = range(6)
# Columns of the row SAMPLING: samples taken, and the times at which the step began and ended. The row BEFORE has the
# fields of `Body` at the step's start, the row LEDGER those of `Ledger`; the rows from TANGENTS on are the tangents' of
# `stability.lyapunov`.
DONE, BEGIN, REACHED = range(3)


def _step(order: int, rows: Any, tolerance: Any, count: Any) -> tuple[dict[int, list[Any]], list[Any]]:
    """The step, taken where nothing happens on it.

    Truths: the lanes that have taken it, those that reach the next turn of their valve if they have, those with samples
    on the way, and those whose series can be trusted to the end of the step.
    """
    body, coefficients = lane_of(rows, STATE)
    elapsed = rows[STATE][ELAPSED]
    valve, hold, turned, close = (rows[HOLD][column] for column in (VALVE, SPAN, TURNED, CLOSE))
    remaining = close - elapsed
    series = step(order, None, *step_inputs(body, coefficients, valve, tolerance, remaining))
    reach: Any = series[STEP]
    length, z, v, expected = (reach[column] for column in (LENGTH, END_Z, END_V, END_FORCE))

    opening = body._replace(pressure=rows[HOLD][OPENING])
    pressure = pressure_after(opening, coefficients, valve, (elapsed - turned) + length)
    end = moved(body, coefficients, z, v, pressure, length)
    quiet = is_quiet(body, coefficients, series[FORCE][0], reach)
    finite = abs(series[V][order + 1]) < float("inf")
    sound = is_sound(coefficients, body.mode, z, v, pressure, expected, tolerance)
    sure = finite & sound
    calm = sure & (coefficients.anchored | quiet) & is_near(end)

    last = length >= remaining
    reached = where(last, close, elapsed + length)
    state = [where(calm, after, before) for after, before in zip(end[:MOTION], body[:MOTION], strict=True)]
    state += [body.mode, body.slips, where(calm, reached, elapsed)]
    done = rows[SAMPLING][DONE]
    reached = where(calm, reached, -1.0)
    due = moment_of(done, count, hold) <= reached
    sampling = [done, elapsed, reached]
    written = {row: series[row] for row in (Z, V, FORCE, STEP)}
    others = {STATE: state, SAMPLING: sampling, END: list(end[:MOTION]), BEFORE: list(body[:SLIPS])}
    return {**written, **others}, [calm, last, due, sure]


def _sampled(order: int, rows: Any, count: Any) -> tuple[Any, ...]:
    """Samples that are taken when the next one is, its time into the step, and its deformation, rate and pressure.

    Last comes the truth: the lanes with yet another.
    """
    body, coefficients = lane_of(rows, BEFORE)
    done, begin, reached = (rows[SAMPLING][column] for column in (DONE, BEGIN, REACHED))
    valve, hold, turned = (rows[HOLD][column] for column in (VALVE, SPAN, TURNED))
    moment = moment_of(done, count, hold)
    t = (moment - begin).smaller(rows[STEP][LENGTH])
    square = t * t
    z, v = (value([rows[row][n] for n in range(order + 2)], t, square) for row in (Z, V))
    opening = body._replace(pressure=rows[HOLD][OPENING])
    pressure = pressure_after(opening, coefficients, valve, moment - turned)
    done = where(moment <= reached, done + 1.0, done)
    return done, t, z, v, pressure, moment_of(done, count, hold) <= reached


def _sample(order: int, rows: Any, count: Any) -> tuple[dict[int, list[Any]], list[Any]]:
    """Deformation, rate and pressure at the next sample of the step that has been taken."""
    done, _, z, v, pressure, more = _sampled(order, rows, count)
    return {SAMPLE: [z, v, pressure], SAMPLING: [done]}, [more]


def _whole_sample(order: int, rows: Any, count: Any) -> tuple[dict[int, list[Any]], list[Any]]:
    """The same with the foot and its velocity."""
    done, t, z, v, pressure, more = _sampled(order, rows, count)
    body, coefficients = lane_of(rows, BEFORE)
    return {SAMPLE: list(moved(body, coefficients, z, v, pressure, t)[:MOTION]), SAMPLING: [done]}, [more]


def _account(order: int, rows: Any) -> tuple[dict[int, list[Any]], list[Any]]:
    """The energies of the step that has been taken, as `account` adds them. Truth: the lanes with a sound ledger."""
    before, coefficients = lane_of(rows, BEFORE)
    after, _ = lane_of(rows, STATE)
    length = rows[STEP][LENGTH]
    gap = before.pressure - rows[HOLD][VALVE]
    pressures = [before.pressure]
    for n in range(1, order + 1):
        gap = gap * (coefficients.lag_rate * (-1.0 / n))
        pressures.append(gap)
    series = [rows[Z][n] for n in range(order + 2)], [rows[V][n] for n in range(order + 2)], pressures
    work = viscous = None
    nodes, weights = energy_nodes(order)
    for weight, (z, v, p) in zip(weights, _at_nodes(series, [length * node for node in nodes]), strict=True):
        power, heat = ((p * z.fma(coefficients.radial_coupling, 1.0)) * v) * weight, (v * v) * weight
        work, viscous = (power, heat) if work is None else (work + power, viscous + heat)
    ledger = Ledger(*(rows[LEDGER][n] for n in range(len(Ledger._fields))))
    viscous = coefficients.damping * (viscous * length)
    ledger = posted(ledger, before, after, coefficients, work * length, viscous)
    return {LEDGER: list(ledger)}, [abs(ledger.flow) < np.inf]


def _at_nodes(series: Sequence[list[Any]], times: Sequence[Any]) -> Iterator[list[Any]]:
    """Values of polynomials at each time; those of a few times at once, for none waits for another."""
    for first in range(0, len(times), _TIMES_AT_ONCE):
        some = times[first : first + _TIMES_AT_ONCE]
        values = [_horner(row, some) for row in series]
        yield from ([each[k] for each in values] for k in range(len(some)))


def _horner(coefficients: list[Any], times: Sequence[Any]) -> list[Any]:
    totals = [fma(t, coefficients[-1], coefficients[-2]) for t in times]
    for coefficient in coefficients[-3::-1]:
        totals = [fma(total, t, coefficient) for total, t in zip(totals, times, strict=True)]
    return totals


def lane_of(rows: Any, state: int) -> tuple[Body, Coefficients]:
    """The bodies in one of the rows STATE and BEFORE, and their coefficients."""
    fields: list[Any] = [*(rows[state][n] for n in range(SLIPS)), rows[STATE][SLIPS]]
    body = Body(*fields)
    numbers: list[Any] = [rows[COEFFICIENTS][n] for n in range(len(Coefficients._fields))]
    return body, Coefficients(*numbers[:-2], *(flag != 0.0 for flag in numbers[-2:]))


step_lanes = unrolled_in_lanes(_step, LANES, 4)
sample_lanes = unrolled_in_lanes(_sample, LANES, 1)
whole_sample_lanes = unrolled_in_lanes(_whole_sample, LANES, 1)
account_lanes = unrolled_in_lanes(_account, LANES, 1)
