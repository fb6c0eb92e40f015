"""The energies that pass through a linear crawler in a smooth motion, in closed form.

Two ways: as sums over pairs of exponentials, which know nothing of the energy balance, and by parts from the states at
the two ends. The first loses digits where rates nearly coincide and the amplitudes of their exponentials grow; the
second never does, but is the balance itself. The first is taken wherever it is as good.
"""

import math

from ...compiling.compilation import compiled
from ..model.state import Body, Coefficients, Ledger
from ..motion.energy import posted
from ..steps.propagator import decay, Rates
from .search import Deviation

__all__ = ["account_linear"]

# How much larger the terms of the sum over exponentials may be than those of the energy balance.
_INDEPENDENCE = 32.0


@compiled
def account_linear(
    ledger: Ledger,
    before: Body,
    after: Body,
    coefficients: Coefficients,
    valve: float,
    rates: Rates,
    start: Deviation,
    end: Deviation,
    t: float,
) -> Ledger:
    """Add the energies of a smooth motion of length `t`: int p v dt, int 2 Pi2 v^2 dt, and drag times distance."""
    work, viscous, size = _by_exponentials(rates, start, t)
    limit = _INDEPENDENCE * (
        abs(start.gap) * (abs(start.z) + abs(end.z))
        + start.z * start.z
        + end.z * end.z
        + (start.v * start.v + end.v * end.v) / rates.mobility
    )
    if not size <= limit:
        work, viscous = _by_parts(rates, start, end, t)
    work += valve * (after.deformation - before.deformation)
    return posted(ledger, before, after, coefficients, work, viscous)


@compiled
def _by_exponentials(rates: Rates, start: Deviation, t: float) -> tuple[float, float, float]:
    """Integrals of q v and of 2 Pi2 v^2, and the size of the terms summed.

    Reciprocals follow from mu_1 mu_2 = Y and (lambda + mu_1) (lambda + mu_2) = lambda^2 + 2 Pi2 Y lambda + Y.
    """
    lag, mean = rates.lag, rates.mean
    lagging = decay(lag * t)
    if rates.oscillates:
        first, second = complex(mean, -rates.spread), complex(mean, rates.spread)
        one_over_apart = complex(0.0, -0.5 / rates.spread)
        envelope, angle = decay(mean * t), rates.spread * t
        early = complex(envelope * math.cos(angle), envelope * math.sin(angle))
        late = early.conjugate()
        resonance = (lag - mean) * (lag - mean) + rates.spread * rates.spread
    else:
        first, second = complex(rates.slow, 0.0), complex(rates.fast, 0.0)
        one_over_apart = complex(0.5 / rates.spread, 0.0)
        early, late = complex(decay(rates.slow * t), 0.0), complex(decay(rates.fast * t), 0.0)
        resonance = (lag - rates.slow) * (lag - rates.fast)
    share = rates.mobility * start.gap / resonance
    z, v = start.z - share, start.v + lag * share
    # v = sum of amplitude e^(-rate t)
    one = -first * (v + second * z) * one_over_apart
    two = second * (v + first * z) * one_over_apart
    three = -lag * share

    # int e^(-(rate + rate') t) dt for each pair
    half = 0.5 / rates.mobility
    one_one = (1.0 - early * early) * second * half
    two_two = (1.0 - late * late) * first * half
    one_two = -math.expm1(-2.0 * mean * t) / (2.0 * mean) if mean > 0.0 else t
    both = 1.0 / (lag * (lag + 2.0 * mean) + rates.mobility)
    one_lag = (1.0 - early * lagging) * (second + lag) * both
    two_lag = (1.0 - late * lagging) * (first + lag) * both
    lag_lag = -math.expm1(-2.0 * lag * t) / (2.0 * lag)

    with_lag = (one * one_lag + two * two_lag).real
    heat = (one * one * one_one + two * two * two_two).real + 2.0 * (one * two).real * one_two
    heat += three * (2.0 * with_lag + three * lag_lag)
    work = start.gap * (with_lag + three * lag_lag)

    sizes = _size(one), _size(two), abs(three)
    crossing = both * (sizes[0] * (_size(second) + lag) + sizes[1] * (_size(first) + lag))
    squares = 2.0 * half * (sizes[0] * sizes[0] * _size(second) + sizes[1] * sizes[1] * _size(first))
    squares += 2.0 * sizes[0] * sizes[1] * one_two + 2.0 * sizes[2] * crossing + sizes[2] * sizes[2] / lag
    return work, rates.damping * heat, rates.damping * squares + abs(start.gap) * (crossing + sizes[2] / lag)


@compiled
def _size(number: complex) -> float:
    return abs(number.real) + abs(number.imag)


@compiled
def _by_parts(rates: Rates, start: Deviation, end: Deviation, t: float) -> tuple[float, float]:
    """The same from the ends: multiply the equation of motion by e^(-lambda t), then by v, and integrate."""
    lag = rates.lag
    lagging = decay(lag * t)
    grown = lagging * end.z - start.z
    squared = -math.expm1(-2.0 * lag * t) / (2.0 * lag)
    pushed = rates.mobility * start.gap * squared - (lagging * end.v - start.v)
    friction = rates.mobility * rates.damping
    moment = (pushed - (lag + friction) * grown) / (lag * (lag + friction) + rates.mobility)
    work = start.gap * (grown + lag * moment)
    kinetic = 0.5 * (end.v - start.v) * (end.v + start.v) / rates.mobility
    elastic = 0.5 * (end.z - start.z) * (end.z + start.z)
    return work, work - kinetic - elastic
