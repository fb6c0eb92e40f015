"""One crawler, one hold of the valve: the only place where the body's state moves.

The pressure is closed form. Between events z and v are Taylor series; the foot follows from the momentum, on which
friction alone acts. A step ends at whichever comes first: its error bound, the first descent of an event function
through zero, or the end of the hold.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .body import BACKWARD, Body, FORWARD, Ledger, Physics, STUCK
from .polynomial import first_descent, horner, horner_derivative, LARGEST_DEGREE
from .taylor import expand, FORCE, order_for, P, SCRATCH, step_length, V, Z

__all__ = [
    "DIVERGED",
    "FINISHED",
    "LOG_FULL",
    "MAX_STEPS",
    "OUT_OF_STEPS",
    "Control",
    "Outcome",
    "advance",
    "control_for",
]

FINISHED, DIVERGED, OUT_OF_STEPS, LOG_FULL = 0, 1, 2, 3

# About a second of work, a thousand times what the default crawler needs for a hold of 100.
MAX_STEPS = 1_000_000
# At a graze Newton halves the distance to the root, and no more, with every iteration.
_POLISHINGS = 40
# Largest defect of a step, in tolerances: a sound step's is about one.
_TRUST = 4.0
# Rounding of a force relative to its terms, below which no defect is to be seen.
_ROUNDING = 8.0 * np.finfo(np.float64).eps
_SHORTENINGS = 40
# Least braking force, above the rounding of a force, that tells a foot coming to rest from one breaking loose.
_BRAKING = 1e-12
# No body stretches so far; beyond, the squares of the motion would soon overflow, and float32 observations before them.
_FARTHEST = 1e30

# Row m: nodes and weights of the m-point Gauss-Legendre rule on [0, 1].
_MOST_NODES = LARGEST_DEGREE // 2 + 2
_NODES = np.zeros((_MOST_NODES + 1, _MOST_NODES))
_WEIGHTS = np.zeros((_MOST_NODES + 1, _MOST_NODES))
for _count in range(1, _MOST_NODES + 1):
    _x, _w = np.polynomial.legendre.leggauss(_count)
    _NODES[_count, :_count], _WEIGHTS[_count, :_count] = 0.5 * (1.0 + _x), 0.5 * _w


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


@njit(cache=True, nogil=True, error_model="numpy")
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
        expand(body, physics, valve, control.order, series)
        length = step_length(control.order, control.tolerance, series)
        if not length > 0.0:
            return Outcome(DIVERGED, elapsed, logged, body, ledger)
        length = min(length, hold - elapsed)
        length = _trusted(body, physics, valve, control, length, series)
        length, motion = _next_event(body, physics, valve, control.order, length, series)

        # The last step ends on the hold itself, so that no sample is lost to the rounding of a sum.
        last = motion == body.motion and length >= hold - elapsed
        reached = hold if last else elapsed + length
        while done < count:
            moment = hold * ((done + 1) / count)
            if moment > reached:
                break
            pressure = _pressure(opening, physics, valve, moment)
            sampled = _at(body, physics, pressure, control.order, min(moment - elapsed, length), series)
            samples[0, done] = sampled.deformation
            samples[1, done] = sampled.velocity
            samples[2, done] = sampled.pressure
            samples[3, done] = sampled.foot
            samples[4, done] = sampled.foot_velocity
            done += 1

        pressure = _pressure(opening, physics, valve, reached)
        following = _at(body, physics, pressure, control.order, length, series)
        if not abs(following.deformation) + abs(following.velocity) < _FARTHEST:
            return Outcome(DIVERGED, elapsed, logged, body, ledger)
        if control.energy:
            ledger = _account(ledger, body, following, physics, control.order, length, series)
        elapsed = reached
        if motion != body.motion:
            following = _change_motion(following, motion)
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


@njit(cache=True, nogil=True, error_model="numpy")
def _at(body: Body, physics: Physics, pressure: float, order: int, t: float, series: NDArray[np.float64]) -> Body:
    """State a time `t` into the step; the foot by momentum."""
    z = horner(series[Z], order + 1, t)
    v = horner(series[V], order + 1, t)
    foot = body.foot
    foot_velocity = 0.0
    if body.motion != STUCK:
        drag = body.motion * physics.kinetic_friction
        payload = physics.payload_fraction
        momentum = body.foot_velocity + payload * body.velocity
        foot += (momentum - 0.5 * drag * t) * t - payload * (z - body.deformation)
        foot_velocity = _foot_velocity(body, physics, v, t)
    return Body(z, v, pressure, foot, foot_velocity, body.motion, body.slips)


@njit(cache=True, nogil=True, error_model="numpy")
def _foot_velocity(body: Body, physics: Physics, velocity: float, t: float) -> float:
    """Velocity of the sliding foot a time `t` into the step, when the body stretches at the rate `velocity`."""
    gained = physics.payload_fraction * (body.velocity - velocity)
    return body.foot_velocity + gained - body.motion * physics.kinetic_friction * t


@njit(cache=True, nogil=True, error_model="numpy")
def _change_motion(body: Body, motion: int) -> Body:
    """The state just after the foot breaks loose or stops."""
    slips = body.slips if motion == STUCK else body.slips + 1
    return Body(body.deformation, body.velocity, body.pressure, body.foot, 0.0, motion, slips)


@njit(cache=True, nogil=True, error_model="numpy")
def _trusted(
    body: Body, physics: Physics, valve: float, control: Control, length: float, series: NDArray[np.float64]
) -> float:
    """The part of a step at whose end the series still satisfies the equation of motion.

    The last coefficients can be blind to what is to come: from rest z grows as t^3, and a cubic spring first acts at
    t^9. The defect, the force at the state less the force's own series, is not.
    """
    inverse_mass = 1.0 / physics.payload_fraction
    if body.motion != STUCK:
        inverse_mass /= physics.foot_fraction
    for _ in range(_SHORTENINGS):
        z = horner(series[Z], control.order + 1, length)
        v = horner(series[V], control.order + 1, length)
        force = _force(physics, z, v, _pressure(body, physics, valve, length))
        rounding = _ROUNDING * (1.0 + abs(z) * (1.0 + physics.duffing * z * z) + physics.damping * abs(v))
        defect = abs(force - horner(series[FORCE], control.order, length))
        if inverse_mass * (defect - rounding) <= _TRUST * control.tolerance:
            break
        shrink = math.exp(math.log(control.tolerance / (inverse_mass * defect)) / (control.order + 1))
        length *= max(0.25, min(0.9, shrink))
    return length


@njit(cache=True, nogil=True, error_model="numpy")
def _force(physics: Physics, z: float, v: float, p: float) -> float:
    """F = p (1 + Pi5 z) - z - Pi1 z^3 - 2 Pi2 v."""
    return p * (1.0 + physics.radial_coupling * z) - z * (1.0 + physics.duffing * z * z) - physics.damping * v


@njit(cache=True, nogil=True, error_model="numpy")
def _pressure(body: Body, physics: Physics, valve: float, t: float) -> float:
    """Pressure a time `t` after `body`, while the valve holds."""
    return valve + (body.pressure - valve) * math.exp(-t * physics.lag_rate)


@njit(cache=True, nogil=True, error_model="numpy")
def _next_event(
    body: Body, physics: Physics, valve: float, order: int, length: float, series: NDArray[np.float64]
) -> tuple[float, int]:
    """Where the step ends, at most at `length`, and the motion that follows."""
    if physics.anchored:
        return length, body.motion
    stuck = body.motion == STUCK
    moment = np.inf
    motion = body.motion
    for direction in (FORWARD, BACKWARD):
        if stuck:
            if direction == BACKWARD and physics.ratchet:
                continue
            degree = _grip(direction, physics, order, series)
        else:
            if direction != body.motion:
                continue
            degree = _slide(body, physics, order, series)
        descent = first_descent(series[SCRATCH], degree, length)
        if stuck and 0.0 < descent <= length:
            descent = _polish(descent, direction, body, physics, valve, order, length, series)
        if descent < moment:
            moment = descent
            motion = direction if stuck else STUCK
    if moment > length:
        if stuck or not _rests_at_end(body, physics, order, length, series):
            return length, body.motion
        moment = length
        motion = STUCK
    if not (stuck or physics.ratchet):
        # A foot that comes to rest under too great a push turns round at once.
        push = body.motion * horner(series[FORCE], order, moment)
        if push > physics.static_friction:
            motion = -body.motion
    return moment, motion


@njit(cache=True, nogil=True, error_model="numpy")
def _rests_at_end(body: Body, physics: Physics, order: int, length: float, series: NDArray[np.float64]) -> bool:
    """Whether rounding alone has hidden that the sliding foot comes to rest as the step ends.

    A foot at rest in the next step would be taken for one that has just broken loose, which drag does not hold back.
    """
    velocity = horner(series[V], order + 1, length)
    if body.motion * _foot_velocity(body, physics, velocity, length) > 0.0:
        return False
    braking = body.motion * horner(series[FORCE], order, length) + physics.kinetic_friction
    return braking > _BRAKING


@njit(cache=True, nogil=True, error_model="numpy")
def _grip(direction: int, physics: Physics, order: int, series: NDArray[np.float64]) -> int:
    """Write the margin s + F (forward) or s - F by which the resting foot holds; return its degree."""
    margin = series[SCRATCH]
    for n in range(order + 1):
        margin[n] = direction * series[FORCE, n]
    margin[0] += physics.static_friction
    return order


@njit(cache=True, nogil=True, error_model="numpy")
def _slide(body: Body, physics: Physics, order: int, series: NDArray[np.float64]) -> int:
    """Write the sliding foot's speed, from the momentum; return its degree."""
    speed = series[SCRATCH]
    direction = body.motion
    speed[0] = direction * body.foot_velocity
    for n in range(1, order + 1):
        speed[n] = -direction * physics.payload_fraction * series[V, n]
    speed[1] -= physics.kinetic_friction
    if speed[0] != 0.0:
        return order
    # A slip begins at rest: that root is divided out. The pull is then at least static friction, which rounding
    # could hide where the two frictions are equal.
    for n in range(order):
        speed[n] = speed[n + 1]
    surplus = (physics.static_friction - physics.kinetic_friction) / physics.foot_fraction
    speed[0] = max(speed[0], surplus)
    return order - 1


@njit(cache=True, nogil=True, error_model="numpy")
def _polish(
    moment: float,
    direction: int,
    body: Body,
    physics: Physics,
    valve: float,
    order: int,
    length: float,
    series: NDArray[np.float64],
) -> float:
    """Move a break-loose from where the force's series says to where the force at the state says; inf if nowhere.

    The series is truncated and the next step starts from the state: where both frictions are equal the foot must not
    find itself, by the difference, below the threshold it has just passed.
    """
    margin = 0.0
    for _ in range(_POLISHINGS):
        z = horner(series[Z], order + 1, moment)
        v = horner(series[V], order + 1, moment)
        margin = physics.static_friction + direction * _force(physics, z, v, _pressure(body, physics, valve, moment))
        slope = horner_derivative(series[SCRATCH], order, moment)
        if slope >= 0.0:
            break
        change = margin / slope
        moment = min(max(moment - change, 0.0), length)
        if abs(change) <= 2.0 * np.finfo(np.float64).eps * moment:
            break
    # Near a graze the series can cross a threshold that the state does not reach in this step: nothing breaks loose.
    return np.inf if margin > _BRAKING else moment


@njit(cache=True, nogil=True, error_model="numpy")
def _account(
    ledger: Ledger,
    before: Body,
    after: Body,
    physics: Physics,
    order: int,
    length: float,
    series: NDArray[np.float64],
) -> Ledger:
    """Add one step's energies: int p (1 + Pi5 z) v dt (equation S28), int 2 Pi2 v^2 dt, and drag times distance.

    A product of two series oscillates twice as fast as either, so that truncating it at their order would cost most
    of their accuracy. Gauss-Legendre quadrature of the truncated series on order / 2 + 2 nodes costs as much and loses
    nothing.
    """
    nodes = order // 2 + 2
    work = 0.0
    viscous = 0.0
    for i in range(nodes):
        t = length * _NODES[nodes, i]
        z = horner(series[Z], order + 1, t)
        v = horner(series[V], order + 1, t)
        p = horner(series[P], order, t)
        work += _WEIGHTS[nodes, i] * p * (1.0 + physics.radial_coupling * z) * v
        viscous += _WEIGHTS[nodes, i] * v * v
    return Ledger(
        ledger.work + length * work,
        ledger.viscous + length * physics.damping * viscous,
        ledger.friction + physics.kinetic_friction * abs(after.foot - before.foot),
    )
