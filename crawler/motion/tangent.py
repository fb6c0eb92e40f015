"""How a small change of the start moves the motion: tangent vectors, carried along the run.

Between events a change (dz, dv) of the body obeys the linearised equations

    dz' = dv,  dv' = -K(t) dz - D dv,  K = (1 + 3 Pi1 z^2 - Pi5 p) / m,  D = 2 Pi2 / m,

whose solution over a part of a step is the exponential of Magnus's expansion, of sixth order on three Gauss nodes
(S. Blanes, F. Casas, J. A. Oteo and J. Ros, Physics Reports 470 (2009) 151, section 5.4). It is exact where K is
constant, shrinks the volume of phases as the damping does, and stays bounded however stiff the body. The foot follows
from the momentum. Across an event a change is carried by the saltation matrix (R. I. Leine and H. Nijmeijer, Dynamics
and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004, chapter 7): the change moves the event by
dt = -dg / g', g the event function, and for that time the one motion takes the place of the other.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ...compiling.roots import horner
from ..model.equations import acceleration_at_no_force, force, force_gradient, mobility_of, retardation, stiffness_at
from ..model.state import Body, Coefficients, STUCK
from ..steps.propagator import Propagator
from ..steps.workspace import CHANGES, P, Z

__all__ = ["carry", "carry_linear", "condition_of", "saltate", "start_changes"]

# Rows of the tangents: changes of z, v, x and w at this instant; a column each for a change of z, v and w at the start.
_DZ, _DV, _DX, _DW = range(CHANGES)
_COLUMNS = 3
# Distance of the outer Gauss nodes of three in [0, 1] from the middle one.
_APART = math.sqrt(15.0) / 10.0
# Radians of the body's oscillation in one exponential, and most of these in a step.
_RADIANS, _PIECES = 0.4, 32.0


def start_changes(workspace: NDArray[np.float64], mode: int) -> None:
    """Write the tangents at the start of a run: a foot at rest has no velocity to be changed."""
    changes = workspace[-CHANGES:]
    changes[:] = 0.0
    changes[_DZ, 0] = changes[_DV, 1] = 1.0
    changes[_DW, 2] = float(mode != STUCK)


def condition_of(workspace: NDArray[np.float64], unit: float) -> float:
    """Largest singular value of the tangents, whose time is in units of `unit`; inf beyond the range of floats."""
    changes = workspace[-CHANGES:, :_COLUMNS].copy()
    changes[[_DV, _DW]] /= unit
    changes[:, 1:] *= unit
    return float(np.linalg.norm(changes, 2)) if np.isfinite(changes).all() else math.inf


@compiled
def carry(body: Body, coefficients: Coefficients, order: int, length: float, series: NDArray[np.float64]) -> None:
    """Carry the tangents over a step.

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
        The step's workspace; its tangents are moved in place.
    """
    mobility = mobility_of(coefficients, body.mode)
    damping = mobility * coefficients.damping
    stiffest = 0.0
    for i in range(3):
        stiffest = max(stiffest, abs(_stiffness(coefficients, mobility, order, 0.5 * i * length, series)))
    pieces = math.ceil(max(1.0, min(_PIECES, length * math.sqrt(stiffest) / _RADIANS)))
    span = length / pieces
    z_z, z_v, v_z, v_v = 1.0, 0.0, 0.0, 1.0
    for i in range(int(pieces)):
        first = _stiffness(coefficients, mobility, order, (i + 0.5 - _APART) * span, series)
        second = _stiffness(coefficients, mobility, order, (i + 0.5) * span, series)
        third = _stiffness(coefficients, mobility, order, (i + 0.5 + _APART) * span, series)
        a, b, c, d = _exponential(first, second, third, damping, span)
        z_z, v_z = a * z_z + b * v_z, c * z_z + d * v_z
        z_v, v_v = a * z_v + b * v_v, c * z_v + d * v_v
    _carry_by(z_z, z_v, v_z, v_v, body.mode, coefficients, length, series)


@compiled
def carry_linear(
    body: Body, coefficients: Coefficients, over: Propagator, length: float, workspace: NDArray[np.float64]
) -> None:
    """Carry the tangents of a linear body by its propagator over the time `length`."""
    _carry_by(over.z_z, over.z_v, over.v_z, over.v_v, body.mode, coefficients, length, workspace)


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


@compiled
def _carry_by(
    z_z: float,
    z_v: float,
    v_z: float,
    v_v: float,
    mode: int,
    coefficients: Coefficients,
    length: float,
    workspace: NDArray[np.float64],
) -> None:
    tangents = workspace[workspace.shape[0] - CHANGES :]
    payload = coefficients.payload_fraction
    for i in range(_COLUMNS):
        z, v = tangents[_DZ, i], tangents[_DV, i]
        moved_z = z_z * z + z_v * v
        moved_v = v_z * z + v_v * v
        tangents[_DZ, i], tangents[_DV, i] = moved_z, moved_v
        if mode != STUCK:
            w = tangents[_DW, i]
            tangents[_DX, i] += (w + payload * v) * length - payload * (moved_z - z)
            tangents[_DW, i] = w + payload * (v - moved_v)


@compiled
def saltate(
    body: Body, mode: int, coefficients: Coefficients, valve: float, time: float, workspace: NDArray[np.float64]
) -> None:
    """Carry the tangents across an event.

    Parameters
    ----------
    body : Body
        Just before the event, in the motion that ends.
    motion : int
        That begins.
    coefficients : Coefficients
    valve : float
    time : float
        Of the event in the run. One at the very start does not move.
    workspace : array
        Whose last rows are the tangents; moved in place.
    """
    tangents = workspace[workspace.shape[0] - CHANGES :]
    z, v, p = body.deformation, body.velocity, body.pressure
    pull = force(coefficients, z, v, p)
    before, after = _acceleration(coefficients, body.mode, pull), _acceleration(coefficients, mode, pull)
    foot_before, foot_after = (
        _foot_acceleration(coefficients, body.mode, pull),
        _foot_acceleration(coefficients, mode, pull),
    )
    by_z, by_v, by_p = force_gradient(coefficients, z, p)
    pull_rate = by_z * v + by_v * before + by_p * (coefficients.lag_rate * (valve - p))
    # How fast the event function falls: of a grip s plus or less F, of a slip its speed.
    falling = -mode * pull_rate if body.mode == STUCK else -body.mode * foot_before
    for i in range(_COLUMNS):
        rise = body.mode * tangents[_DW, i]
        if body.mode == STUCK:
            rise = mode * (by_z * tangents[_DZ, i] + by_v * tangents[_DV, i])
        later = rise / falling if falling > 0.0 and time > 0.0 else 0.0
        tangents[_DV, i] += (before - after) * later
        tangents[_DW, i] = tangents[_DW, i] + (foot_before - foot_after) * later if mode != STUCK else 0.0


@compiled
def _acceleration(coefficients: Coefficients, mode: int, pull: float) -> float:
    return mobility_of(coefficients, mode) * pull + acceleration_at_no_force(coefficients, mode)


@compiled
def _foot_acceleration(coefficients: Coefficients, mode: int, pull: float) -> float:
    if mode == STUCK:
        return 0.0
    return -coefficients.payload_fraction * _acceleration(coefficients, mode, pull) - retardation(coefficients, mode)
