"""One step of the crawler's smooth motion by Taylor series, as straight-line arithmetic."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...compiling.arithmetic import fma, sum_of_products, where
from ...compiling.compilation import formula
from ...compiling.tracing import unrolled
from ..model.equations import acceleration_at_no_force, mobility_of, retardation
from ..model.state import Body, Coefficients, STUCK
from .workspace import FORCE, P, STEP, V, WORK, Z

__all__ = ["energy_nodes", "series_coefficients", "step", "step_inputs", "value", "write_energies", "write_step"]

# Where the motion is fainter than the tolerance, an absolute test would allow steps beyond the series' radius of
# convergence. The body's own period is 2 pi, so this many natural units keep within it.
_LONGEST = 4.0


@formula
def step_inputs(
    body: Body, coefficients: Coefficients, valve: float, tolerance: float, remaining: float
) -> tuple[float, ...]:
    """What a step's recurrence begins with."""
    stuck = body.mode == STUCK
    return (
        body.deformation,
        body.velocity,
        body.pressure,
        valve,
        coefficients.lag_rate,
        coefficients.radial_coupling,
        coefficients.duffing,
        coefficients.damping,
        mobility_of(coefficients, body.mode),
        acceleration_at_no_force(coefficients, body.mode),
        tolerance,
        remaining,
        # The event function: the force while the foot sticks, its speed in the direction of motion while it slides.
        where(stuck, 1.0, 0.0),
        body.mode * -coefficients.payload_fraction,
        where(stuck, 0.0, body.mode * -retardation(coefficients, body.mode)),
    )


def series_coefficients(
    order: int,
    deformation: Any,
    velocity: Any,
    pressure: Any,
    valve: Any,
    lag_rate: Any,
    radial_coupling: Any,
    duffing: Any,
    damping: Any,
    mobility: Any,
    constant: Any,
) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
    """Coefficients of z, v, p and the force F about one instant.

    F = p (1 + Pi5 z) - z - Pi1 z^3 - 2 Pi2 v = p + S z - 2 Pi2 v, with the secant stiffness -S = 1 + Pi1 z^2 - Pi5 p;
    z' = v, v' = yielding F + constant, p' = lag_rate (valve - p). Products follow Cauchy's rule (A. Jorba and M. Zou,
    Experimental Mathematics 14 (2005) 99). Of each sum the newest factors come last: nothing else waits for them.

    Parameters
    ----------
    order : int
        Last coefficient of p and F; z and v get one more.
    deformation, velocity, pressure, valve : number
    lag_rate, radial_coupling, duffing, damping, mobility, constant : number
        Of the equations above; `damping` is 2 Pi2.

    Returns
    -------
    z, v, p, force : list of numbers
    """
    z, v, p, force = [deformation], [velocity], [pressure], []
    stiffness = []
    gap = pressure - valve
    bending, braking = duffing * -2.0, damping * -1.0
    for n in range(order + 1):
        if n > 0:
            gap = gap * (lag_rate * (-1.0 / n))
            p.append(gap)
        linear = radial_coupling * p[n] if n > 0 else fma(radial_coupling, pressure, -1.0)
        # Half of the square: each product of two different coefficients stands for two.
        middle = z[n // 2] * 0.5 * z[n // 2] if n % 2 == 0 else None
        outward = range((n + 1) // 2 - 1, -1, -1)
        half = sum_of_products([z[i] for i in outward], [z[n - i] for i in outward], middle)
        stiffness.append(fma(bending, half, linear))

        by_newest = sorted(range(n + 1), key=lambda i: max(i + 0.5, n - i))
        total = sum_of_products([stiffness[i] for i in by_newest], [z[n - i] for i in by_newest], p[n])
        force.append(fma(braking, v[n], total))
        v.append(fma(force[n], mobility, constant) if n == 0 else force[n] * (mobility * (1.0 / (n + 1))))
        z.append(v[n] * (1.0 / (n + 1)))
    return z, v, p, force


def value(coefficients: Sequence[Any], t: Any, square: Any) -> Any:
    """Value of a polynomial at `t`, whose square is given; even and odd powers do not wait for each other."""
    even, odd = list(coefficients[::2]), list(coefficients[1::2])
    sums = []
    for half in (even, odd):
        total = half.pop()
        while half:
            total = fma(total, square, half.pop())
        sums.append(total)
    return fma(sums[1], t, sums[0])


def step(order: int, _rows: Any, *inputs: Any) -> dict[int, list[Any]]:
    """The series, and a row of what else the step needs: its length, its end, and the reach of its event function.

    The length is the longest on which the last two terms of the acceleration stay below the tolerance: two, because an
    even or odd motion has every second coefficient zero; of the acceleration, because events are roots of the force.
    The event function is, but for its constant term, force_weight F + velocity_weight v + drift t; the reach is the
    sum of its negative terms and that of its positive ones, which bound it on the step, its first term, and bounds of
    its slope times the length.
    """
    *motion, tolerance, remaining, force_weight, velocity_weight, drift = inputs
    z, v, p, force = series_coefficients(order, *motion)

    exponent: Any = math.log2(_LONGEST)
    allowed = tolerance.log2()
    for n in (order - 1, order):
        last = abs(v[n + 1]) * (n + 1.0)
        exponent = ((allowed - last.log2()) * (1.0 / n)).smaller(exponent)
    length = exponent.exp2().smaller(remaining)

    square = length * length
    power, lowest, highest = length, 0.0, 0.0
    first = steepest = flattest = None
    for n in range(1, order + 1):
        coefficient = fma(force[n], force_weight, v[n] * velocity_weight)
        term = (coefficient + drift if n == 1 else coefficient) * power
        falling, rising = term.smaller(0.0), term.larger(0.0)
        lowest, highest = falling + lowest, rising + highest
        if n == 1:
            first = steepest = flattest = term
        else:
            steepest, flattest = fma(falling, float(n), steepest), fma(rising, float(n), flattest)
        power = power * length
    ends = [value(row, length, square) for row in (z, v, force)]
    return {Z: z, V: v, P: p, FORCE: force, STEP: [length, *ends, lowest, highest, first, steepest, flattest]}


def _energies(order: int, rows: Any, length: Any, radial_coupling: Any) -> dict[int, list[Any]]:
    """The integrals of p (1 + Pi5 z) v and of v^2 over a step of the given length, into the row STEP.

    A product of two series oscillates twice as fast as either, so that truncating it at their order would cost most
    of their accuracy. Gauss-Legendre quadrature of the truncated series on order / 2 + 2 nodes loses nothing, and all
    nodes are computed at once.
    """
    nodes, weights = energy_nodes(order)
    t = length.times_each(nodes)
    z, v, p = (_horner(rows[row], degree, t) for row, degree in ((Z, order + 1), (V, order + 1), (P, order)))
    area = z.fma(radial_coupling, 1.0)
    work, viscous = ((power * v).weighted_sum(weights) * length for power in (p * area, v))
    return {STEP: [*(rows[STEP][n] for n in range(WORK)), work, viscous]}


def energy_nodes(order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes in [0, 1] and weights of the quadrature of a step's energies."""
    nodes, weights = np.polynomial.legendre.leggauss(order // 2 + 2)
    return 0.5 + 0.5 * nodes, 0.5 * weights


def _horner(coefficients: Any, degree: int, t: Any) -> Any:
    total = t.fma(coefficients[degree], coefficients[degree - 1])
    for n in range(degree - 2, -1, -1):
        total = total.fma(t, coefficients[n])
    return total


write_step = unrolled(step)
write_energies = unrolled(_energies)
