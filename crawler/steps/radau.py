"""Radau IIA collocation of the crawler's smooth motion, for scenes too stiff for a Taylor series.

A step is polynomials again, now those that satisfy v' = F / mass and z' = v at the nodes, so that all that follows a
step, its events above all, is that of `stickslip.crawler.steps.taylor`. The method is L-stable: its step is as long
as the motion is smooth, however fast the body would return to that motion if it were disturbed (E. Hairer and G.
Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.8; J. Comput. Appl. Math. 111 (1999) 93).

The unknowns are the accelerations a at the s nodes. With v = v0 + h A a and z = z0 + h c v0 + h^2 A^2 a the Jacobian
of a - v'(z, v, p), with one stiffness K and damping D for all nodes, is I + h D A + h^2 K A^2: in the eigenvectors of
A a number for each eigenvalue, so that no system is ever factorised and K may be renewed with every iteration.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, inlined
from ...compiling.roots import horner
from ..model.equations import (
    acceleration_at_no_force,
    foot_velocity_at,
    force,
    force_terms,
    held_stiffness,
    is_free,
    mobility_of,
    pressure_after,
    stiffness_at,
)
from ..model.state import Body, Coefficients, STUCK
from .options import AFRESH, Pace, Situation, Taylor12
from .radau_table import CHECKS, STAGES, TABLES
from .taylor import expand, ROUNDING, state_at
from .workspace import (
    CORRECTION,
    FIRST,
    FLATTEST,
    FORCE,
    HIGHEST,
    LOWEST,
    P,
    SCRATCH,
    STAGE_A,
    STAGE_F,
    STAGE_P,
    STAGE_V,
    STAGE_Z,
    STEEPEST,
    STEP,
    V,
    Z,
)

__all__ = ["collocate", "radau_step", "refine_event_step", "stages_for"]

_NODES, _GAPS, _INTEGRAL, _TWICE = TABLES.nodes, TABLES.gaps, TABLES.integral, TABLES.twice
_EIGENVALUES, _LEFT, _RIGHT = TABLES.eigenvalues, TABLES.left, TABLES.right
_BACKWARD, _CHECKS, _BETWEEN = TABLES.backward, TABLES.checks, TABLES.between
_DENSE, _MONIC, _CHECK_PRODUCT = TABLES.dense, TABLES.monic, TABLES.check_product

# Tolerances down to which each method is the cheapest.
_FINEST = (3e-5, 2e-8, 2e-11, 0.0)
_ITERATIONS = 12
# What the iteration may leave of the tolerance; the error of the step is to be seen beside it.
_REMAINDER = 0.01
# An iteration that gains less than this is better tried with a shorter step.
_GAIN = 0.5
# So many trials take any step below the least float.
_TRIALS = 500
_SAFETY = 0.9
_SHORTEN, _LENGTHEN = 0.1, 10.0
# A step's polynomials are of use up to so many times its length.
_EXTRAPOLATION = 3.0
# An event before this part of a step is sought again in a step that ends this much beyond it.
_EARLY, _BEYOND = 0.8, 1.1
# The powers of a shorter step than this, by which its polynomials are divided, leave the range of floats.
_SHORTEST = 1e-25
# A step errs by at most so much of the grip, or of the slip, and so shows whether it ends: without friction a body may
# pull by far less than the tolerance, and an event made of errors alone would be followed by others without end.
_SHARE = 0.05
# The force and the rate are not asked for more sharply than to so much of the force's terms.
_SHARPEST = 1e-13
# An event is believed of a step that errs by at most this part of the grip or the slip at its start.
_BLUR = 1e-3
# An L-stable method would hold fast what an unstable body lets go: its step is so many e-folds at most.
_E_FOLDS = 1.0
# A grip is on its threshold, and a motion begins with a Taylor series, within so many tolerances.
_NEAR = 100.0
_LONGEST_START = 1.0
# Order to which the energies of a step are computed, whatever its degree.
_READ = Taylor12.order()
_SETTLED = 0.01


def stages_for(tolerance: float) -> int:
    """Number of stages, 5, 7, 9 or 11, at which the cost per unit of time is near its least.

    `benchmarks/stiff_solver.py` measures it. Three stages are nowhere cheaper.

    Parameters
    ----------
    tolerance : float
        Error allowed in the dense force, velocity and deformation, natural units.

    Returns
    -------
    int
    """
    for stages, finest in zip(STAGES, _FINEST, strict=True):
        if tolerance > finest:
            return stages
    return STAGES[-1]


@compiled
def collocate(
    body: Body,
    coefficients: Coefficients,
    valve: float,
    remaining: float,
    stages: int,
    tolerance: float,
    pace: Pace,
    series: NDArray[np.float64],
) -> tuple[float, Pace]:
    """Fill `series` with the collocation polynomials of the longest step that meets the tolerance.

    Parameters
    ----------
    body : Body
    coefficients : Coefficients
    valve : float
        The valve while the step lasts, 0 or 1.
    remaining : float
        Longest step asked for.
    stages : int
        One of `STAGES`: the degree of all polynomials. Coefficient `stages` + 1 of z and v, which a Taylor series of
        that order would have, is zero.
    tolerance : float
        Largest error of z, v and F within the step.
    pace : Pace
        What the last step left, or AFRESH after an event or a change of the valve.
    series : (ROWS, WIDTH) array
        Rows Z, V, P and FORCE are written, in powers of the time since the step's start.

    Returns
    -------
    length : float
        nan where no step could be found.
    pace : Pace
        For the next step.
    """
    method = (stages - STAGES[0]) // 2
    longest = min(remaining, _E_FOLDS / _growth_rate(body, coefficients, valve))
    length = pace.length
    if not length > 0.0:
        expand(body, coefficients, valve, Taylor12(), tolerance, remaining, series)
        short = _taylor_length(body, coefficients, valve, stages, tolerance, series)
        # The first instants of a slip, or of a grip on its threshold, decide which motion this is.
        nearness = _NEAR * tolerance if body.mode == STUCK else 0.0
        undecided = not coefficients.anchored and _clearance(body, coefficients) <= nearness
        if undecided or remaining <= short:
            short = min(short, remaining)
            return short, Pace(_LENGTHEN * short, short, short, 0.0, 0.0)
        length = _first_length(body, coefficients, valve, method, stages, tolerance, series)
    fine = tolerance
    if not coefficients.anchored:
        fine = min(tolerance, max(_SHARE * _clearance(body, coefficients), _SHARPEST))
    length = min(length, longest)
    power = 1.0 / (stages + 1.0)
    shortened = False
    for _ in range(_TRIALS):
        # Two equal steps to the end rather than a long one and a stump.
        if 0.5 * remaining < length < remaining and pace.begin == pace.span:
            length = 0.5 * remaining
        size = _solve(body, coefficients, valve, method, stages, length, fine, pace, series)
        if not size > 0.0:
            length *= 0.25
            shortened = True
            continue
        allowed = tolerance
        if not coefficients.anchored:
            widest = _widest(body, coefficients, method, stages, length, series)
            allowed = min(tolerance, max(_SHARE * widest, _SHARPEST * size))
        error = _error(body, coefficients, valve, method, stages, length, size, series) / allowed
        factor = _SAFETY * math.exp(-power * math.log(max(error, 1e-12)))
        if not error <= 1.0:
            length *= max(_SHORTEN, min(factor, _SAFETY))
            shortened = True
            continue
        _write(method, stages, length, series)
        if pace.begin > 0.0 and pace.error > 0.0 and error > 0.0:
            # The error's own trend, from the last step to this (K. Gustafsson, ACM TOMS 20 (1994) 496).
            trend = length / pace.span * math.exp(power * math.log(pace.error * tolerance / (error * allowed)))
            factor *= min(1.0, trend)
        factor = max(_SHORTEN, min(factor, 1.0 if shortened else _LENGTHEN))
        error *= allowed / tolerance
        # A friction above the tolerance is met by a force that falls through it, whatever its rounding.
        unsure = min(tolerance, _SHARPEST * size) if coefficients.static_friction < tolerance else 0.0
        return length, Pace(length * factor, length, length, error, max(error * tolerance, unsure))
    return np.nan, AFRESH


@inlined
def radau_step(now: Situation, pace: Pace) -> tuple[float, Body, Pace]:
    """One step, and its end; parameters and returns as for `taylor_step`."""
    hold, options, series = now.hold, now.options, now.workspace
    remaining = hold.end - now.elapsed
    length, pace = collocate(
        now.body, now.coefficients, hold.valve, remaining, options.order, options.tolerance, pace, series
    )
    # No cheap bound of the event function is known: it is looked at whole.
    series[STEP, LOWEST] = series[STEP, STEEPEST] = -np.inf
    series[STEP, HIGHEST] = series[STEP, FLATTEST] = np.inf
    series[STEP, FIRST] = 0.0
    pressure = pressure_after(now.opening, now.coefficients, hold.valve, now.elapsed - hold.begin + length)
    return length, state_at(now.body, now.coefficients, pressure, options.order, length, series), pace


@compiled
def refine_event_step(body: Body, coefficients: Coefficients, tolerance: float, pace: Pace, moment: float) -> Pace:
    """How to repeat a step in which an event was found, if it is to be repeated, else AFRESH.

    A step that ends just beyond the event errs less by orders of magnitude. Of a grip or a slip that the error blurs a
    shorter step shows when it ends, and whether it does.

    Parameters
    ----------
    body : Body
        At the step's start.
    coefficients : Coefficients
    tolerance : float
    pace : Pace
        What :func:`collocate` said of the step.
    moment : float
        Of the event, time into the step.

    Returns
    -------
    Pace
    """
    if pace.error > 0.0 and moment > _SHORTEST:
        if moment < _EARLY * pace.span:
            return Pace(_BEYOND * moment, pace.span, 0.0, pace.error, 0.0)
        if _BLUR * _clearance(body, coefficients) < pace.error * tolerance:
            return Pace(0.5 * pace.span, pace.span, 0.0, pace.error, 0.0)
    return AFRESH


@compiled
def _clearance(body: Body, coefficients: Coefficients) -> float:
    """How far a grip is from breaking, in force, or a slip from stopping, in the rate of the body.

    A free foot that slides goes on alike whether it turns round or not.
    """
    if body.mode == STUCK:
        return _grip(coefficients, force(coefficients, body.deformation, body.velocity, body.pressure))
    if is_free(coefficients):
        return np.inf
    return abs(body.foot_velocity) / coefficients.payload_fraction


@compiled
def _grip(coefficients: Coefficients, pull: float) -> float:
    """How far the grip of a resting foot is from breaking under the force `pull`; negative beyond."""
    pull += coefficients.foot_fraction * coefficients.slope
    return coefficients.static_friction + (pull if coefficients.ratchet else -abs(pull))


@compiled
def _widest(
    body: Body, coefficients: Coefficients, method: int, stages: int, length: float, series: NDArray[np.float64]
) -> float:
    """The largest clearance in the step that has been solved."""
    widest = _clearance(body, coefficients)
    for i in range(1, stages + 1):
        if body.mode == STUCK:
            clearance = _grip(coefficients, series[STAGE_F, i])
        else:
            speed = foot_velocity_at(body, coefficients, series[STAGE_V, i], _NODES[method, i] * length)
            clearance = abs(speed) / coefficients.payload_fraction
        widest = max(widest, clearance)
    return widest


@compiled
def _growth_rate(body: Body, coefficients: Coefficients, valve: float) -> float:
    """Rate at which two motions part, where the pressure can make the stiffness negative; at least 0."""
    stiffness = stiffness_at(coefficients, body.deformation, max(body.pressure, valve))
    if stiffness >= 0.0:
        return 0.0
    mobility = mobility_of(coefficients, body.mode)
    damping = mobility * coefficients.damping
    stiffness *= mobility
    # The positive root of x^2 + D x + K, free of cancellation.
    return -2.0 * stiffness / (damping + math.sqrt(damping * damping - 4.0 * stiffness))


@compiled
def _taylor_length(
    body: Body, coefficients: Coefficients, valve: float, stages: int, tolerance: float, series: NDArray[np.float64]
) -> float:
    """Longest step that the Taylor series of degree `stages` may begin with.

    It alone has the exact slopes of force and speed at its start. However faint the motion, the last terms are small
    beside the others, so that the series does not make up an event.
    """
    mobility = mobility_of(coefficients, body.mode)
    pull = series[FORCE]
    length = _LONGEST_START
    for n in range(stages, stages + 2):
        term = mobility * abs(pull[n])
        if term > 0.0:
            length = min(length, math.exp(math.log(tolerance / term) / n))
    for _ in range(_TRIALS):
        moved = 0.0
        power = 1.0
        for n in range(1, stages):
            power *= length
            moved += abs(pull[n]) * power
        lost = (abs(pull[stages]) + abs(pull[stages + 1]) * length) * power * length
        z = horner(series[Z], stages + 1, length)
        v = horner(series[V], stages + 1, length)
        defect = abs(
            force(coefficients, z, v, pressure_after(body, coefficients, valve, length)) - horner(pull, stages, length)
        )
        rounding = ROUNDING * force_terms(coefficients, z, v)
        if lost <= _SETTLED * moved and mobility * (defect - rounding) <= tolerance:
            break
        length *= 0.5
    return length


@compiled
def _first_length(
    body: Body,
    coefficients: Coefficients,
    valve: float,
    method: int,
    stages: int,
    tolerance: float,
    series: NDArray[np.float64],
) -> float:
    """Step at which the first terms that collocation neglects meet the tolerance, by the Taylor series; inf for none.

    A term that the body's fastest mode would have with an amplitude below the tolerance says nothing of the motion:
    that mode may be left to decay unresolved.
    """
    mobility = mobility_of(coefficients, body.mode)
    damping = mobility * coefficients.damping
    # The pressure's part is added, whatever its sign: a bound.
    stiffness = mobility * stiffness_at(coefficients, body.deformation, -max(body.pressure, valve))
    fastest = damping + math.sqrt(stiffness)
    if abs(body.pressure - valve) > tolerance:
        fastest = max(fastest, coefficients.lag_rate)
    slack = tolerance
    for n in range(1, stages - 1):
        slack *= fastest / n
    gap = _DENSE[method] * abs(_MONIC[method, 0])
    length = np.inf
    for n in range(stages - 1, stages + 2):
        slack *= fastest / n
        term = abs(series[FORCE, n])
        if term > slack:
            if n < stages:
                term *= mobility / stages * gap
            elif n == stages:
                term *= mobility / (1.0 + damping) * gap
            else:
                term *= _CHECK_PRODUCT[method]
            length = min(length, math.exp(math.log(tolerance / term) / max(stages, n)))
    return _SAFETY * length


@compiled
def _solve(
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
    return 0.0


@compiled
def _error(
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
def _write(method: int, stages: int, length: float, series: NDArray[np.float64]) -> None:
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
