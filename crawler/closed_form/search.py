"""First descent of an event function of a linear crawler through zero, found with certainty.

With g and g' known at t and |g''| <= M from t on, g stays positive up to the positive root D of g + g' D - M D^2 / 2.
So the search marches from bound to bound, and where a parabola from above shows that g must cross while it falls
monotonically, it ends with Newton's method inside a bracket. M decays with the motion, and the march lengthens as the
fast terms die away.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiling.compilation import compiled
from ..model.equations import acceleration_at_no_force
from ..model.state import Body, Coefficients
from ..steps.propagator import decay, Propagator, propagator, Rates

__all__ = [
    "FAINTEST",
    "Amplitudes",
    "Deviation",
    "EventFunction",
    "amplitudes_of",
    "deviation",
    "first_fall",
    "largest_derivative",
    "safe_start",
]

# Sums of a few terms are right to some units in the last place; a dip shallower than that is no descent.
_NOISE = 16.0 * np.finfo(np.float64).eps
# Depth in noises at which a value counts as below it: less than 1, so that the march past a graze has a least step.
_DEPTH = 0.9
# A foot that has just broken loose is beyond the reach of rounding where its speed is this many times the noise.
_CLEAR = 1e3
_REFINEMENTS = 60
# Squared distance of the body's real rates, in its frequency squared, below which its energy bounds it tightly.
_ALIKE = 0.5
# Squared distance of the lag's rate from the body's, likewise, below which the two are not told apart.
_RESONANT = 0.25
FAINTEST = 1e-250
_IDENTITY = Propagator(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0)


class Deviation(NamedTuple):
    """State of the body relative to where the held valve would bring it to rest."""

    rest: float  # that place
    z: float
    v: float
    gap: float  # p - u
    acceleration: float
    size: float  # of the terms that make up the acceleration, without their cancellation


class EventFunction(NamedTuple):
    """An event function: constant + drift t + factor times v, or v' where `accelerating`."""

    constant: float
    drift: float
    factor: float
    accelerating: bool
    size: float  # of the terms that make up the constant


class Amplitudes(NamedTuple):
    """A body with distinct real rates: z = lone e^(-lone_rate t) + pair e^(-pair_rate t) + driven E(t).

    E is the divided difference of the exponentials of the paired rate and the lag's, so that their resonance is
    nothing special.
    """

    lone: float
    lone_rate: float
    pair: float
    pair_rate: float
    driven: float


class _Look(NamedTuple):
    """An event function and the state at one instant."""

    value: float
    slope: float
    bend: float
    noise: float
    z: float
    v: float
    gap: float


@compiled
def deviation(body: Body, coefficients: Coefficients, valve: float, rates: Rates) -> Deviation:
    """State of `body` relative to its place of rest under the present valve and motion."""
    gap = _faded(body.pressure - valve)
    v = _faded(body.velocity)
    rest = valve + acceleration_at_no_force(coefficients, body.mode) / rates.mobility
    z = _faded(body.deformation - rest)
    acceleration = rates.mobility * (gap - z - rates.damping * v)
    size = rates.mobility * (body.pressure + abs(body.deformation) + abs(z) + rates.damping * abs(v))
    return Deviation(rest, z, v, gap, acceleration, size)


@compiled
def _faded(value: float) -> float:
    return value if abs(value) > FAINTEST else 0.0


@compiled
def amplitudes_of(start: Deviation, rates: Rates) -> Amplitudes:
    """Amplitudes of a body whose rates are real and distinct (where they are not, those are not used)."""
    slow, fast, apart = rates.slow, rates.fast, 2.0 * rates.spread
    push = rates.mobility * start.gap
    if abs(rates.lag - slow) <= abs(rates.lag - fast):
        driven = push / (fast - rates.lag)
        lone = (driven - start.v - slow * start.z) / apart
        return Amplitudes(lone, fast, start.z - lone, slow, driven)
    driven = push / (slow - rates.lag)
    lone = (start.v + fast * start.z - driven) / apart
    return Amplitudes(lone, slow, start.z - lone, fast, driven)


@compiled
def largest_derivative(
    rates: Rates, amplitudes: Amplitudes, order: int, t: float, z: float, v: float, gap: float
) -> float:
    """Bound on the derivative of the given order of v, from `t` on, where the state is z, v, gap."""
    if rates.oscillates or rates.spread * rates.spread < _ALIKE * rates.mobility:
        return _energy_bound(rates, order, z, v, gap)
    power = order + 1
    bound = abs(amplitudes.lone) * amplitudes.lone_rate**power * decay(amplitudes.lone_rate * t)
    bound += abs(amplitudes.pair) * amplitudes.pair_rate**power * decay(amplitudes.pair_rate * t)
    low, high = min(amplitudes.pair_rate, rates.lag), max(amplitudes.pair_rate, rates.lag)
    slower, faster = decay(low * t), decay(high * t)
    apart = (low**power * slower + high**power * faster) / (high - low)
    together = slower * high ** (power - 1) * (power + high * (t + 1.0 / low))
    # Equal rates make the first 0 / 0 or infinite.
    return bound + abs(amplitudes.driven) * (apart if apart < together else together)


@compiled
def _energy_bound(rates: Rates, order: int, z: float, v: float, gap: float) -> float:
    """A free oscillator's energy, and that of each derivative of its motion, only falls.

    Away from resonance the motion is a free one and a multiple of the gap. Near it the energy's root grows at most by
    Y |q^(order)|.
    """
    lag = rates.lag
    square = (lag - rates.mean) ** 2 + (1.0 if rates.oscillates else -1.0) * rates.spread**2
    push = gap
    driven = 0.0
    if abs(square) > _RESONANT * rates.mobility:
        share = rates.mobility / square
        z -= share * gap
        v += share * lag * gap
        driven = abs(share * gap) * lag ** (order + 1)
        push = 0.0
    else:
        driven = rates.mobility * abs(gap) * lag ** (order - 1)
    earlier, latest = z, v
    for _ in range(order):
        earlier, latest = latest, rates.mobility * (push - earlier - rates.damping * latest)
        push *= -lag
    return math.sqrt(latest * latest + rates.mobility * earlier * earlier) + driven


@compiled
def _look(function: EventFunction, start: Deviation, rates: Rates, over: Propagator, t: float) -> _Look:
    """The event function at `t`, which `over` leads to, with two derivatives, and how far its rounding may reach."""
    z = over.z_z * start.z + over.z_v * start.v + over.z_q * start.gap
    v = over.v_z * start.z + over.v_v * start.v + over.v_q * start.gap
    gap = over.q_q * start.gap
    gap_rate = -rates.lag * gap
    # Propagated rather than made from the forces, which all but cancel in an overdamped body.
    acceleration = over.v_z * start.v + over.v_v * start.acceleration - over.v_q * rates.lag * start.gap
    jerk = rates.mobility * (gap_rate - v - rates.damping * acceleration)
    if function.accelerating:
        value = function.constant + function.factor * acceleration
        slope = function.factor * jerk
        bend = function.factor * rates.mobility * (-rates.lag * gap_rate - acceleration - rates.damping * jerk)
        terms = abs(over.v_z * start.v) + abs(over.v_v) * start.size + abs(over.v_q * rates.lag * start.gap)
    else:
        value = function.constant + function.drift * t + function.factor * v
        slope = function.drift + function.factor * acceleration
        bend = function.factor * jerk
        terms = abs(over.v_z * start.z) + abs(over.v_v * start.v) + abs(over.v_q * start.gap)
    noise = _NOISE * (function.size + abs(function.drift) * t + abs(function.factor) * terms)
    return _Look(value, slope, bend, noise, z, v, gap)


@compiled
def _reach(value: float, slope: float, curvature: float) -> float:
    """How far ahead the parabola of that downward curvature stays positive."""
    root = math.sqrt(slope * slope + 2.0 * curvature * value)
    if slope < 0.0:
        return 2.0 * value / (root - slope)
    return (slope + root) / curvature if curvature > 0.0 else math.inf


@compiled
def safe_start(function: EventFunction, start: Deviation, rates: Rates, amplitudes: Amplitudes, slope: float) -> float:
    """When a function that starts at 0 with the given slope is beyond the reach of rounding, and never was 0 between.

    0 where no such time is known.
    """
    order = 3 if function.accelerating else 2
    curvature = abs(function.factor) * largest_derivative(rates, amplitudes, order, 0.0, start.z, start.v, start.gap)
    noise = _look(function, start, rates, _IDENTITY, 0.0).noise
    if slope > 0.0 and slope * slope > 2.0 * _CLEAR * noise * curvature:
        return slope / curvature if curvature > 0.0 else math.inf
    return 0.0


@compiled
def first_fall(
    function: EventFunction,
    start: Deviation,
    rates: Rates,
    amplitudes: Amplitudes,
    begin: float,
    end: float,
    whole: Propagator,
    budget: int,
) -> tuple[float, int]:
    """First time in [begin, end] at which an event function falls through zero.

    Parameters
    ----------
    function : EventFunction
    start : Deviation
        State at time 0.
    rates : Rates
    amplitudes : Amplitudes
    begin, end : float
        Where to search.
    whole : Propagator
        Over the time `end`.
    budget : int
        Most evaluations.

    Returns
    -------
    moment : float
        `begin` where the function is negative there, inf where it stays non-negative. Values within rounding of zero
        count as zero: a graze is no descent.
    spent : int
        Evaluations; `budget` where it did not suffice.
    """
    order = 1 if function.accelerating else 0
    over = propagator(rates, begin) if begin > 0.0 else _IDENTITY
    look = _look(function, start, rates, over, begin)
    swing = abs(function.factor) * largest_derivative(rates, amplitudes, order, begin, look.z, look.v, look.gap)
    if function.constant + min(function.drift * begin, function.drift * end) > swing:
        return math.inf, 1
    moment = begin
    spent = 1
    last = _look(function, start, rates, whole, end)
    while spent < budget:
        lifted = look.value + look.noise
        if look.value < -_DEPTH * look.noise:
            return moment, spent
        bound = largest_derivative(rates, amplitudes, order + 2, moment, look.z, look.v, look.gap)
        curvature = abs(function.factor) * bound
        step = _reach(lifted, look.slope, curvature)
        if not moment + step < end:
            return math.inf, spent
        if look.slope < 0.0 and look.slope * look.slope > 2.0 * curvature * lifted:
            # The parabola from above crosses before it turns, and until then the function falls monotonically.
            low = moment
            high = moment + 2.0 * lifted / (math.sqrt(look.slope * look.slope - 2.0 * curvature * lifted) - look.slope)
            if high >= end:
                if last.value >= -last.noise:
                    return math.inf, spent
                high = end
            return _root(function, start, rates, look, low, high, spent)
        if last.value + last.noise > 0.0:
            back = _reach(last.value + last.noise, -last.slope, curvature)
            if moment + step + back > end:
                return math.inf, spent
        moment = max(moment + step, moment * (1.0 + 2.0 * np.finfo(np.float64).eps))
        look = _look(function, start, rates, propagator(rates, moment), moment)
        spent += 1
    return moment, budget


@compiled
def _root(
    function: EventFunction, start: Deviation, rates: Rates, look: _Look, low: float, high: float, spent: int
) -> tuple[float, int]:
    """The only root in [low, high], where the function falls; the parabola of the present instant, kept inside."""
    moment = low
    for _ in range(_REFINEMENTS):
        if look.value > 0.0:
            low = moment
        else:
            high = moment
        square = look.slope * look.slope - 2.0 * look.value * look.bend
        change = -look.value / look.slope
        if look.slope < 0.0 and square > 0.0:
            change = 2.0 * look.value / (math.sqrt(square) - look.slope)
        following = moment + change
        if not low < following < high:
            # Rounding alone can point outside once the root is known to rounding.
            if abs(look.value) <= look.noise:
                return min(max(following, low), high), spent
            following = 0.5 * (low + high)
            if not low < following < high:
                return following, spent
        if abs(look.value) <= 0.25 * look.noise or abs(following - moment) <= 2.0 * np.finfo(np.float64).eps * moment:
            return following, spent
        moment = following
        look = _look(function, start, rates, propagator(rates, moment), moment)
        spent += 1
    return moment, spent
