"""How a small change of z and v goes through a step, whatever has made the step.

A change (dz, dv) of the body obeys the linearised equations

    dz' = dv,  dv' = -K(t) dz - D dv,  K = (1 + 3 Pi1 z^2 - Pi5 p) / m,  D = 2 Pi2 / m,

whose solution over a part of a step is the exponential of Magnus's expansion, of sixth order on three Gauss nodes
(S. Blanes, F. Casas, J. A. Oteo and J. Ros, Physics Reports 470 (2009) 151, section 5.4). It is exact where K is
constant, shrinks the volume of phases as the damping does, and stays bounded however stiff the body.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ...compiling.roots import horner
from ..model.equations import mobility_of, stiffness_at
from ..model.state import Body, Coefficients
from ..steps.workspace import P, Z

__all__ = ["Transition", "transition"]

# Distance of the outer Gauss nodes of three in [0, 1] from the middle one.
_APART = math.sqrt(15.0) / 10.0
# Radians of the body's oscillation in one exponential, where K varies as much as it is large and where it does not, and
# most of these in a step. They keep the error near 1e-8 a unit of time.
_RADIANS, _STEADY, _PIECES = 0.1, 0.4, 128.0


class Transition(NamedTuple):
    """Change of (z, v) at the end of a step for each unit of one at its start."""

    z_z: float
    z_v: float
    v_z: float
    v_v: float


@compiled
def transition(
    body: Body, coefficients: Coefficients, order: int, length: float, series: NDArray[np.float64]
) -> Transition:
    """The transition over a step whose motion is polynomials.

    Parameters
    ----------
    body : Body
        At the step's start.
    coefficients : Coefficients
    order : int
        Degree of the pressure's polynomial; that of z is one more.
    length : float
        Of the step, up to its event.
    series : array
        The step's workspace.

    Returns
    -------
    Transition
    """
    mobility = mobility_of(coefficients, body.mode)
    damping = mobility * coefficients.damping
    start, middle, end = (
        _stiffness(coefficients, mobility, order, 0.0, series),
        _stiffness(coefficients, mobility, order, 0.5 * length, series),
        _stiffness(coefficients, mobility, order, length, series),
    )
    stiffest = max(abs(start), abs(middle), abs(end))
    varies = max(start, middle, end) - min(start, middle, end)
    # The error is as the variation and the sixth power of the piece.
    radians = _STEADY
    if varies > 2.5e-4 * stiffest:
        radians = _RADIANS * math.exp(math.log(stiffest / varies) / 6.0)
    pieces = math.ceil(max(1.0, min(_PIECES, length * math.sqrt(stiffest) / radians)))
    span = length / pieces
    z_z, z_v, v_z, v_v = 1.0, 0.0, 0.0, 1.0
    for i in range(int(pieces)):
        first = _stiffness(coefficients, mobility, order, (i + 0.5 - _APART) * span, series)
        second = _stiffness(coefficients, mobility, order, (i + 0.5) * span, series)
        third = _stiffness(coefficients, mobility, order, (i + 0.5 + _APART) * span, series)
        a, b, c, d = _exponential(first, second, third, damping, span)
        z_z, v_z = a * z_z + b * v_z, c * z_z + d * v_z
        z_v, v_v = a * z_v + b * v_v, c * z_v + d * v_v
    return Transition(z_z, z_v, v_z, v_v)


@compiled
def _stiffness(coefficients: Coefficients, mobility: float, order: int, t: float, series: NDArray[np.float64]) -> float:
    z = horner(series[Z], order + 1, t)
    return mobility * stiffness_at(coefficients, z, horner(series[P], order, t))


@compiled
def _exponential(
    first: float, second: float, third: float, damping: float, span: float
) -> tuple[float, float, float, float]:
    """Entries of exp(W), W of sixth order by K at three Gauss nodes.

    But for its trace every matrix here is (a, b; c, -a), and damping and commutators act on a, b and c.
    """
    half = 0.5 * damping * span
    mean = (5.0 * first + 8.0 * second + 5.0 * third) / 18.0
    a, b, c = half, span, -span * mean
    if half < 1.0 and abs(mean) * span * span < 1.0:
        slope = -math.sqrt(15.0) / 3.0 * span * (third - first)
        bend = -10.0 / 3.0 * span * (third - 2.0 * second + first)
        c = -span * second
        # One commutator, of (half, span, c) and (0, 0, slope), and then another with that.
        turn_a, turn_c = span * slope, -2.0 * half * slope
        back_a, back_b, back_c = _commutator(half, span, c, turn_a, 0.0, 2.0 * bend + turn_c)
        left_a, left_b, left_c = turn_a - 20.0 * half, -20.0 * span, turn_c - 20.0 * c - bend
        a, b, c_more = _commutator(left_a, left_b, left_c, -back_a / 60.0, -back_b / 60.0, slope - back_c / 60.0)
        a, b, c = half + a / 240.0, span + b / 240.0, c + bend / 12.0 + c_more / 240.0
    # The square of a matrix without trace is a number.
    square = a * a + b * c
    if square < 0.0:
        root = math.sqrt(-square)
        envelope = math.exp(-half)
        even, odd = envelope * math.cos(root), envelope * math.sin(root) / root
    else:
        root = math.sqrt(square)
        # Free of the cancellation of root and half in a stiff body.
        slow = math.exp(((a - half) * (a + half) + b * c) / (root + half) if root + half > 0.0 else 0.0)
        fast = math.exp(-half - root)
        even = 0.5 * (slow + fast)
        odd = 0.5 * (slow - fast) / root if root > 1e-4 else math.exp(-half)
    return even + odd * a, odd * b, odd * c, even - odd * a


@compiled
def _commutator(
    a: float, b: float, c: float, other_a: float, other_b: float, other_c: float
) -> tuple[float, float, float]:
    return b * other_c - other_b * c, 2.0 * (a * other_b - b * other_a), 2.0 * (c * other_a - a * other_c)
