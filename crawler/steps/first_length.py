"""How long the first step of a motion may be, by the Taylor series at its start."""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ...compiling.roots import horner
from ..model.equations import force, force_terms, mobility_of, pressure_after, stiffness_at
from ..model.state import Body, Coefficients
from .radau_table import TABLES
from .taylor import ROUNDING
from .workspace import FORCE, V, Z

__all__ = ["first_length", "taylor_length"]

_DENSE, _MONIC, _CHECK_PRODUCT = TABLES.dense, TABLES.monic, TABLES.check_product

# So many halvings take any step below the least float.
_TRIALS = 500
_SAFETY = 0.9
_LONGEST_START = 1.0
_SETTLED = 0.01


@compiled
def taylor_length(
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
def first_length(
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
