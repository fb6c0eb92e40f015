"""One linear crawler, one stretch of a constant valve: the closed form of `advance` where Pi1 = Pi5 = 0.

Nothing is integrated. From event to event the state is a propagator times the state at the last event, and only the
times of the events are searched for. The error is that of rounding, whatever the tolerance.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import allocating, compiled
from ...compiling.roots import first_downcrossing
from ..model.equations import acceleration_at_no_force, force, moved, retardation
from ..model.groups import Groups
from ..model.state import BACKWARD, Body, Coefficients, FORWARD, Ledger, STUCK
from ..motion.events import breaks_loose, comes_to_rest, foot_speed, jump, mode_after_rest, turning_speed
from ..motion.loop import is_near, moment_of, record, sampled_by
from ..motion.tangent import carry_linear, saltate
from ..steps.options import AFRESH, DIVERGED, FINISHED, Leg, LOG_FULL, Options, OUT_OF_STEPS, Outcome, PAUSED, Taylor20
from ..steps.propagator import Propagator, propagator, Rates, rates_of, tabulated
from ..steps.taylor import expand
from ..steps.workspace import ROWS, SCRATCH, WIDTH
from .energy import account_linear
from .search import Deviation, deviation, EventFunction, first_fall, Modes, modes_of, safe_start

__all__ = ["advance_linear", "is_linear", "require_linear"]

# Up to one over the fastest rate a series of this order is exact to rounding.
_ORDER = Taylor20.order()


def is_linear(groups: Groups) -> bool:
    """Whether the crawler's smooth motion has a closed form."""
    return groups.duffing == 0.0 and groups.radial_coupling == 0.0


def require_linear(groups: Groups) -> None:
    """Refuse groups without a closed form.

    Raises
    ------
    ValueError
        Naming the group that makes the motion nonlinear.
    """
    for name in ("duffing", "radial_coupling"):
        value = getattr(groups, name)
        if value != 0.0:
            raise ValueError(f"solver 'closed_form' needs {name} to be 0, got {value!r}; 'auto' takes any groups")


@compiled
def advance_linear(
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
    """Advance one linear crawler by one hold of the valve, or by a part of one.

    Parameters
    ----------
    body, ledger, coefficients, valve, hold, options, start, samples, events, begin, end, leg
        As for `advance`. Of `options` the order does not matter, and the tolerance to nothing but the turns of a free
        foot; `max_steps` bounds the evaluations in search of events; it pauses between two events only.
    workspace : (2 S + CHANGES, ENTRIES) array
        From `tabulate`, for this crawler, hold and number S of samples.

    Returns
    -------
    Outcome
    """
    count = samples.shape[1]
    elapsed = begin
    if leg is not None:
        elapsed = leg.elapsed
    done = sampled_by(elapsed, hold, count)
    logged = 0
    close = min(end, hold)
    spent = 0
    while True:
        if leg is not None and spent >= leg.steps:
            return Outcome(PAUSED, elapsed, spent, logged, body, ledger, AFRESH)
        rates = rates_of(coefficients, body.mode)
        deviating = deviation(body, coefficients, valve, rates)
        length = close - elapsed
        resting = body.mode == STUCK
        # A hold's last sample is its end.
        ends_sampled = close == hold and count > 0
        if elapsed == 0.0 and ends_sampled:
            whole = tabulated(workspace, (count if resting else 2 * count) - 1)
        else:
            whole = propagator(rates, length)
        budget = options.max_steps - spent
        moment, mode, looks = _next_event(
            body, deviating, coefficients, valve, rates, length, whole, options.tolerance, budget
        )
        spent += looks + 1
        if spent >= options.max_steps:
            return Outcome(OUT_OF_STEPS, elapsed, options.max_steps, logged, body, ledger, AFRESH)
        last = mode == body.mode
        reached = close if last else elapsed + moment
        following = body
        while done < count:
            instant = moment_of(done, count, hold)
            if instant > reached:
                break
            since = min(instant - elapsed, moment)
            if since == length:
                over = whole
            elif elapsed == 0.0 and since == instant:
                over = tabulated(workspace, done if resting else count + done)
            else:
                over = propagator(rates, since)
            following = _carried(body, deviating, coefficients, valve, over, since)
            record(following, samples, done)
            done += 1
        if not (last and ends_sampled):
            over = whole if last else propagator(rates, moment)
            following = _carried(body, deviating, coefficients, valve, over, moment)
        if not is_near(following):
            return Outcome(DIVERGED, elapsed, spent, logged, body, ledger, AFRESH)
        if options.energy:
            ended = deviation(following, coefficients, valve, rates)
            ledger = account_linear(ledger, body, following, coefficients, valve, rates, deviating, ended, moment)
        if options.tangents:
            over = whole if last else propagator(rates, moment)
            carry_linear(body, coefficients, over, moment, workspace)
        elapsed = reached
        if mode != body.mode:
            if options.tangents:
                saltate(following, mode, coefficients, valve, start + elapsed, workspace)
            following = jump(following, mode, coefficients)
            if options.log:
                if logged == events.shape[0]:
                    return Outcome(LOG_FULL, elapsed, spent, logged, body, ledger, AFRESH)
                events[logged, 0] = start + elapsed
                events[logged, 1] = mode
                logged += 1
        body = following
        if last:
            return Outcome(FINISHED, close, spent, logged, body, ledger, AFRESH)


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
    modes = modes_of(start, rates)
    if body.mode == STUCK:
        grip = _grip(FORWARD, coefficients, rates)
        moment, spent = first_fall(grip, start, rates, modes, 0.0, length, whole, budget)
        mode = FORWARD
        if not coefficients.ratchet and spent < budget:
            grip = _grip(BACKWARD, coefficients, rates)
            backward, looks = first_fall(grip, start, rates, modes, 0.0, length, whole, budget - spent)
            spent += looks
            if backward < moment:
                moment, mode = backward, BACKWARD
        return (moment, mode, spent) if moment <= length else (length, STUCK, spent)

    beyond = turning_speed(body, coefficients, tolerance)
    moment, spent = _standstill(body, start, coefficients, valve, rates, modes, length, whole, beyond, budget)
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
    modes: Modes,
    length: float,
    whole: Propagator,
    beyond: float,
    budget: int,
) -> tuple[float, int]:
    """When the sliding foot's speed, by momentum, and `beyond` more falls through zero; inf if not by `length`."""
    payload, direction = coefficients.payload_fraction, body.mode
    margin = EventFunction(
        direction * (body.foot_velocity + payload * body.velocity) + beyond,
        -direction * retardation(coefficients, direction),
        -direction * payload,
        False,
        abs(body.foot_velocity) + payload * abs(body.velocity),
    )
    begin = 0.0
    if body.foot_velocity == 0.0 and beyond == 0.0:
        # A slip begins at rest, and its speed is at first a difference that rounding swamps.
        gained = margin.drift + margin.factor * start.acceleration
        if breaks_loose(direction, coefficients, body.deformation, body.velocity, body.pressure):
            gained = max(
                gained, (coefficients.static_friction - coefficients.kinetic_friction) / coefficients.foot_fraction
            )
        begin = safe_start(margin, start, rates, modes, gained)
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
    return first_fall(margin, start, rates, modes, begin, length, whole, budget)
