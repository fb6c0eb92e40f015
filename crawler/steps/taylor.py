"""Taylor series of the crawler's smooth motion, by recurrence.

While the valve holds and the foot neither breaks loose nor stops, the right-hand side is a polynomial in z, v and
an exponential p, so each coefficient follows from those before it (A. Jorba and M. Zou, Experimental Mathematics 14
(2005) 99). Expansion costs about 0.75 N^2 multiplications and additions at order N.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, formula, inlined, merged
from ...compiling.roots import horner
from ..model.equations import (
    force,
    force_terms,
    mobility_of,
    moved,
    pressure_after,
)
from ..model.state import Body, Coefficients
from .options import AFRESH, Method, Pace, Situation, TAYLOR
from .taylor_series import step_inputs, write_step
from .workspace import END_FORCE, END_V, END_Z, FORCE, LENGTH, STEP, V, Z

__all__ = [
    "ORDERS",
    "ROUNDING",
    "SHORTENINGS",
    "TRUST",
    "expand",
    "is_sound",
    "order_for",
    "state_at",
    "taylor_step",
    "trusted",
]

ORDERS = tuple(TAYLOR)
# Largest defect of a step, in tolerances: a sound step's is about one.
TRUST = 4.0
# Rounding of a force relative to its terms, below which no defect is to be seen.
ROUNDING = 8.0 * float(np.finfo(np.float64).eps)
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
    coefficients: Coefficients,
    valve: float,
    method: Method,
    tolerance: float,
    remaining: float,
    series: NDArray[np.float64],
) -> None:
    """Fill `series` with Taylor coefficients about the present instant, and with the step on which they can be trusted.

    Parameters
    ----------
    body : Body
    coefficients : Coefficients
    valve : float
        The valve while the series holds, 0 or 1.
    method : Method
        Its order, known when this is compiled, is the last coefficient of the force; z and v get one more.
    tolerance : float
        Largest last term of the acceleration's series.
    remaining : float
        Longest step asked for.
    series : (ROWS, WIDTH) array
        Written in place.
    """
    inputs = step_inputs(body, coefficients, valve, tolerance, remaining)
    write_step(method, inputs, series)


@inlined
def taylor_step(now: Situation, _pace: Pace) -> tuple[float, Body, Pace]:
    """One step, as short as it takes for the series to satisfy the equation of motion at its end.

    The last coefficients can be blind to what is to come: from rest z grows as t^3, and a cubic spring first acts at
    t^9. The defect, the force at the state less the force's own series, is not.

    Parameters
    ----------
    now : Situation
        Whose workspace, a (ROWS, WIDTH) array, receives the step's polynomials.
    pace : Pace
        Of no matter here.

    Returns
    -------
    length : float
        nan where there is no finite series.
    end : Body
        State at the end of the step, were the motion to go on.
    pace : Pace
        AFRESH: every series starts anew.
    """
    hold, options, series = now.hold, now.options, now.workspace
    remaining = hold.end - now.elapsed
    expand(now.body, now.coefficients, hold.valve, options.method, options.tolerance, remaining, series)
    since = now.elapsed - hold.begin
    length, end = trusted(
        now.opening, now.body, now.coefficients, hold.valve, since, options.tolerance, options.order, series
    )
    return length, end, AFRESH


@merged
def trusted(
    opening: Body,
    body: Body,
    coefficients: Coefficients,
    valve: float,
    elapsed: float,
    tolerance: float,
    order: int,
    series: NDArray[np.float64],
) -> tuple[float, Body]:
    """How far an expanded series can be trusted, nan where it is not finite, and the state there.

    `elapsed` is the time from `opening`, the body at the start of the valve's present state.
    """
    length, z, v = series[STEP, LENGTH], series[STEP, END_Z], series[STEP, END_V]
    expected = series[STEP, END_FORCE]
    if not abs(series[V, order + 1]) < np.inf:
        return np.nan, body
    pressure = pressure_after(opening, coefficients, valve, elapsed + length)
    for _ in range(SHORTENINGS):
        if is_sound(coefficients, body.mode, z, v, pressure, expected, tolerance):
            break
        defect = mobility_of(coefficients, body.mode) * abs(force(coefficients, z, v, pressure) - expected)
        shrink = math.exp(math.log(tolerance / defect) / (order + 1))
        length *= max(0.25, min(0.9, shrink))
        z = horner(series[Z], order + 1, length)
        v = horner(series[V], order + 1, length)
        expected = horner(series[FORCE], order, length)
        pressure = pressure_after(opening, coefficients, valve, elapsed + length)
    return length, moved(body, coefficients, z, v, pressure, length)


@formula
def is_sound(
    coefficients: Coefficients, mode: int, z: float, v: float, pressure: float, expected: float, tolerance: float
) -> bool | np.bool_:
    """Whether the force at a step's end is the `expected` one of the series but for the tolerance, and rounding."""
    defect = abs(force(coefficients, z, v, pressure) - expected) - ROUNDING * force_terms(coefficients, z, v)
    return mobility_of(coefficients, mode) * defect <= TRUST * tolerance


@compiled
def state_at(
    body: Body, coefficients: Coefficients, pressure: float, order: int, t: float, series: NDArray[np.float64]
) -> Body:
    """State a time `t` into the step, where the pressure is `pressure`."""
    return moved(body, coefficients, horner(series[Z], order + 1, t), horner(series[V], order + 1, t), pressure, t)
