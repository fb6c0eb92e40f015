"""When the foot breaks loose, and when it comes to rest."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, formula, merged
from ...compiling.roots import first_downcrossing, horner, horner_derivative, sharp_descent
from ..model.equations import foot_velocity_at, force, force_terms, is_free, pressure_after, retardation
from ..model.state import BACKWARD, Body, Coefficients, FORWARD, STUCK
from ..steps.taylor import ROUNDING
from ..steps.workspace import END_V, FIRST, FLATTEST, FORCE, HIGHEST, LENGTH, LOWEST, SCRATCH, STEEPEST, STEP, V, Z

__all__ = [
    "breaking_loose",
    "breaks_loose",
    "comes_to_rest",
    "foot_speed",
    "is_quiet",
    "jump",
    "mode_after_rest",
    "next_event",
    "started",
    "turning_speed",
]

# At a graze Newton halves the distance to the root, and no more, with every iteration.
_POLISHINGS = 40
# A force vanishes within so much of its terms: that is above their rounding, and that of the time at which it does.
_VANISHING = 1e-12
# What a step may err by, in tolerances: a Taylor series is trusted with as much.
_TURNING = 4.0


@merged
def next_event(
    body: Body,
    ahead: Body,
    coefficients: Coefficients,
    valve: float,
    order: int,
    length: float,
    tolerance: float,
    doubt: float,
    series: NDArray[np.float64],
) -> tuple[float, int]:
    """Where the step ends, at most at `length` with the state `ahead`, and the motion that follows.

    `tolerance` as for `turning_speed`, `doubt` as for `breaking_loose`.
    """
    if coefficients.anchored | is_quiet(body, coefficients, series[FORCE, 0], series[STEP]):
        return length, body.mode
    if body.mode == STUCK:
        return breaking_loose(body, coefficients, valve, order, length, doubt, series)
    degree = foot_speed(body, coefficients, order, turning_speed(body, coefficients, tolerance), series)
    moment = sharp_descent(series[SCRATCH], degree, length)
    if moment > length:
        z, v = ahead.deformation, ahead.velocity
        if not comes_to_rest(body.mode, coefficients, z, v, ahead.pressure, ahead.foot_velocity):
            return length, body.mode
        moment = length
    return moment, mode_after_rest(body.mode, coefficients, horner(series[FORCE], order, moment))


@formula
def is_quiet(body: Body, coefficients: Coefficients, pull: float, reach: Any) -> bool:
    """Whether bounds alone show that nothing happens on the step, which begins with the force `pull`.

    `reach` is the row STEP. The speed of a foot that slides from rest is t times a polynomial, whose constant term is
    then the first.
    """
    lowest, highest, first = reach[LOWEST], reach[HIGHEST], reach[FIRST]
    rises, falls = reach[STEEPEST] >= 0.0, reach[FLATTEST] <= 0.0
    change = lowest + highest

    speed = body.mode * body.foot_velocity
    slides = _stays_positive(speed, lowest, change, rises, falls) | ((speed == 0.0) & (first + lowest > 0.0))
    # By momentum, as the state will have it: a stop that rounding alone hides is no quiet end.
    slides = slides & (body.mode * foot_velocity_at(body, coefficients, reach[END_V], reach[LENGTH]) > 0.0)

    weighed = pull + coefficients.foot_fraction * coefficients.slope
    forward = _stays_positive(coefficients.static_friction + weighed, lowest, change, rises, falls)
    backward = _stays_positive(coefficients.static_friction - weighed, -highest, -change, falls, rises)
    rests = forward & (coefficients.ratchet | backward)
    return ((body.mode == STUCK) & rests) | ((body.mode != STUCK) & slides)


@formula
def _stays_positive(start: float, lowest: float, change: float, rises: bool, falls: bool) -> bool:
    """Whether a function is positive on the step, by the least of its terms or as it is monotone."""
    return (start + lowest > 0.0) | ((start > 0.0) & (rises | (falls & (start + change > 0.0))))


@merged
def breaking_loose(
    body: Body,
    coefficients: Coefficients,
    valve: float,
    order: int,
    length: float,
    doubt: float,
    series: NDArray[np.float64],
) -> tuple[float, int]:
    """Where a step of the resting foot ends, at most at `length`, and the motion that follows.

    The foot breaks loose where the force is beyond its threshold by more than `doubt`, what the step may err by. A
    grip that the error alone breaks would hold again at once, and so without end.
    """
    first = np.inf
    mode = STUCK
    for direction in (FORWARD, BACKWARD):
        if direction == BACKWARD and coefficients.ratchet:
            continue
        _grip(direction, coefficients, order, doubt, series)
        moment = first_downcrossing(series[SCRATCH], order, length)
        if 0.0 < moment <= length:
            moment = _polish(moment, direction, body, coefficients, valve, order, length, doubt, series)
        if moment < first:
            first = moment
            mode = direction
    return (length, STUCK) if first > length else (first, mode)


@compiled
def mode_after_rest(mode: int, coefficients: Coefficients, pull: float) -> int:
    """What follows when a foot that slid comes to rest under the force `pull`.

    Under too great a push it turns round at once, and without friction any is too great.
    """
    push = mode * (pull + coefficients.foot_fraction * coefficients.slope)
    if not coefficients.ratchet and (push > coefficients.static_friction or coefficients.static_friction == 0.0):
        return -mode
    return STUCK


@compiled
def comes_to_rest(
    mode: int, coefficients: Coefficients, z: float, v: float, pressure: float, foot_velocity: float
) -> bool:
    """Whether a sliding foot is at rest at the end of a smooth motion in which no fall of its speed was found.

    Rounding hides some falls, and a speed that nothing brakes fades to 0 without one. The state is that of the segment
    in front of the foot.
    """
    return foot_velocity == 0.0 and not is_free(coefficients) and not breaks_loose(mode, coefficients, z, v, pressure)


@compiled
def turning_speed(body: Body, coefficients: Coefficients, tolerance: float) -> float:
    """Speed that a free foot has when it is said to have turned round; 0 for any other foot, which stops.

    To turn round changes nothing for a free foot but the name of its motion. It does so at every half period for ever,
    and below what the solver may err by, at most some tolerances of the body's rate, the turns would be those of the
    error.
    """
    if not is_free(coefficients):
        return 0.0
    speeds = abs(body.foot_velocity) + coefficients.payload_fraction * abs(body.velocity)
    return max(_TURNING * tolerance * coefficients.payload_fraction, _VANISHING * speeds)


@compiled
def breaks_loose(mode: int, coefficients: Coefficients, z: float, v: float, pressure: float) -> bool:
    """Whether a foot without speed is pulled into `motion` at least as hard as static friction holds, but for rounding.

    The force has no jumps: this tells a foot that has just broken loose, in the hold before perhaps, from one whose
    speed has come to 0.
    """
    pull = -mode * (force(coefficients, z, v, pressure) + coefficients.foot_fraction * coefficients.slope)
    size = force_terms(coefficients, z, v) + coefficients.static_friction
    return pull >= coefficients.static_friction - _VANISHING * size


@compiled
def jump(body: Body, mode: int, coefficients: Coefficients) -> Body:
    """The state just after the foot breaks loose or stops.

    A foot that turns round without friction has had nothing to break loose from, and that is no slip. It keeps the
    speed that it has.
    """
    slips = body.slips
    if mode != STUCK and (body.mode == STUCK or coefficients.static_friction > 0.0):
        slips += 1
    foot_velocity = body.foot_velocity if is_free(coefficients) else 0.0
    return Body(body.deformation, body.velocity, body.pressure, body.foot, foot_velocity, mode, slips)


@compiled
def _grip(direction: int, coefficients: Coefficients, order: int, doubt: float, series: NDArray[np.float64]) -> None:
    """Write the margin by which the resting foot holds, s plus or less F + r slope, and the doubt of it."""
    margin = series[SCRATCH]
    for n in range(order + 1):
        margin[n] = direction * series[FORCE, n]
    margin[0] += coefficients.static_friction + doubt + direction * coefficients.foot_fraction * coefficients.slope


@compiled
def foot_speed(body: Body, coefficients: Coefficients, order: int, beyond: float, series: NDArray[np.float64]) -> int:
    """Write the sliding foot's speed, from the momentum, and `beyond` more; return its degree."""
    speed = series[SCRATCH]
    direction = body.mode
    speed[0] = direction * body.foot_velocity + beyond
    for n in range(1, order + 1):
        speed[n] = -direction * coefficients.payload_fraction * series[V, n]
    speed[1] -= direction * retardation(coefficients, direction)
    return started(speed, body, coefficients, order, series)


@compiled
def started(
    speed: NDArray[np.float64], body: Body, coefficients: Coefficients, degree: int, series: NDArray[np.float64]
) -> int:
    """Divide out the root with which a slip begins at rest; return the degree of what is left.

    The pull is then at least static friction, which rounding could hide where the two frictions are equal.
    """
    if speed[0] != 0.0:
        return degree
    for n in range(degree):
        speed[n] = speed[n + 1]
    if breaks_loose(body.mode, coefficients, series[Z, 0], series[V, 0], body.pressure):
        surplus = (coefficients.static_friction - coefficients.kinetic_friction) / coefficients.foot_fraction
        speed[0] = max(speed[0], surplus)
    return degree - 1


@compiled
def _polish(
    moment: float,
    direction: int,
    body: Body,
    coefficients: Coefficients,
    valve: float,
    order: int,
    length: float,
    doubt: float,
    series: NDArray[np.float64],
) -> float:
    """Move a break-loose from where the force's series says to where the force at the state says; inf if nowhere.

    The series is truncated and the next step starts from the state: where both frictions are equal the foot must not
    find itself, by the difference, below the threshold it has just passed.
    """
    margin = 0.0
    size = 0.0
    for _ in range(_POLISHINGS):
        z = horner(series[Z], order + 1, moment)
        v = horner(series[V], order + 1, moment)
        pull = force(coefficients, z, v, pressure_after(body, coefficients, valve, moment))
        margin = (
            coefficients.static_friction + doubt + direction * (pull + coefficients.foot_fraction * coefficients.slope)
        )
        size = force_terms(coefficients, z, v) + coefficients.static_friction
        slope = horner_derivative(series[SCRATCH], order, moment)
        if slope >= 0.0:
            break
        change = margin / slope
        moment = min(max(moment - change, 0.0), length)
        # Beyond its rounding the margin tells nothing more.
        if abs(change) <= 2.0 * np.finfo(np.float64).eps * moment or abs(margin) <= ROUNDING * size:
            break
    # Near a graze the series can cross a threshold that the state does not reach in this step: nothing breaks loose.
    return np.inf if margin > _VANISHING * size else moment
