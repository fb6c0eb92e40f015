"""Closed form of a linear crawler's smooth motion.

Without a cubic spring and radial coupling the body is a damped oscillator that the pressure's gap to the valve drives.
With y = z - z_rest, q = p - u and the rate Y per force of the present motion,

    y' = v,  v' = Y (q - y - 2 Pi2 v),  q' = -q / Pi4,

so that the state a time t later is a matrix times the state now. Its entries are divided differences of exp at the
three rates of decay mu_1, mu_2 (roots of mu^2 - 2 Pi2 Y mu + Y) and lambda = 1 / Pi4: S = exp[mu_1, mu_2] answers a
blow, Y G = Y exp[mu_1, mu_2, lambda] a gap. Each is evaluated by the form that keeps its digits (A. McCurdy, K. C. Ng
and B. N. Parlett, Mathematics of Computation 43 (1984) 501): as a quotient where rates are far apart on the scale of
1 / t, as a series about their mean where they are not. Critical damping and resonance with the lag are no exceptions.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import allocating, compiled
from ..model.columns import coefficients_at
from ..model.equations import mobility_of
from ..model.state import Coefficients, FORWARD, STUCK
from .workspace import CHANGES

__all__ = [
    "ENTRIES",
    "Propagator",
    "Rates",
    "decay",
    "propagator",
    "rates_of",
    "table_shape",
    "tabulate",
    "tabulate_each",
    "tabulated",
]

# Arithmetic on the denormal numbers beyond takes a hundred times as long.
_FAINTEST_EXPONENT = 575.0
# Rates closer than this over t are near each other; the series then needs so many terms at most.
_NEAR = 1.0
_TERMS = 18


class Rates(NamedTuple):
    """What the closed form needs of one crawler in one motion of its foot."""

    mobility: float  # Y, rate v' per force
    damping: float  # 2 Pi2
    lag: float  # lambda
    mean: float  # Pi2 Y, mean of the body's two rates
    spread: float  # half the distance of the two, or the angular frequency where they are complex
    oscillates: bool  # whether they are complex
    slow: float  # the two where they are real, else their mean
    fast: float


class Propagator(NamedTuple):
    """State (z, v, q) a time t later per state now; z relative to its place of rest."""

    z_z: float
    z_v: float
    z_q: float
    v_z: float
    v_v: float
    v_q: float
    q_q: float


ENTRIES = len(Propagator._fields)


@compiled
def rates_of(coefficients: Coefficients, mode: int) -> Rates:
    """Rates of decay of a linear body whose foot is in the given motion."""
    mobility = mobility_of(coefficients, mode)
    mean = 0.5 * mobility * coefficients.damping
    frequency = math.sqrt(mobility)
    oscillates = mean < frequency
    spread = math.sqrt(abs(mean - frequency)) * math.sqrt(mean + frequency)
    fast = mean if oscillates else mean + spread
    slow = mean if oscillates else mobility / fast
    return Rates(mobility, coefficients.damping, coefficients.lag_rate, mean, spread, oscillates, slow, fast)


@compiled
def propagator(rates: Rates, t: float) -> Propagator:
    """Propagator over a time `t` >= 0.

    Parameters
    ----------
    rates : Rates
    t : float

    Returns
    -------
    Propagator
        Every entry to some 1e-15 of its own envelope, but for the phase, which is as well known as omega t is.
    """
    lagging = decay(rates.lag * t)
    if rates.oscillates:
        envelope = decay(rates.mean * t)
        angle = rates.spread * t
        cosine = envelope * math.cos(angle)
        blow = envelope * math.sin(angle) / rates.spread
        at_rest = cosine + rates.mean * blow
        blow_rate = cosine - rates.mean * blow
        gap, gap_rate = _forced_oscillation(rates, t, lagging, cosine, blow)
    else:
        slowly = decay(rates.slow * t)
        blow = t * slowly * _mean_exponential(2.0 * rates.spread * t)
        at_rest = slowly + rates.slow * blow
        blow_rate = decay(rates.fast * t) - rates.slow * blow
        gap, gap_rate = _forceddecay(rates, t, blow)
    y = rates.mobility
    return Propagator(at_rest, blow, y * gap, -y * blow, blow_rate, y * gap_rate, lagging)


@compiled
def _forced_oscillation(rates: Rates, t: float, lagging: float, cosine: float, blow: float) -> tuple[float, float]:
    """Answer G to a unit gap, and G', where the body's rates are complex."""
    apart = rates.mean - rates.lag
    square = apart * apart + rates.spread * rates.spread
    if square * t * t < _NEAR:
        gap = _clustered(rates, t)
        return gap, blow - rates.lag * gap
    gap = (lagging - cosine - apart * blow) / square
    turning = rates.mobility - rates.mean * rates.lag
    return gap, (rates.lag * (cosine - lagging) + turning * blow) / square


@compiled
def _forceddecay(rates: Rates, t: float, blow: float) -> tuple[float, float]:
    """Answer G to a unit gap, and G', where the body's rates are real."""
    low = min(rates.slow, rates.lag)
    high = max(rates.fast, rates.lag)
    middle = max(rates.slow, min(rates.fast, rates.lag))
    if (high - low) * t < _NEAR:
        gap = _clustered(rates, t)
        return gap, blow - rates.lag * gap
    slower = t * decay(low * t) * _mean_exponential((middle - low) * t)
    faster = t * decay(middle * t) * _mean_exponential((high - middle) * t)
    gap = (slower - faster) / (high - low)
    # With the slowest rate split off, neither term outgrows the answer.
    return gap, faster - low * gap


@compiled
def _clustered(rates: Rates, t: float) -> float:
    """exp[mu_1, mu_2, lambda] where the three rates are near each other: the series about their mean.

    sum_k h_k / (k + 2)!, h_k the complete symmetric polynomial of the deviations, whose sum is 0.
    """
    apart = (rates.lag - rates.mean) * t
    square = rates.spread * rates.spread * t * t
    if rates.oscillates:
        square = -square
    pairs = -square - apart * apart / 3.0
    product = -(2.0 / 3.0) * apart * (apart * apart / 9.0 - square)
    # h_k / (k + 2)!, the last three
    oldest, older, newest = 0.0, 0.5, 0.0
    total = 0.5
    for k in range(2, _TERMS):
        here = (-pairs * older + product * oldest / (k + 0.0)) / ((k + 1.0) * (k + 2.0))
        oldest, older, newest = older, newest, here
        total += here
    return t * t * decay((2.0 * rates.mean + rates.lag) * t / 3.0) * total


@compiled
def decay(exponent: float) -> float:
    """e^-exponent, and 0 where it is too small to matter."""
    return math.exp(-exponent) if exponent < _FAINTEST_EXPONENT else 0.0


@compiled
def _mean_exponential(exponent: float) -> float:
    """Mean of exp over [-exponent, 0]."""
    return -math.expm1(-exponent) / exponent if exponent > 0.0 else 1.0


@allocating
def tabulate(coefficients: Coefficients, hold: float, count: int) -> NDArray[np.float64]:
    """Propagators from a hold's start to its samples, the same for every hold of a run.

    Parameters
    ----------
    coefficients : Coefficients
    hold : float
    count : int
        Samples in a hold.

    Returns
    -------
    (2 count + CHANGES, ENTRIES) array
        Of the resting foot, then of the sliding one; then room for the tangents.
    """
    table = np.empty((2 * count + CHANGES, ENTRIES))
    for sliding in range(2):
        rates = rates_of(coefficients, FORWARD if sliding else STUCK)
        for j in range(count):
            entries = propagator(rates, hold * ((j + 1) / count))
            for i in range(ENTRIES):
                table[sliding * count + j, i] = entries[i]
    return table


@allocating
def tabulate_each(
    columns: NDArray[np.float64], who: NDArray[np.int64], hold: float, count: int, tables: NDArray[np.float64]
) -> None:
    """Write the tables of some crawlers, whose coefficients are columns, each at its place.

    Where there is but one table all share it.
    """
    for k in range(len(who)):
        i = who[k]
        tables[i % len(tables)] = tabulate(coefficients_at(columns, i), hold, count)


def table_shape(count: int) -> tuple[int, int]:
    """Shape of :func:`tabulate`'s table."""
    return 2 * count + CHANGES, ENTRIES


@compiled
def tabulated(table: NDArray[np.float64], row: int) -> Propagator:
    """One row of :func:`tabulate`."""
    entries = table[row]
    return Propagator(entries[0], entries[1], entries[2], entries[3], entries[4], entries[5], entries[6])
