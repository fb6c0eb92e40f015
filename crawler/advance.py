"""One crawler, one hold of the valve: the only place where the body's state moves.

The pressure is closed form. Between events z and v are Taylor series; the foot follows from the momentum, on which
friction alone acts. A step ends at whichever comes first: its error bound, the first descent of an event function
through zero, or the end of the hold.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled
from .body import Body, Ledger, Physics
from .energy import account
from .equations import force, inverse_mass, moved, pressure_after
from .events import change_motion, next_event
from .polynomial import horner
from .taylor import expand, order_for, state_at
from .workspace import END_FORCE, END_V, END_Z, FORCE, LENGTH, STEP, V, Z

__all__ = [
    "DIVERGED",
    "FARTHEST",
    "FINISHED",
    "LOG_FULL",
    "MAX_STEPS",
    "OUT_OF_STEPS",
    "Control",
    "Outcome",
    "advance",
    "control_for",
    "record",
]

FINISHED, DIVERGED, OUT_OF_STEPS, LOG_FULL = 0, 1, 2, 3

# About a second of work, a thousand times what the default crawler needs for a hold of 100.
MAX_STEPS = 1_000_000
# No bounded body stretches so far; beyond, a float32 observation and the squares of the motion would soon overflow.
FARTHEST = 1e12
# Largest defect of a step, in tolerances: a sound step's is about one.
_TRUST = 4.0
# Rounding of a force relative to its terms, below which no defect is to be seen.
_ROUNDING = 8.0 * np.finfo(np.float64).eps
_SHORTENINGS = 40


class Control(NamedTuple):
    """How accurately, and for how long at most, to integrate one hold."""

    tolerance: float
    order: int
    max_steps: int
    energy: bool  # whether to keep the ledger
    log: bool  # whether to write down the events


class Outcome(NamedTuple):
    """What one hold came to."""

    status: int  # FINISHED, DIVERGED, OUT_OF_STEPS or LOG_FULL
    elapsed: float  # time into the hold that was reached
    logged: int  # events written
    body: Body
    ledger: Ledger


def control_for(tolerance: float, *, energy: bool = False, log: bool = False, max_steps: int = MAX_STEPS) -> Control:
    """Settings that integrate to `tolerance`, with the order that makes it cheapest."""
    return Control(tolerance, order_for(tolerance), max_steps, energy, log)


@compiled
def advance(
    body: Body,
    ledger: Ledger,
    physics: Physics,
    valve: float,
    hold: float,
    control: Control,
    start: float,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    series: NDArray[np.float64],
) -> Outcome:
    """Advance one crawler by one hold of the valve.

    Parameters
    ----------
    body, ledger : Body, Ledger
        State and energies at the start of the hold.
    physics : Physics
    valve : float
        0 or 1, constant over the hold.
    hold : float
        Length of the hold, natural time.
    control : Control
    start : float
        Time at which the hold begins; only the events' times depend on it.
    samples : (5, S) array
        Receives z, v, p, x, w at the times hold (j + 1) / S.
    events : (capacity, 2) array
        Receives the time and the new motion of each event if `control.log`. Where it is too short the outcome says
        LOG_FULL, and the hold is to be done again from its start with a longer one.
    series : (ROWS, WIDTH) array
        Scratch.

    Returns
    -------
    Outcome
    """
    count = samples.shape[1]
    done = 0
    logged = 0
    elapsed = 0.0
    opening = body
    for _ in range(control.max_steps):
        expand(body, physics, valve, control.order, control.tolerance, hold - elapsed, series)
        if not abs(series[V, control.order + 1]) < np.inf:
            return Outcome(DIVERGED, elapsed, logged, body, ledger)
        longest, end = _trusted_step(opening, body, physics, valve, elapsed, control, series)
        length, motion = next_event(body, physics, valve, control.order, longest, series)

        # The last step ends on the hold itself, so that no sample is lost to the rounding of a sum.
        last = motion == body.motion and length >= hold - elapsed
        reached = hold if last else elapsed + length
        while done < count:
            moment = hold * ((done + 1) / count)
            if moment > reached:
                break
            pressure = pressure_after(opening, physics, valve, moment)
            sampled = end
            if moment - elapsed < longest:
                sampled = state_at(body, physics, pressure, control.order, min(moment - elapsed, length), series)
            record(sampled, samples, done)
            done += 1

        following = end
        if length < longest:
            pressure = pressure_after(opening, physics, valve, reached)
            following = state_at(body, physics, pressure, control.order, length, series)
        if not abs(following.deformation) + abs(following.velocity) < FARTHEST:
            return Outcome(DIVERGED, elapsed, logged, body, ledger)
        if control.energy:
            ledger = account(ledger, body, following, physics, control.order, length, series)
        elapsed = reached
        if motion != body.motion:
            following = change_motion(following, motion, physics)
            if control.log:
                if logged == events.shape[0]:
                    return Outcome(LOG_FULL, elapsed, logged, body, ledger)
                events[logged, 0] = start + elapsed
                events[logged, 1] = motion
                logged += 1
        body = following
        if last:
            return Outcome(FINISHED, hold, logged, body, ledger)
    return Outcome(OUT_OF_STEPS, elapsed, logged, body, ledger)


@compiled
def record(body: Body, samples: NDArray[np.float64], column: int) -> None:
    """Write z, v, p, x, w into one column."""
    samples[0, column] = body.deformation
    samples[1, column] = body.velocity
    samples[2, column] = body.pressure
    samples[3, column] = body.foot
    samples[4, column] = body.foot_velocity


@compiled
def _trusted_step(
    opening: Body,
    body: Body,
    physics: Physics,
    valve: float,
    elapsed: float,
    control: Control,
    series: NDArray[np.float64],
) -> tuple[float, Body]:
    """The part of a step at whose end the series still satisfies the equation of motion, and that end.

    The last coefficients can be blind to what is to come: from rest z grows as t^3, and a cubic spring first acts at
    t^9. The defect, the force at the state less the force's own series, is not.
    """
    yielding = inverse_mass(physics, body.motion)
    length, z, v = series[STEP, LENGTH], series[STEP, END_Z], series[STEP, END_V]
    expected = series[STEP, END_FORCE]
    pressure = pressure_after(opening, physics, valve, elapsed + length)
    for _ in range(_SHORTENINGS):
        rounding = _ROUNDING * (1.0 + abs(z) * (1.0 + physics.duffing * z * z) + physics.damping * abs(v))
        defect = abs(force(physics, z, v, pressure) - expected)
        if yielding * (defect - rounding) <= _TRUST * control.tolerance:
            break
        shrink = math.exp(math.log(control.tolerance / (yielding * defect)) / (control.order + 1))
        length *= max(0.25, min(0.9, shrink))
        z = horner(series[Z], control.order + 1, length)
        v = horner(series[V], control.order + 1, length)
        expected = horner(series[FORCE], control.order, length)
        pressure = pressure_after(opening, physics, valve, elapsed + length)
    return length, moved(body, physics, z, v, pressure, length)
