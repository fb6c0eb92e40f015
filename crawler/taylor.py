"""Taylor series of the crawler's smooth motion, by recurrence.

While the valve holds and the foot neither breaks loose nor stops, the right-hand side is a polynomial in z, v and
an exponential p, so each coefficient follows from those before it (A. Jorba and M. Zou, Experimental Mathematics 14
(2005) 99). Expansion costs about 0.75 N^2 multiplications and additions at order N.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled, merged
from .body import Body, Physics, STUCK
from .control import AFRESH, Control, Pace
from .equations import acceleration_at_no_force, force, force_terms, inverse_mass, moved, pressure_after, retardation
from .polynomial import horner
from .recurrence import write_step
from .workspace import END_FORCE, END_V, END_Z, FORCE, LENGTH, STEP, V, Z

__all__ = ["ORDERS", "ROUNDING", "SHORTENINGS", "TRUST", "expand", "order_for", "state_at", "taylor_step"]

ORDERS = (8, 12, 16, 20)
# Largest defect of a step, in tolerances: a sound step's is about one.
TRUST = 4.0
# Rounding of a force relative to its terms, below which no defect is to be seen.
ROUNDING = 8.0 * np.finfo(np.float64).eps
SHORTENINGS = 40


def order_for(tolerance: float) -> int:
    """Order at which the cost per unit of time is near its least: 4 for every 3 digits, and 4 more; 20 at most.

    Jorba and Zou's 1 - ln(tolerance) / 2 counts the series alone and comes out 4 lower; a step also pays for its
    events and for the hold's end. `benchmarks/taylor_order.py` measures it.

    Parameters
    ----------
    tolerance : float
        Largest term neglected from the acceleration's series, natural units.

    Returns
    -------
    int
        One of ORDERS.
    """
    wanted = 4.0 - 4.0 / 3.0 * math.log10(tolerance) - 1e-9
    return next((order for order in ORDERS if order >= wanted), ORDERS[-1])


@merged
def expand(
    body: Body,
    physics: Physics,
    valve: float,
    order: int,
    tolerance: float,
    remaining: float,
    series: NDArray[np.float64],
) -> None:
    """Fill `series` with Taylor coefficients about the present instant, and with the step on which they can be trusted.

    Parameters
    ----------
    body : Body
    physics : Physics
    valve : float
        The valve while the series holds, 0 or 1.
    order : int
        One of ORDERS: last coefficient of the force; z and v get one more.
    tolerance : float
        Largest last term of the acceleration's series.
    remaining : float
        Longest step asked for.
    series : (ROWS, WIDTH) array
        Written in place.
    """
    stuck = body.motion == STUCK
    inputs = (
        body.deformation,
        body.velocity,
        body.pressure,
        valve,
        physics.lag_rate,
        physics.radial_coupling,
        physics.duffing,
        physics.damping,
        inverse_mass(physics, body.motion),
        acceleration_at_no_force(physics, body.motion),
        tolerance,
        remaining,
        # The event function: the force while the foot sticks, its speed in the direction of motion while it slides.
        1.0 if stuck else 0.0,
        -body.motion * physics.payload_fraction,
        0.0 if stuck else -body.motion * retardation(physics, body.motion),
    )
    # Each literal order is compiled on its own.
    if order == 8:
        write_step(8, inputs, series)
    elif order == 12:
        write_step(12, inputs, series)
    elif order == 16:
        write_step(16, inputs, series)
    else:
        write_step(20, inputs, series)


def taylor_step(
    opening: Body,
    body: Body,
    physics: Physics,
    valve: float,
    elapsed: float,
    remaining: float,
    control: Control,
    pace: Pace,
    series: NDArray[np.float64],
) -> tuple[float, Body, Pace]:
    """One step, as short as it takes for the series to satisfy the equation of motion at its end.

    The last coefficients can be blind to what is to come: from rest z grows as t^3, and a cubic spring first acts at
    t^9. The defect, the force at the state less the force's own series, is not.

    Parameters
    ----------
    opening, body : Body
        At the start of the hold and of the step.
    physics : Physics
    valve : float
    elapsed, remaining : float
        Time from the start of the hold, and to its end.
    control : Control
    pace : Pace
        Of no matter here.
    series : (ROWS, WIDTH) array
        Receives the step's polynomials.

    Returns
    -------
    length : float
        nan where there is no finite series.
    end : Body
        State at the end of the step, were the motion to go on.
    pace : Pace
        AFRESH: every series starts anew.
    """
    expand(body, physics, valve, control.order, control.tolerance, remaining, series)
    if not abs(series[V, control.order + 1]) < np.inf:
        return np.nan, body, AFRESH
    yielding = inverse_mass(physics, body.motion)
    length, z, v = series[STEP, LENGTH], series[STEP, END_Z], series[STEP, END_V]
    expected = series[STEP, END_FORCE]
    pressure = pressure_after(opening, physics, valve, elapsed + length)
    for _ in range(SHORTENINGS):
        rounding = ROUNDING * force_terms(physics, z, v)
        defect = abs(force(physics, z, v, pressure) - expected)
        if yielding * (defect - rounding) <= TRUST * control.tolerance:
            break
        shrink = math.exp(math.log(control.tolerance / (yielding * defect)) / (control.order + 1))
        length *= max(0.25, min(0.9, shrink))
        z = horner(series[Z], control.order + 1, length)
        v = horner(series[V], control.order + 1, length)
        expected = horner(series[FORCE], control.order, length)
        pressure = pressure_after(opening, physics, valve, elapsed + length)
    return length, moved(body, physics, z, v, pressure, length), AFRESH


@compiled
def state_at(body: Body, physics: Physics, pressure: float, order: int, t: float, series: NDArray[np.float64]) -> Body:
    """State a time `t` into the step, where the pressure is `pressure`."""
    return moved(body, physics, horner(series[Z], order + 1, t), horner(series[V], order + 1, t), pressure, t)
