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

from ...compiling.compilation import compiled
from ...compiling.roots import horner, LARGEST_DEGREE
from ..model.equations import is_free
from ..model.groups import Groups
from ..model.scene import Scene
from ..model.state import Body, Coefficients, coefficients_of, STUCK
from ..model.tube import node_masses
from .workspace import FORCE, P, ROWS, V, WIDTH, Z

__all__ = [
    "Chain",
    "ChainSeries",
    "chain_of",
    "chain_order",
    "expand_chain",
    "foot_at",
    "longest_step",
    "pulls_at",
    "segment_mobility",
    "series_for",
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
_SQUARE, _STIFFNESS, _SEGMENT_ROWS = FORCE + 1, FORCE + 2, FORCE + 3
_RECIPROCAL = np.array([0.0] + [1.0 / n for n in range(1, WIDTH + 1)])


class Chain(NamedTuple):
    """Coefficients of one chain's equations of motion."""

    coefficients: Coefficients  # of a segment in D, with the masses at the two ends for those of foot and payload
    mobility: NDArray[np.float64]  # 1 / m_j of the nodes, from foot to payload


class ChainSeries(NamedTuple):
    """Workspace: Taylor coefficients of all segments, segment index fastest, and of what touches the ground."""

    segments: NDArray[np.float64]  # (_SEGMENT_ROWS, WIDTH, N): D, D', F, D^2 and -(secant stiffness)
    rear: NDArray[np.float64]  # (ROWS, WIDTH): the segment behind, as the crawler's; its p is every segment's
    foot_velocity: NDArray[np.float64]  # (WIDTH,)
    ahead: NDArray[np.float64]  # (2, N): D and D' at some instant of the step
    pulls: NDArray[np.float64]  # (N,): F as its series has it there
    acceleration: NDArray[np.float64]  # (N + 1,): of the nodes, one order at a time


def chain_of(groups: Groups, scene: Scene) -> Chain:
    """Coefficients of the chain's equations of motion, from `groups` and `scene`."""
    masses = node_masses(groups, scene)
    ends = coefficients_of(groups, scene)._replace(foot_fraction=float(masses[0]), payload_fraction=float(masses[-1]))
    return Chain(ends, 1.0 / masses)


def chain_order(order: int) -> int:
    """The order, at or above that which would be cheapest for a crawler, that suits the oscillations of a chain."""
    return next((better for better in _ORDERS if better >= order), _ORDERS[-1])


def series_for(segments: int) -> ChainSeries:
    """Workspace for a chain of so many segments."""
    return ChainSeries(
        np.empty((_SEGMENT_ROWS, WIDTH, segments)),
        np.empty((ROWS, WIDTH)),
        np.empty(WIDTH),
        np.empty((2, segments)),
        np.empty(segments),
        np.empty(segments + 1),
    )


@compiled
def expand_chain(
    stretches: NDArray[np.float64], body: Body, chain: Chain, valve: float, order: int, series: ChainSeries
) -> None:
    """Fill `series` with Taylor coefficients about the present instant.

    Parameters
    ----------
    stretches : (2, N) array
        D and D'.
    body : Body
        Of which pressure, foot velocity and motion count.
    chain : Chain
    valve : float
        The valve while the series holds, 0 or 1.
    order : int
        Last coefficient of the forces; D, D' and the foot's velocity get one more.
    series : ChainSeries
        Written in place.
    """
    segments = stretches.shape[1]
    duffing, damping = chain.coefficients.duffing, chain.coefficients.damping
    z, v = series.segments[Z], series.segments[V]
    square, force, stiffness = series.segments[_SQUARE], series.segments[FORCE], series.segments[_STIFFNESS]
    pressure = series.rear[P]

    term = body.pressure - valve
    pressure[0] = body.pressure
    for n in range(1, order + 1):
        term *= -chain.coefficients.lag_rate * _RECIPROCAL[n]
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
        softening = chain.coefficients.radial_coupling * pressure[n] - (1.0 if n == 0 else 0.0)
        for j in range(segments):
            stiffness[n, j] = softening - duffing * square[n, j]
            force[n, j] = pressure[n] - damping * v[n, j]
        for i in range(n + 1):
            for j in range(segments):
                force[n, j] += stiffness[i, j] * z[n - i, j]
        _accelerate(force[n], body.mode, chain, n == 0, series.acceleration)
        series.foot_velocity[n + 1] = series.acceleration[0] * _RECIPROCAL[n + 1]
        scale = segments * _RECIPROCAL[n + 1]
        for j in range(segments):
            v[n + 1, j] = scale * (series.acceleration[j + 1] - series.acceleration[j])
            z[n + 1, j] = v[n, j] * _RECIPROCAL[n + 1]

    for n in range(order + 2):
        series.rear[Z, n] = z[n, 0]
        series.rear[V, n] = v[n, 0]
    for n in range(order + 1):
        series.rear[FORCE, n] = force[n, 0]


@compiled
def _accelerate(
    force: NDArray[np.float64], mode: int, chain: Chain, leading: bool, acceleration: NDArray[np.float64]
) -> None:
    """One order of the nodes' accelerations from that of the forces; weight and drag are constant, of order 0."""
    segments = len(force)
    weight = chain.coefficients.slope if leading else 0.0
    for j in range(1, segments):
        acceleration[j] = (force[j - 1] - force[j]) * chain.mobility[j] - weight
    acceleration[segments] = force[segments - 1] * chain.mobility[segments] - weight
    acceleration[0] = 0.0
    if mode != STUCK:
        drag = mode * chain.coefficients.kinetic_friction if leading else 0.0
        acceleration[0] = -(force[0] + drag) * chain.mobility[0] - weight


@compiled
def segment_mobility(chain: Chain, mode: int, j: int) -> float:
    """Rate D_j'' per force of segment j alone, from N at its rear and front ends."""
    segments = len(chain.mobility) - 1
    rear = 0.0 if j == 0 and mode == STUCK else chain.mobility[j]
    return segments * (rear + chain.mobility[j + 1])


@compiled
def longest_step(chain: Chain, mode: int, order: int, tolerance: float, series: ChainSeries) -> float:
    """Longest step on which the last two terms of every D'' stay below `tolerance`, and no faint motion grows.

    A uniform stretch is then followed as well as the crawler's, and every force to the same accuracy.
    """
    segments = len(chain.mobility) - 1
    mobility = 0.0
    for j in range(segments):
        mobility = max(mobility, segment_mobility(chain, mode, j))
    # Gershgorin: D'' + B (2 Pi2 D' + D) = 0 with no eigenvalue of B beyond twice its diagonal. Those beyond 1 / Pi2^2
    # are overdamped.
    stiffest = 2.0 * mobility
    fastest = math.sqrt(stiffest)
    length = _STABLE_SWING[order] / fastest
    resistance = 0.5 * chain.coefficients.damping * stiffest
    if resistance > fastest:
        decay = resistance + math.sqrt(resistance * resistance - stiffest)
        length = min(_STABLE_SWING[order] * 0.5 * chain.coefficients.damping, _STABLE_DECAY[order] / decay)
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
def stretches_at(order: int, t: float, series: ChainSeries) -> None:
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
def pulls_at(order: int, t: float, series: ChainSeries) -> None:
    """Write the forces that their own series give a time `t` into the step to `series.pulls`."""
    segments = len(series.pulls)
    for j in range(segments):
        series.pulls[j] = series.segments[FORCE, order, j]
    for n in range(order - 1, -1, -1):
        for j in range(segments):
            series.pulls[j] = series.pulls[j] * t + series.segments[FORCE, n, j]


@compiled
def foot_at(body: Body, coefficients: Coefficients, order: int, t: float, series: ChainSeries) -> tuple[float, float]:
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
