"""Taylor series of the chain: N segments between payload and foot, each with a part of the tube's mass.

Segment i is stretched by d_i and pushes its ends apart with

    F_i = p (1 + N Pi5 d_i) - N d_i - N^3 Pi1 d_i^3 - 2 N Pi2 d_i',

which in the stretch D_i = N d_i that the whole body would have is the crawler's own force: the kernels know D only,
and z is its mean. Node j, from the foot 0 to the payload N, has mass m_j and obeys m_j u_j' = F_j - F_{j+1} less its
weight; friction acts on the foot alone. D_i' = N (u_i - u_{i-1}), so the right-hand side is as polynomial as the
crawler's and has the same recurrence.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, inlined
from ...compiling.roots import horner, LARGEST_DEGREE
from ..model.equations import force, force_terms, is_free, pressure_after
from ..model.groups import Groups
from ..model.scene import Scene
from ..model.state import Body, Coefficients, coefficients_of, STUCK
from ..model.tube import node_masses
from .options import AFRESH, Options, Pace, Situation
from .taylor import ROUNDING, SHORTENINGS, TRUST
from .workspace import FORCE, P, ROWS, V, WIDTH, Z

__all__ = [
    "SQUARE",
    "ChainWorkspace",
    "accelerate_nodes",
    "chain_coefficients",
    "chain_order",
    "chain_step",
    "chain_workspace",
    "foot_at",
    "segment_mobility",
    "stretches_at",
]

# Growth in a step that takes a million steps to matter.
_GROWTH = 1e-6


def _stable_reach(order: int, direction: complex) -> float:
    """Longest step, in units of 1 / rate, whose Taylor polynomial does not amplify exp(direction * rate * t)."""
    reach = np.linspace(0.0, order + 1.0, 100 * (order + 1) + 1)
    terms = [1.0 / math.factorial(n) for n in range(order + 1, -1, -1)]
    growth = np.abs(np.polyval(terms, direction * reach))
    return float(reach[np.argmax(growth > 1.0 + _GROWTH) - 1])


# By order. A motion fainter than the tolerance is unseen by the step's error bound, and beyond would grow up to it.
_STABLE_SWING = np.array([0.0] + [_stable_reach(order, 1j) for order in range(1, LARGEST_DEGREE + 1)])
_STABLE_DECAY = np.array([0.0] + [_stable_reach(order, -1.0) for order in range(1, LARGEST_DEGREE + 1)])
# Orders that follow an oscillation for twice to four times as long a step as most of their neighbours.
_ORDERS = (7, 12, 17, 22)
# Rows of the segments' series besides those that the crawler's workspace names.
SQUARE, _STIFFNESS, _SEGMENT_ROWS = FORCE + 1, FORCE + 2, FORCE + 3
_RECIPROCAL = np.array([0.0] + [1.0 / n for n in range(1, WIDTH + 1)])


class ChainWorkspace(NamedTuple):
    """What the steps of a chain work on; of all segments Taylor coefficients with the segment's index fastest."""

    mobility: NDArray[np.float64]  # (N + 1,): 1 / m_j of the nodes, from foot to payload
    stretches: NDArray[np.float64]  # (2, N): D and D' of the segments at the start of the step, foot first
    segments: NDArray[np.float64]  # (_SEGMENT_ROWS, WIDTH, N): D, D', F, D^2 and -(secant stiffness)
    rear: NDArray[np.float64]  # (ROWS, WIDTH): the segment behind, as the crawler's; its p is every segment's
    foot_velocity: NDArray[np.float64]  # (WIDTH,)
    ahead: NDArray[np.float64]  # (2, N): D and D' at some instant of the step
    pulls: NDArray[np.float64]  # (N,): F as its series has it there
    acceleration: NDArray[np.float64]  # (N + 1,): of the nodes, one order at a time
    tangents: NDArray[np.float64]  # (2, 2 N + 1): changes of D, of D' and of the momentum, two vectors of them
    changes: NDArray[np.float64]  # (3, WIDTH, N): series of the two parts of one, and of the slope of the force
    growth: NDArray[np.float64]  # (4,): logarithms of the vectors, the integral of the divergence, and the stops


def chain_coefficients(groups: Groups, scene: Scene) -> Coefficients:
    """Coefficients of a segment in D, with the masses at the two ends of the chain for those of foot and payload."""
    masses = node_masses(groups, scene)
    return coefficients_of(groups, scene)._replace(foot_fraction=float(masses[0]), payload_fraction=float(masses[-1]))


def chain_order(order: int) -> int:
    """The order, at or above that which would be cheapest for a crawler, that suits the oscillations of a chain."""
    return next((better for better in _ORDERS if better >= order), _ORDERS[-1])


def chain_workspace(groups: Groups, scene: Scene, stretches: NDArray[np.float64]) -> ChainWorkspace:
    """Workspace for a chain that begins with those stretches."""
    segments = scene.segments
    return ChainWorkspace(
        1.0 / node_masses(groups, scene),
        stretches.copy(),
        np.empty((_SEGMENT_ROWS, WIDTH, segments)),
        np.empty((ROWS, WIDTH)),
        np.empty(WIDTH),
        np.empty((2, segments)),
        np.empty(segments),
        np.empty(segments + 1),
        np.zeros((2, 2 * segments + 1)),
        np.empty((3, WIDTH, segments)),
        np.zeros(4),
    )


@inlined
def chain_step(now: Situation, _pace: Pace) -> tuple[float, Body, Pace]:
    """The longest step that the series of all segments allow; parameters and returns as for `taylor_step`.

    The state at its end is left to be found once an event has not ended it earlier: the body is that of its start.
    """
    body, coefficients, options = now.body, now.coefficients, now.options
    expand_chain(body, coefficients, now.hold.valve, options.order, now.workspace)
    length = longest_step(coefficients, body.mode, options.order, options.tolerance, now.workspace)
    if not length > 0.0:
        return np.nan, body, AFRESH
    length = min(length, now.hold.end - now.elapsed)
    return _trusted_length(body, coefficients, now.hold.valve, options, length, now.workspace), body, AFRESH


@compiled
def expand_chain(body: Body, coefficients: Coefficients, valve: float, order: int, series: ChainWorkspace) -> None:
    """Fill `series` with Taylor coefficients about the present instant.

    Parameters
    ----------
    body : Body
        Of which pressure, foot velocity and motion count; the segments' stretches are the workspace's.
    coefficients : Coefficients
    valve : float
        The valve while the series holds, 0 or 1.
    order : int
        Last coefficient of the forces; D, D' and the foot's velocity get one more.
    series : ChainWorkspace
        Written in place.
    """
    stretches = series.stretches
    segments = stretches.shape[1]
    duffing, damping = coefficients.duffing, coefficients.damping
    z, v = series.segments[Z], series.segments[V]
    square, pull, stiffness = series.segments[SQUARE], series.segments[FORCE], series.segments[_STIFFNESS]
    pressure = series.rear[P]

    term = body.pressure - valve
    pressure[0] = body.pressure
    for n in range(1, order + 1):
        term *= -coefficients.lag_rate * _RECIPROCAL[n]
        pressure[n] = term

    for j in range(segments):
        z[0, j] = stretches[0, j]
        v[0, j] = stretches[1, j]
    series.foot_velocity[0] = body.foot_velocity
    for n in range(order + 1):
        for j in range(segments):
            square[n, j] = 0.0
        for i in range((n + 1) // 2):
            for j in range(segments):
                square[n, j] += z[i, j] * z[n - i, j]
        for j in range(segments):
            square[n, j] *= 2.0
        if n % 2 == 0:
            for j in range(segments):
                square[n, j] += z[n // 2, j] * z[n // 2, j]
        softening = coefficients.radial_coupling * pressure[n] - (1.0 if n == 0 else 0.0)
        for j in range(segments):
            stiffness[n, j] = softening - duffing * square[n, j]
            pull[n, j] = pressure[n] - damping * v[n, j]
        for i in range(n + 1):
            for j in range(segments):
                pull[n, j] += stiffness[i, j] * z[n - i, j]
        accelerate_nodes(pull[n], body.mode, coefficients, n == 0, series)
        series.foot_velocity[n + 1] = series.acceleration[0] * _RECIPROCAL[n + 1]
        scale = segments * _RECIPROCAL[n + 1]
        for j in range(segments):
            v[n + 1, j] = scale * (series.acceleration[j + 1] - series.acceleration[j])
            z[n + 1, j] = v[n, j] * _RECIPROCAL[n + 1]

    for n in range(order + 2):
        series.rear[Z, n] = z[n, 0]
        series.rear[V, n] = v[n, 0]
    for n in range(order + 1):
        series.rear[FORCE, n] = pull[n, 0]


@compiled
def accelerate_nodes(
    force: NDArray[np.float64], mode: int, coefficients: Coefficients, leading: bool, series: ChainWorkspace
) -> None:
    """One order of the nodes' accelerations from that of the forces; weight and drag are constant, of order 0."""
    acceleration, mobility = series.acceleration, series.mobility
    segments = len(force)
    weight = coefficients.slope if leading else 0.0
    for j in range(1, segments):
        acceleration[j] = (force[j - 1] - force[j]) * mobility[j] - weight
    acceleration[segments] = force[segments - 1] * mobility[segments] - weight
    acceleration[0] = 0.0
    if mode != STUCK:
        drag = mode * coefficients.kinetic_friction if leading else 0.0
        acceleration[0] = -(force[0] + drag) * mobility[0] - weight


@compiled
def segment_mobility(mode: int, j: int, series: ChainWorkspace) -> float:
    """Rate D_j'' per force of segment j alone, from N at its rear and front ends."""
    mobility = series.mobility
    segments = len(mobility) - 1
    rear = 0.0 if j == 0 and mode == STUCK else mobility[j]
    return segments * (rear + mobility[j + 1])


@compiled
def longest_step(coefficients: Coefficients, mode: int, order: int, tolerance: float, series: ChainWorkspace) -> float:
    """Longest step on which the last two terms of every D'' stay below `tolerance`, and no faint motion grows.

    A uniform stretch is then followed as well as the crawler's, and every force to the same accuracy.
    """
    segments = len(series.mobility) - 1
    mobility = 0.0
    for j in range(segments):
        mobility = max(mobility, segment_mobility(mode, j, series))
    # Gershgorin: D'' + B (2 Pi2 D' + D) = 0 with no eigenvalue of B beyond twice its diagonal. Those beyond 1 / Pi2^2
    # are overdamped.
    stiffest = 2.0 * mobility
    fastest = math.sqrt(stiffest)
    length = _STABLE_SWING[order] / fastest
    resistance = 0.5 * coefficients.damping * stiffest
    if resistance > fastest:
        decay = resistance + math.sqrt(resistance * resistance - stiffest)
        length = min(_STABLE_SWING[order] * 0.5 * coefficients.damping, _STABLE_DECAY[order] / decay)
    for n in range(order - 1, order + 1):
        last = 0.0
        for j in range(segments):
            size = abs(series.segments[V, n + 1, j])
            if size > last:
                last = size
        last *= n + 1
        if last > 0.0:
            length = min(length, math.exp(math.log(tolerance / last) / n))
    return length


@compiled
def _trusted_length(
    body: Body, coefficients: Coefficients, valve: float, options: Options, length: float, series: ChainWorkspace
) -> float:
    """The part of a step at whose end every segment's series still satisfies the equation of motion.

    As in `taylor_step`: the defect is the force at the state less the force's own series.
    """
    order = options.order
    for _ in range(SHORTENINGS):
        stretches_at(order, length, series)
        pulls_at(order, length, series)
        pressure = pressure_after(body, coefficients, valve, length)
        worst = 0.0
        for j in range(series.ahead.shape[1]):
            z = series.ahead[0, j]
            v = series.ahead[1, j]
            defect = abs(force(coefficients, z, v, pressure) - series.pulls[j])
            rounding = ROUNDING * force_terms(coefficients, z, v)
            mobility = segment_mobility(body.mode, j, series)
            if mobility * (defect - rounding) > TRUST * options.tolerance:
                worst = max(worst, mobility * defect)
        if worst == 0.0:
            break
        shrink = math.exp(math.log(options.tolerance / worst) / (order + 1))
        length *= max(0.25, min(0.9, shrink))
    return length


@compiled
def stretches_at(order: int, t: float, series: ChainWorkspace) -> None:
    """Write D and D' a time `t` into the step to `series.ahead`."""
    segments = series.ahead.shape[1]
    for row in (Z, V):
        value = series.ahead[row]
        for j in range(segments):
            value[j] = series.segments[row, order + 1, j]
        for n in range(order, -1, -1):
            for j in range(segments):
                value[j] = value[j] * t + series.segments[row, n, j]


@compiled
def pulls_at(order: int, t: float, series: ChainWorkspace) -> None:
    """Write the forces that their own series give a time `t` into the step to `series.pulls`."""
    segments = len(series.pulls)
    for j in range(segments):
        series.pulls[j] = series.segments[FORCE, order, j]
    for n in range(order - 1, -1, -1):
        for j in range(segments):
            series.pulls[j] = series.pulls[j] * t + series.segments[FORCE, n, j]


@compiled
def foot_at(
    body: Body, coefficients: Coefficients, order: int, t: float, series: ChainWorkspace
) -> tuple[float, float]:
    """Position and velocity of the foot a time `t` into the step, by its own equation of motion.

    Coefficient by coefficient that is what the total momentum has left after the segments' share, without the
    cancellation of a sum over all of them.
    """
    if body.mode == STUCK:
        return body.foot, 0.0
    way = 0.0
    for n in range(order, -1, -1):
        way = way * t + series.foot_velocity[n] * _RECIPROCAL[n + 1]
    velocity = horner(series.foot_velocity, order + 1, t)
    # At a stop rounding can leave it a hair beyond zero. A free foot may have begun to turn round.
    if body.mode * velocity < 0.0 and not is_free(coefficients):
        velocity = 0.0
    return body.foot + way * t, velocity
