"""Taylor series of the crawler's smooth motion, by recurrence.

While the valve holds and the foot neither breaks loose nor stops, the right-hand side is a polynomial in z, v and
an exponential p, so each coefficient follows from those before it (A. Jorba and M. Zou, Experimental Mathematics 14
(2005) 99). Expansion costs about 1.5 N^2 multiplications at order N.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled
from .body import Body, Physics, STUCK
from .equations import acceleration_at_no_force, foot_velocity_at, inverse_mass, retardation
from .polynomial import horner, LARGEST_DEGREE

__all__ = ["ROWS", "WIDTH", "expand", "order_for", "state_at", "step_length"]

# Rows of a workspace: series of z, v, p, z^2, F, -(secant stiffness), and one scratch row for events and energy.
ROWS = 7
WIDTH = LARGEST_DEGREE + 2
Z, V, P, SQUARE, FORCE, STIFFNESS, SCRATCH = range(ROWS)

# Where the motion is fainter than the tolerance, an absolute test would allow steps beyond the series' radius of
# convergence. The body's own period is 2 pi, so this many natural units keep within it.
_LONGEST_STEP = 4.0

_RECIPROCAL = np.array([0.0] + [1.0 / n for n in range(1, WIDTH + 1)])


def order_for(tolerance: float) -> int:
    """Order at which the cost per unit of time is near its least: 4 for every 3 digits asked for, and 4 more.

    Jorba and Zou's 1 - ln(tolerance) / 2 counts the series alone and comes out 4 lower; a step also pays for its
    events and for the hold's end. `benchmarks/taylor_order.py` measures it.

    Parameters
    ----------
    tolerance : float
        Largest term neglected from the acceleration's series, natural units.

    Returns
    -------
    int
    """
    return min(LARGEST_DEGREE, math.ceil(4.0 - 4.0 / 3.0 * math.log10(tolerance) - 1e-9))


@compiled
def expand(body: Body, physics: Physics, valve: float, order: int, series: NDArray[np.float64]) -> None:
    """Fill `series` with Taylor coefficients about the present instant.

    F = p (1 + Pi5 z) - z - Pi1 z^3 - 2 Pi2 v;  v' = F / (1 - r) - slope in stick, F / (r (1 - r)) + k / r in slip.

    Parameters
    ----------
    body : Body
    physics : Physics
    valve : float
        The valve while the series holds, 0 or 1.
    order : int
        Last coefficient of the force; z and v get one more.
    series : (ROWS, WIDTH) array
        Written in place.
    """
    z, v, p = series[Z], series[V], series[P]
    square, force, stiffness = series[SQUARE], series[FORCE], series[STIFFNESS]

    term = body.pressure - valve
    p[0] = body.pressure
    for n in range(1, order + 1):
        term *= -physics.lag_rate * _RECIPROCAL[n]
        p[n] = term

    yielding = inverse_mass(physics, body.motion)
    constant = acceleration_at_no_force(physics, body.motion)

    z[0] = body.deformation
    v[0] = body.velocity
    for n in range(order + 1):
        total = 0.0
        for i in range((n + 1) // 2):
            total += z[i] * z[n - i]
        total *= 2.0
        if n % 2 == 0:
            total += z[n // 2] * z[n // 2]
        square[n] = total
        stiffness[n] = physics.radial_coupling * p[n] - physics.duffing * total
        if n == 0:
            stiffness[0] -= 1.0
        total = p[n] - physics.damping * v[n]
        for i in range(n + 1):
            total += stiffness[i] * z[n - i]
        force[n] = total
        acceleration = total * yielding
        if n == 0:
            acceleration += constant
        v[n + 1] = acceleration * _RECIPROCAL[n + 1]
        z[n + 1] = v[n] * _RECIPROCAL[n + 1]


@compiled
def step_length(order: int, tolerance: float, series: NDArray[np.float64]) -> float:
    """Longest step on which the last two terms of the acceleration stay below `tolerance`.

    Two terms, because an even or odd motion has every second coefficient zero. The acceleration and not the
    position is bounded because events are roots of the force.
    """
    v = series[V]
    length = _LONGEST_STEP
    for n in range(order - 1, order + 1):
        last = (n + 1) * abs(v[n + 1])
        if last > 0.0:
            length = min(length, math.exp(math.log(tolerance / last) / n))
    return length


@compiled
def state_at(body: Body, physics: Physics, pressure: float, order: int, t: float, series: NDArray[np.float64]) -> Body:
    """State a time `t` into the step; the foot by momentum."""
    z = horner(series[Z], order + 1, t)
    v = horner(series[V], order + 1, t)
    foot = body.foot
    foot_velocity = 0.0
    if body.motion != STUCK:
        payload = physics.payload_fraction
        momentum = body.foot_velocity + payload * body.velocity
        foot += (momentum - 0.5 * retardation(physics, body.motion) * t) * t - payload * (z - body.deformation)
        # At a stop rounding can leave it a hair beyond zero.
        foot_velocity = body.motion * max(body.motion * foot_velocity_at(body, physics, v, t), 0.0)
    return Body(z, v, pressure, foot, foot_velocity, body.motion, body.slips)
