"""One crawler, one stretch of a constant valve: the loop in which the body's state moves, whatever makes its steps.

The pressure is closed form. Between events z and v are polynomials; the foot follows from the momentum, on which
friction and slope alone act. A step ends at whichever comes first: its error bound, the first descent of an event
function through zero, or the end of the stretch: of the hold, or of the part of it that the valve is open or shut.
"""

import math
from typing import Any

import numpy as np
from numba.extending import overload
from numpy.typing import NDArray

from ...compiling.compilation import compiled, formula, OPTIONS
from ..model.equations import pressure_after
from ..model.state import Body, Coefficients, Ledger
from ..steps.options import (
    AFRESH,
    DIVERGED,
    FINISHED,
    is_taylor,
    Leg,
    LOG_FULL,
    Options,
    OUT_OF_STEPS,
    Outcome,
    Pace,
    PAUSED,
)
from ..steps.radau import radau_step, refine_event_step
from ..steps.taylor import state_at, taylor_step
from .energy import account
from .events import jump, next_event
from .tangent import carry, saltate

__all__ = ["FARTHEST", "advance", "end_of_step", "is_near", "moment_of", "record", "sampled_by"]

# No bounded body stretches so far; beyond, a float32 observation and the squares of the motion would soon overflow.
FARTHEST = 1e12


def next_step(
    opening: Body,
    body: Body,
    coefficients: Coefficients,
    valve: float,
    elapsed: float,
    remaining: float,
    options: Options,
    pace: Pace,
    series: NDArray[np.float64],
) -> tuple[float, Body, Pace]:
    """One step of the method of the options, in compiled code alone: see `taylor_step`."""
    raise NotImplementedError


@overload(next_step, jit_options=OPTIONS)
def _compiled_step(
    opening: Body,
    body: Body,
    coefficients: Coefficients,
    valve: float,
    elapsed: float,
    remaining: float,
    options: Options,
    pace: Pace,
    series: NDArray[np.float64],
) -> Any:
    return taylor_step if is_taylor(options) else radau_step


@compiled
def advance(
    body: Body,
    ledger: Ledger,
    coefficients: Coefficients,
    valve: float,
    hold: float,
    options: Options,
    start: float,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: NDArray[np.float64],
    begin: float = 0.0,
    end: float = math.inf,
    leg: Leg | None = None,
) -> Outcome:
    """Advance one crawler by one hold of the valve, or by a part of one.

    Parameters
    ----------
    body, ledger : Body, Ledger
        State and energies at the start of the hold.
    coefficients : Coefficients
    valve : float
        0 or 1, constant from `begin` to `end`.
    hold : float
        Length of the hold, natural time.
    options : Options
    start : float
        Time at which the hold begins; only the events' times depend on it.
    samples : (5, S) array
        Receives z, v, p, x, w at those of the times hold (j + 1) / S that are after `begin` and not after `end`.
    events : (capacity, 2) array
        Receives the time and the new motion of each event if `options.log`. Where it is too short the outcome says
        LOG_FULL, and the hold is to be done again from its start with a longer one.
    workspace : (ROWS, WIDTH) array
        Scratch.
    begin, end : float
        Time into the hold, the whole of it by default.
    leg : Leg, optional
        Where to go on, with the state, the ledger, the samples and the workspace that a pause left; without one the
        stretch is advanced from its begin, and without a pause.

    Returns
    -------
    Outcome
    """
    opening = body
    elapsed = begin
    pace = AFRESH
    allowed = options.max_steps
    if leg is not None:
        opening = leg.opening
        elapsed = leg.elapsed
        pace = leg.pace
        allowed = min(allowed, leg.steps)
    done = sampled_by(elapsed, hold, samples.shape[1])
    logged = 0
    close = min(end, hold)
    for steps in range(1, allowed + 1):
        longest, ahead, pace = next_step(
            opening, body, coefficients, valve, elapsed - begin, close - elapsed, options, pace, workspace
        )
        if not longest >= 0.0:
            return Outcome(DIVERGED, elapsed, steps, logged, body, ledger, pace)
        length, mode = next_event(
            body, ahead, coefficients, valve, options.order, longest, options.tolerance, pace.doubt, workspace
        )
        if mode != body.mode:
            pace = refine_event_step(body, coefficients, options.tolerance, pace, length)
            if pace.length > 0.0:
                continue

        reached, last = end_of_step(body, close, elapsed, length, mode)
        count = samples.shape[1]
        while done < count:
            moment = moment_of(done, count, hold)
            if moment > reached:
                break
            # The pressure is that of this very moment, not of a step's end within rounding of it.
            pressure = pressure_after(opening, coefficients, valve, moment - begin)
            since = min(moment - elapsed, length)
            record(state_at(body, coefficients, pressure, options.order, since, workspace), samples, done)
            done += 1
        following = ahead
        if length < longest:
            pressure = pressure_after(opening, coefficients, valve, reached - begin)
            following = state_at(body, coefficients, pressure, options.order, length, workspace)
        if not is_near(following):
            return Outcome(DIVERGED, elapsed, steps, logged, body, ledger, pace)
        if options.energy:
            ledger = account(ledger, body, following, coefficients, options.method, length, workspace)
        if options.tangents:
            carry(body, coefficients, options.order, length, workspace)
        elapsed = reached
        if mode != body.mode:
            if options.tangents:
                saltate(following, mode, coefficients, valve, start + elapsed, workspace)
            following = jump(following, mode, coefficients)
            if options.log:
                if logged == events.shape[0]:
                    return Outcome(LOG_FULL, elapsed, steps, logged, body, ledger, pace)
                events[logged, 0] = start + elapsed
                events[logged, 1] = mode
                logged += 1
        body = following
        if last:
            return Outcome(FINISHED, close, steps, logged, body, ledger, pace)
    status = PAUSED if allowed < options.max_steps else OUT_OF_STEPS
    return Outcome(status, elapsed, allowed, logged, body, ledger, pace)


@compiled
def end_of_step(body: Body, close: float, elapsed: float, length: float, mode: int) -> tuple[float, bool]:
    """Time into the hold that a step of `length` reaches, and whether that is `close`, up to which the valve is kept.

    The last step ends on that itself, so that no sample is lost to the rounding of a sum.
    """
    last = mode == body.mode and length >= close - elapsed
    return close if last else elapsed + length, last


@formula
def moment_of(done: float, count: float, hold: float) -> float:
    """Time into the hold of the sample after `done` of `count`."""
    return hold * ((done + 1.0) / count)


@formula
def is_near(body: Body) -> bool:
    """Whether the body is finite, and where a body can be."""
    return abs(body.deformation) + abs(body.velocity) + abs(body.foot_velocity) < FARTHEST


@compiled
def sampled_by(begin: float, hold: float, count: int) -> int:
    """How many of a hold's samples are taken by the time `begin`."""
    done = 0
    while begin > 0.0 and done < count and moment_of(done, count, hold) <= begin:
        done += 1
    return done


@compiled
def record(body: Body, samples: NDArray[np.float64], column: int) -> None:
    """Write z, v, p, x, w into one column."""
    samples[0, column] = body.deformation
    samples[1, column] = body.velocity
    samples[2, column] = body.pressure
    samples[3, column] = body.foot
    samples[4, column] = body.foot_velocity
