"""The equations of one step of Radau IIA: their solution, its error, and the polynomials that it makes.

The unknowns are the accelerations a at the s nodes. With v = v0 + h A a and z = z0 + h c v0 + h^2 A^2 a the Jacobian
of a - v'(z, v, p), with one stiffness K and damping D for all nodes, is I + h D A + h^2 K A^2: in the eigenvectors of
A a number for each eigenvalue, so that no system is ever factorised and K may be renewed with every iteration.
"""

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ...compiling.roots import horner
from ..model.equations import (
    acceleration_at_no_force,
    force,
    force_terms,
    held_stiffness,
    mobility_of,
    pressure_after,
    stiffness_at,
)
from ..model.state import Body, Coefficients
from .options import Pace, Taylor12
from .radau_table import CHECKS, TABLES
from .taylor import ROUNDING
from .workspace import (
    CORRECTION,
    FORCE,
    P,
    SCRATCH,
    STAGE_A,
    STAGE_F,
    STAGE_P,
    STAGE_V,
    STAGE_Z,
    V,
    Z,
)

__all__ = ["error_of", "solve", "write_polynomials"]

_NODES, _GAPS, _INTEGRAL, _TWICE = TABLES.nodes, TABLES.gaps, TABLES.integral, TABLES.twice
_EIGENVALUES, _LEFT, _RIGHT = TABLES.eigenvalues, TABLES.left, TABLES.right
_BACKWARD, _CHECKS, _BETWEEN = TABLES.backward, TABLES.checks, TABLES.between
_DENSE, _MONIC = TABLES.dense, TABLES.monic

_ITERATIONS = 12
# What the iteration may leave of the tolerance; the error of the step is to be seen beside it.
_REMAINDER = 0.01
# An iteration that gains less than this is better tried with a shorter step.
_GAIN = 0.5
# A step's polynomials are of use up to so many times its length.
_EXTRAPOLATION = 3.0
# Order to which the energies of a step are computed, whatever its degree.
_READ = Taylor12.order()


@compiled
def solve(
    body: Body,
    coefficients: Coefficients,
    valve: float,
    method: int,
    stages: int,
    length: float,
    tolerance: float,
    pace: Pace,
    series: NDArray[np.float64],
) -> float:
    """Solve a step's equations into the stage rows; return the size of the force's terms, 0 without convergence."""
    z, v, p, a, pull = series[STAGE_Z], series[STAGE_V], series[STAGE_P], series[STAGE_A], series[STAGE_F]
    left_over, correction = series[CORRECTION], series[SCRATCH]
    mobility = mobility_of(coefficients, body.mode)
    constant = acceleration_at_no_force(coefficients, body.mode)
    damping = length * mobility * coefficients.damping

    z[0], v[0], p[0] = body.deformation, body.velocity, body.pressure
    pull[0] = force(coefficients, z[0], v[0], p[0])
    a[0] = mobility * pull[0] + constant
    for i in range(1, stages + 1):
        p[i] = pressure_after(body, coefficients, valve, _NODES[method, i] * length)
    if pace.begin + length <= _EXTRAPOLATION * pace.span:
        for i in range(1, stages + 1):
            moment = pace.begin + _NODES[method, i] * length
            a[i] = mobility * horner(series[FORCE], stages, moment) + constant
    else:
        held = 1.0 + damping + length * length * mobility * stiffness_at(coefficients, z[0], 0.0)
        for i in range(1, stages + 1):
            a[i] = a[0] / held

    before = np.inf
    for iteration in range(_ITERATIONS):
        stiffness = 0.0
        worst = 0.0
        size = 1.0 + abs(constant) / mobility
        for i in range(1, stages + 1):
            gained = 0.0
            moved = 0.0
            for j in range(stages):
                gained += _INTEGRAL[method, i - 1, j] * a[j + 1]
                moved += _TWICE[method, i - 1, j] * a[j + 1]
            v[i] = v[0] + length * gained
            z[i] = z[0] + length * (_NODES[method, i] * v[0] + length * moved)
            pull[i] = force(coefficients, z[i], v[i], p[i])
            stiffness += stiffness_at(coefficients, z[i], p[i])
            size = max(size, force_terms(coefficients, z[i], v[i]))
            left_over[i - 1] = mobility * pull[i] + constant - a[i]
            worst = max(worst, abs(left_over[i - 1]))
        if not abs(stiffness) < np.inf:
            return 0.0
        stiffness *= length * length * mobility / stages
        finest = ROUNDING * (mobility * size + abs(constant))
        weight = max(1.0 / mobility, length / (1.0 + damping + abs(stiffness)))
        if worst <= finest or worst * weight <= _REMAINDER * tolerance:
            return size
        if iteration > 1 and worst > _GAIN * before:
            return size if worst <= 8.0 * finest else 0.0
        before = worst

        _correct(method, stages, damping, stiffness, left_over, correction, a)
    return 0.0


@compiled
def _correct(
    method: int,
    stages: int,
    damping: float,
    stiffness: float,
    left_over: NDArray[np.float64],
    correction: NDArray[np.float64],
    a: NDArray[np.float64],
) -> None:
    """One simplified Newton step of the stages' accelerations: in the eigenvectors of A, a number for each eigenvalue.

    `damping` and `stiffness` are those of the step, h D and h^2 K; `correction` is written over.
    """
    for k in range(stages // 2 + 1):
        eigenvalue = _EIGENVALUES[method, k]
        divisor = 1.0 + eigenvalue * (damping + eigenvalue * stiffness)
        if k == 0:
            part = 0.0
            for j in range(stages):
                part += _LEFT[method, 0, j] * left_over[j]
            correction[0] = part / divisor.real
            continue
        real = 0.0
        imaginary = 0.0
        for j in range(stages):
            real += _LEFT[method, 2 * k - 1, j] * left_over[j]
            imaginary += _LEFT[method, 2 * k, j] * left_over[j]
        scale = 1.0 / (divisor.real * divisor.real + divisor.imag * divisor.imag)
        correction[2 * k - 1] = scale * (real * divisor.real + imaginary * divisor.imag)
        correction[2 * k] = scale * (imaginary * divisor.real - real * divisor.imag)
    for i in range(stages):
        change = 0.0
        for j in range(stages):
            change += _RIGHT[method, i, j] * correction[j]
        a[i + 1] += change


@compiled
def error_of(
    body: Body,
    coefficients: Coefficients,
    valve: float,
    method: int,
    stages: int,
    length: float,
    size: float,
    series: NDArray[np.float64],
) -> float:
    """Largest error of z, v and F within the step.

    The derivatives of the polynomials miss those of the state at the step's start, and nowhere by more, since the
    product of the distances from the nodes is greatest there. What a gap of the acceleration does to v is its
    integral where the body is soft, and its part of the force where it is stiff. What the force's polynomial misses
    is seen between the nodes.
    """
    z, v, a, pull = series[STAGE_Z], series[STAGE_V], series[STAGE_A], series[STAGE_F]
    rounding = ROUNDING * size
    mobility = mobility_of(coefficients, body.mode)
    rate_gap = -v[0]
    gap = -a[0]
    spread = 1.0
    for i in range(stages):
        weight = _BACKWARD[method, i]
        rate_gap += weight * v[i + 1]
        gap += weight * a[i + 1]
        spread += abs(weight)
    doubt = spread * rounding
    force_gap = max(0.0, abs(gap) / mobility - doubt)
    stiffness = length * mobility * (coefficients.damping + length * held_stiffness(coefficients, z[stages]))
    # What a step errs by is handed on, to the steps of a unit of time or to those before the damping has forgotten it.
    memory = _DENSE[method] * max(length, 1.0 / (1.0 + mobility * coefficients.damping))
    error = _DENSE[method] * max(length, 1.0) * max(0.0, abs(rate_gap) - spread * ROUNDING * abs(v[0]))
    error = max(error, memory * mobility * force_gap / (1.0 + stiffness))
    error = max(error, force_gap * stiffness / (1.0 + stiffness))
    for k in range(CHECKS):
        z_there = 0.0
        v_there = 0.0
        pull_there = 0.0
        for i in range(stages + 1):
            weight = _BETWEEN[method, k, i]
            z_there += weight * z[i]
            v_there += weight * v[i]
            pull_there += weight * pull[i]
        pressure = pressure_after(body, coefficients, valve, _CHECKS[method, k] * length)
        defect = abs(force(coefficients, z_there, v_there, pressure) - pull_there)
        error = max(error, defect - 2.0 * rounding)
    return error


@compiled
def write_polynomials(method: int, stages: int, length: float, series: NDArray[np.float64]) -> None:
    """Turn the stages' values into polynomials; the stages' accelerations, forces and pressures are lost.

    z and v are integrals of what the collocation makes their derivatives: from values of their own, those of a short
    step would lose their slopes to rounding.
    """
    z, v, acceleration = series[Z], series[V], series[STAGE_A]
    _interpolate(series[STAGE_P], 0, method, stages, series[P])
    _interpolate(series[STAGE_F], 0, method, stages, series[FORCE])
    _interpolate(acceleration, 1, method, stages, v)
    for n in range(stages, 0, -1):
        v[n] = length * v[n - 1] / n
    v[0] = series[STAGE_V, 0]
    # The one polynomial of its degree that equals v at the nodes.
    z[0] = series[STAGE_Z, 0]
    for n in range(stages):
        z[n + 1] = length * (v[n] - v[stages] * _MONIC[method, n]) / (n + 1)
    scale = 1.0
    for n in range(1, stages + 1):
        scale /= length
        for row in (Z, V, P, FORCE):
            series[row, n] *= scale
    for n in range(stages + 1, _READ + 2):
        z[n] = 0.0
        v[n] = 0.0
        series[P, n] = 0.0


@compiled
def _interpolate(
    values: NDArray[np.float64], first: int, method: int, stages: int, coefficients: NDArray[np.float64]
) -> None:
    """Ascending coefficients, in steps, of the polynomial through the values from node `first` on, which are lost.

    Divided differences of a smooth motion fall as fast as its coefficients. The inverse of the nodes' Vandermonde
    matrix would leave the rounding of the values, times its entries of 1e4, in every coefficient.
    """
    for level in range(1, stages + 1 - first):
        for i in range(stages, first + level - 1, -1):
            values[i] = (values[i] - values[i - 1]) * _GAPS[method, i, level]
    coefficients[0] = values[stages]
    for k in range(stages - 1, first - 1, -1):
        node = _NODES[method, k]
        degree = stages - k
        coefficients[degree] = coefficients[degree - 1]
        for n in range(degree - 1, 0, -1):
            coefficients[n] = coefficients[n - 1] - node * coefficients[n]
        coefficients[0] = values[k] - node * coefficients[0]
