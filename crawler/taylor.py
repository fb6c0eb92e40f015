"""Taylor series of the crawler's smooth motion, by recurrence.

While the valve holds and the foot neither breaks loose nor stops, the right-hand side is a polynomial in z, v and
an exponential p, so each coefficient follows from those before it (A. Jorba and M. Zou, Experimental Mathematics 14
(2005) 99). Expansion costs about 0.75 N^2 multiplications and additions at order N.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled
from .body import Body, Physics, STUCK
from .equations import acceleration_at_no_force, inverse_mass, moved, retardation
from .polynomial import horner
from .recurrence import write_step
from .workspace import V, Z

__all__ = ["ORDERS", "expand", "order_for", "state_at"]

ORDERS = (8, 12, 16, 20)


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


@compiled
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


@compiled
def state_at(body: Body, physics: Physics, pressure: float, order: int, t: float, series: NDArray[np.float64]) -> Body:
    """State a time `t` into the step, where the pressure is `pressure`."""
    return moved(body, physics, horner(series[Z], order + 1, t), horner(series[V], order + 1, t), pressure, t)
