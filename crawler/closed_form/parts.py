"""The parts of the loop for a linear crawler, in closed form where the groups `NONLINEAR` are 0.

Nothing is integrated. From event to event the state is a propagator times the state at the last event, and only the
times of the events are searched for. The error is that of rounding, whatever the tolerance, which matters to nothing
but the turns of a free foot. The budget of steps bounds the evaluations in search of events. The workspace is from
`tabulate`, for this crawler, hold and number of samples.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import allocating, compiled, formula, inlined
from ...compiling.roots import first_downcrossing
from ..model.equations import acceleration_at_no_force, force, moved, retardation
from ..model.groups import Groups, NONLINEAR
from ..model.state import BACKWARD, Body, Coefficients, FORWARD, Ledger, STUCK
from ..motion.events import breaks_loose, comes_to_rest, foot_speed, mode_after_rest, turning_speed
from ..motion.parts import note, Parts
from ..motion.sampling import record
from ..stability.tangent import carry_linear, saltate
from ..steps.options import AFRESH, Pace, Situation, Taylor20
from ..steps.propagator import Propagator, propagator, Rates, rates_of, tabulated
from ..steps.taylor import expand
from ..steps.workspace import CHANGES, ROWS, SCRATCH, WIDTH
from .energy import account_linear
from .search import Amplitudes, amplitudes_of, Deviation, deviation, EventFunction, first_fall, safe_start

__all__ = ["LINEAR", "is_linear", "require_linear"]

# Up to one over the fastest rate a series of this order is exact to rounding.
_ORDER = Taylor20.order()
# A change that shrinks so much is carried in as many parts as keep it a float.
_E_FOLDS, _MOST_PARTS = 500.0, 1e5


def is_linear(groups: Groups) -> bool:
    """Whether the crawler's smooth motion has a closed form."""
    return all(getattr(groups, name) == 0.0 for name in NONLINEAR)


def require_linear(groups: Groups) -> None:
    """Refuse groups without a closed form.

    Raises
    ------
    ValueError
        Naming the group that makes the motion nonlinear.
    """
    for name in NONLINEAR:
        value = getattr(groups, name)
        if value != 0.0:
            raise ValueError(f"solver 'closed_form' needs {name} to be 0, got {value!r}; 'auto' takes any groups")


class Flow(NamedTuple):
    """The motion of a linear body, up to its next event."""

    rates: Rates
    start: Deviation
    whole: Propagator  # over the time to the end of the valve's stretch


@inlined
def _step(now: Situation, _pace: Pace) -> tuple[float, Flow, Pace]:
    body, coefficients, hold, table = now.body, now.coefficients, now.hold, now.workspace
    rates = rates_of(coefficients, body.mode)
    start = deviation(body, coefficients, hold.valve, rates)
    length = hold.end - now.elapsed
    count = _samples_of(table)
    # A hold's last sample is its end.
    if now.elapsed == 0.0 and hold.end == hold.length and count > 0:
        whole = tabulated(table, (count if body.mode == STUCK else 2 * count) - 1)
    else:
        whole = propagator(rates, length)
    return length, Flow(rates, start, whole), AFRESH


@inlined
def _event(now: Situation, flow: Flow, length: float, _pace: Pace, budget: int) -> tuple[float, int, int]:
    length, mode, looks = _next_event(
        now.body,
        flow.start,
        now.coefficients,
        now.hold.valve,
        flow.rates,
        length,
        flow.whole,
        now.options.tolerance,
        budget,
    )
    return length, mode, looks if looks + 1 < budget else -1


@inlined
def _sample(
    now: Situation, flow: Flow, length: float, moment: float, column: int, samples: NDArray[np.float64]
) -> Body:
    since = min(moment - now.elapsed, length)
    if now.elapsed == 0.0 and since == moment and moment < now.hold.end:
        over = tabulated(now.workspace, column if now.body.mode == STUCK else _samples_of(now.workspace) + column)
    else:
        over = _over(now, flow, since)
    sampled = _carried(now.body, flow.start, now.coefficients, now.hold.valve, over, since)
    record(sampled, samples, column)
    return sampled


@inlined
def _arrive(
    now: Situation, flow: Flow, _longest: float, length: float, _reached: float, last: bool, sampled: Body
) -> Body:
    if last and now.hold.end == now.hold.length and _samples_of(now.workspace) > 0:
        return sampled
    over = _over(now, flow, length)
    return _carried(now.body, flow.start, now.coefficients, now.hold.valve, over, length)


@inlined
def _account(now: Situation, flow: Flow, ledger: Ledger, following: Body, length: float) -> Ledger:
    end = deviation(following, now.coefficients, now.hold.valve, flow.rates)
    return account_linear(
        ledger, now.body, following, now.coefficients, now.hold.valve, flow.rates, flow.start, end, length
    )


@inlined
def _carry(now: Situation, flow: Flow, _following: Body, length: float) -> None:
    # What is left of a change after a long time is told by parts of it.
    parts = math.ceil(min(_MOST_PARTS, flow.rates.slow * length / _E_FOLDS))
    if parts <= 1:
        carry_linear(now.body, now.coefficients, _over(now, flow, length), length, now.workspace)
    else:
        over = propagator(flow.rates, length / parts)
        for _ in range(int(parts)):
            carry_linear(now.body, now.coefficients, over, length / parts, now.workspace)


@inlined
def _saltate(now: Situation, _flow: Flow, following: Body, mode: int, time: float) -> None:
    saltate(following, mode, now.coefficients, now.hold.valve, time, now.workspace)


LINEAR = Parts(_step, _event, _sample, _arrive, _account, _carry, _saltate, note)


@inlined
def _over(now: Situation, flow: Flow, t: float) -> Propagator:
    return flow.whole if t == now.hold.end - now.elapsed else propagator(flow.rates, t)


@formula
def _samples_of(table: NDArray[np.float64]) -> int:
    """Samples of a hold that the workspace, from `tabulate`, is for."""
    return (table.shape[0] - CHANGES) // 2


@compiled
def _carried(
    body: Body, start: Deviation, coefficients: Coefficients, valve: float, over: Propagator, t: float
) -> Body:
    """State a time `t` after `body`, by the propagator over that time."""
    z = over.z_z * start.z + over.z_v * start.v + over.z_q * start.gap
    v = over.v_z * start.z + over.v_v * start.v + over.v_q * start.gap
    return moved(body, coefficients, start.rest + z, v, valve + over.q_q * start.gap, t)


@compiled
def _next_event(
    body: Body,
    start: Deviation,
    coefficients: Coefficients,
    valve: float,
    rates: Rates,
    length: float,
    whole: Propagator,
    tolerance: float,
    budget: int,
) -> tuple[float, int, int]:
    """Where the smooth motion ends, at most at `length`, the motion that follows, and the evaluations spent."""
    if coefficients.anchored:
        return length, body.mode, 0
    amplitudes = amplitudes_of(start, rates)
    if body.mode == STUCK:
        grip = _grip(FORWARD, coefficients, rates)
        moment, spent = first_fall(grip, start, rates, amplitudes, 0.0, length, whole, budget)
        mode = FORWARD
        if not coefficients.ratchet and spent < budget:
            grip = _grip(BACKWARD, coefficients, rates)
            backward, looks = first_fall(grip, start, rates, amplitudes, 0.0, length, whole, budget - spent)
            spent += looks
            if backward < moment:
                moment, mode = backward, BACKWARD
        return (moment, mode, spent) if moment <= length else (length, STUCK, spent)

    beyond = turning_speed(body, coefficients, tolerance)
    moment, spent = _standstill(body, start, coefficients, valve, rates, amplitudes, length, whole, beyond, budget)
    rests = moment <= length
    if rests:
        over = propagator(rates, moment)
    else:
        moment, over = length, whole
    following = _carried(body, start, coefficients, valve, over, moment)
    z, v = following.deformation, following.velocity
    if rests or comes_to_rest(body.mode, coefficients, z, v, following.pressure, following.foot_velocity):
        pull = force(coefficients, z, v, following.pressure)
        return moment, mode_after_rest(body.mode, coefficients, pull), spent
    return length, body.mode, spent


@compiled
def _grip(direction: int, coefficients: Coefficients, rates: Rates) -> EventFunction:
    """Margin by which the resting foot holds, s plus or less F + r slope, where Y F = v' less its constant part."""
    at_rest = (
        coefficients.foot_fraction * coefficients.slope - acceleration_at_no_force(coefficients, STUCK) / rates.mobility
    )
    constant = coefficients.static_friction + direction * at_rest
    return EventFunction(constant, 0.0, direction / rates.mobility, True, coefficients.static_friction + abs(at_rest))


@allocating
def _standstill(
    body: Body,
    start: Deviation,
    coefficients: Coefficients,
    valve: float,
    rates: Rates,
    amplitudes: Amplitudes,
    length: float,
    whole: Propagator,
    beyond: float,
    budget: int,
) -> tuple[float, int]:
    """When the sliding foot's speed, by momentum, and `beyond` more falls through zero; inf if not by `length`."""
    payload, direction = coefficients.payload_fraction, body.mode
    function = EventFunction(
        direction * (body.foot_velocity + payload * body.velocity) + beyond,
        -direction * retardation(coefficients, direction),
        -direction * payload,
        False,
        abs(body.foot_velocity) + payload * abs(body.velocity),
    )
    begin = 0.0
    if body.foot_velocity == 0.0 and beyond == 0.0:
        # A slip begins at rest, and its speed is at first a difference that rounding swamps.
        gained = function.drift + function.factor * start.acceleration
        if breaks_loose(direction, coefficients, body.deformation, body.velocity, body.pressure):
            gained = max(
                gained, (coefficients.static_friction - coefficients.kinetic_friction) / coefficients.foot_fraction
            )
        begin = safe_start(function, start, rates, amplitudes, gained)
        if begin == 0.0:
            begin = min(length, 1.0 / max(rates.fast, rates.lag, math.sqrt(rates.mobility)))
            series = np.empty((ROWS, WIDTH))
            expand(body, coefficients, valve, Taylor20(), 1.0, begin, series)
            degree = foot_speed(body, coefficients, _ORDER, 0.0, series)
            moment = first_downcrossing(series[SCRATCH], degree, begin)
            if moment <= begin:
                return moment, 1
        if not begin < length:
            return math.inf, 1
    return first_fall(function, start, rates, amplitudes, begin, length, whole, budget)
