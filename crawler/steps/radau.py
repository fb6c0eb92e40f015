"""Radau IIA collocation of the crawler's smooth motion, for scenes too stiff for a Taylor series.

A step is polynomials again, now those that satisfy v' = F / mass and z' = v at the nodes, so that all that follows a
step, its events above all, is that of `stickslip.crawler.steps.taylor`. The method is L-stable: its step is as long
as the motion is smooth, however fast the body would return to that motion if it were disturbed (E. Hairer and G.
Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.8; J. Comput. Appl. Math. 111 (1999) 93).
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, inlined
from ..model.equations import mobility_of, pressure_after, stiffness_at
from ..model.state import Body, Coefficients, STUCK
from .clearance import clearance, widest_clearance
from .collocation import error_of, solve, write_polynomials
from .first_length import first_length, taylor_length
from .options import AFRESH, Pace, Situation, Taylor12
from .radau_table import STAGES
from .taylor import expand, state_at
from .workspace import FIRST, FLATTEST, HIGHEST, LOWEST, STEEPEST, STEP

__all__ = ["collocate", "radau_step", "refine_event_step", "stages_for"]

# Tolerances down to which each method is the cheapest.
_FINEST = (3e-5, 2e-8, 2e-11, 0.0)
# So many trials take any step below the least float.
_TRIALS = 500
_SAFETY = 0.9
_SHORTEN, _LENGTHEN = 0.1, 10.0
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
        short = taylor_length(body, coefficients, valve, stages, tolerance, series)
        # The first instants of a slip, or of a grip on its threshold, decide which motion this is.
        nearness = _NEAR * tolerance if body.mode == STUCK else 0.0
        undecided = not coefficients.anchored and clearance(body, coefficients) <= nearness
        if undecided or remaining <= short:
            short = min(short, remaining)
            return short, Pace(_LENGTHEN * short, short, short, 0.0, 0.0)
        length = first_length(body, coefficients, valve, method, stages, tolerance, series)
    fine = tolerance
    if not coefficients.anchored:
        fine = min(tolerance, max(_SHARE * clearance(body, coefficients), _SHARPEST))
    length = min(length, longest)
    power = 1.0 / (stages + 1.0)
    shortened = False
    for _ in range(_TRIALS):
        # Two equal steps to the end rather than a long one and a stump.
        if 0.5 * remaining < length < remaining and pace.begin == pace.span:
            length = 0.5 * remaining
        size = solve(body, coefficients, valve, method, stages, length, fine, pace, series)
        if not size > 0.0:
            length *= 0.25
            shortened = True
            continue
        allowed = tolerance
        if not coefficients.anchored:
            widest = widest_clearance(body, coefficients, method, stages, length, series)
            allowed = min(tolerance, max(_SHARE * widest, _SHARPEST * size))
        error = error_of(body, coefficients, valve, method, stages, length, size, series) / allowed
        factor = _SAFETY * math.exp(-power * math.log(max(error, 1e-12)))
        if not error <= 1.0:
            length *= max(_SHORTEN, min(factor, _SAFETY))
            shortened = True
            continue
        write_polynomials(method, stages, length, series)
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
        if _BLUR * clearance(body, coefficients) < pace.error * tolerance:
            return Pace(0.5 * pace.span, pace.span, 0.0, pace.error, 0.0)
    return AFRESH


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
