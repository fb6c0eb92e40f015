"""How fast small changes of a chain grow: two vectors of the stretches and their rates, carried along the run.

Over a step each vector is a Taylor series, by the recurrence of the motion linearised about it; the foot follows from
the momentum, which stays while it slides. After every step and event the second is made orthogonal to the first, and
both are measured and made unit vectors (G. Benettin et al., Meccanica 15 (1980) 9).
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ..model.equations import force, force_gradient
from ..model.state import Body, Coefficients, STUCK
from ..steps.chain_series import accelerate_nodes, ChainWorkspace, segment_mobility, SQUARE
from ..steps.workspace import P
from .lyapunov import GROWTH_ROWS

__all__ = ["carry_chain", "note_chain", "saltate_chain", "start_chain_growth"]

_VECTORS = 2
_DIVERGENCE, _STOPS = range(_VECTORS, GROWTH_ROWS)
_Z, _V, _SLOPE = range(3)


def start_chain_growth(series: ChainWorkspace) -> None:
    """Begin with changes of the directions that are there, and of no momentum; with any where there are none."""
    tangents = series.tangents
    if not tangents.any():
        places = np.arange(tangents.shape[1])
        tangents[:] = np.cos(places), np.sin(1.0 + 2.0 * places)
    tangents[:, -1] = 0.0
    _orthonormalise(series)
    series.growth[:] = 0.0


@compiled
def carry_chain(body: Body, coefficients: Coefficients, order: int, length: float, series: ChainWorkspace) -> None:
    """Carry the vectors over a step of that length, by the series of the motion that are in the workspace."""
    segments = series.stretches.shape[1]
    z, v, slope = series.changes[_Z], series.changes[_V], series.changes[_SLOPE]
    for n in range(order + 1):
        softening = coefficients.radial_coupling * series.rear[P, n] - (1.0 if n == 0 else 0.0)
        for j in range(segments):
            slope[n, j] = softening - 3.0 * coefficients.duffing * series.segments[SQUARE, n, j]
    for k in range(_VECTORS):
        change = series.tangents[k]
        for j in range(segments):
            z[0, j] = change[j]
            v[0, j] = change[segments + j]
        for n in range(order + 1):
            for j in range(segments):
                series.pulls[j] = -coefficients.damping * v[n, j]
            for i in range(n + 1):
                for j in range(segments):
                    series.pulls[j] += slope[i, j] * z[n - i, j]
            accelerate_nodes(series.pulls, body.mode, coefficients, False, series)
            for j in range(segments):
                v[n + 1, j] = (series.acceleration[j + 1] - series.acceleration[j]) * segments / (n + 1.0)
                z[n + 1, j] = v[n, j] / (n + 1.0)
        for j in range(segments):
            stretch, rate = z[order + 1, j], v[order + 1, j]
            for n in range(order, -1, -1):
                stretch = stretch * length + z[n, j]
                rate = rate * length + v[n, j]
            change[j], change[segments + j] = stretch, rate
    for j in range(segments):
        series.growth[_DIVERGENCE] -= coefficients.damping * segment_mobility(body.mode, j, series) * length
    _orthonormalise(series)


@compiled
def saltate_chain(
    body: Body, mode: int, coefficients: Coefficients, valve: float, time: float, series: ChainWorkspace
) -> None:
    """Carry the vectors across an event: parameters as for `saltation_of`, with the stretches of the workspace.

    Of the rates only those of the foot's velocity and of the first segment's jump.
    """
    segments = series.stretches.shape[1]
    z, v, p = series.stretches[0, 0], series.stretches[1, 0], body.pressure
    pull = force(coefficients, z, v, p)
    ahead = force(coefficients, series.stretches[0, 1], series.stretches[1, 1], p)
    before, after = (
        _foot_acceleration(pull, body.mode, coefficients, series),
        _foot_acceleration(pull, mode, coefficients, series),
    )
    by_z, by_v, by_p = force_gradient(coefficients, z, p)
    falling = -body.mode * before
    if body.mode == STUCK:
        stretching = segments * ((pull - ahead) * series.mobility[1] - coefficients.slope)
        falling = -mode * (by_z * v + by_v * stretching + by_p * (coefficients.lag_rate * (valve - p)))
    moves = 1.0 / falling if falling > 0.0 and time > 0.0 else 0.0
    for k in range(_VECTORS):
        change = series.tangents[k]
        w = 0.0
        if body.mode == STUCK:
            later = mode * (by_z * change[0] + by_v * change[segments]) * moves
        else:
            w = (change[2 * segments] - _momentum(change, series)) / _mass(series)
            later = body.mode * w * moves
        change[segments] -= segments * (before - after) * later
        change[2 * segments] = 0.0
        if mode != STUCK:
            change[2 * segments] = _mass(series) * (w + (before - after) * later) + _momentum(change, series)
    if mode == STUCK:
        series.growth[_STOPS] += 1.0
    _orthonormalise(series)


@compiled
def note_chain(series: ChainWorkspace, into: NDArray[np.float64]) -> None:
    """Write down how far a vector and an area have grown, as `note_growth` does."""
    into[0] = series.growth[0]
    into[1] = series.growth[0] + series.growth[1]
    into[2], into[3] = series.growth[_DIVERGENCE], series.growth[_STOPS]


@compiled
def _foot_acceleration(pull: float, mode: int, coefficients: Coefficients, series: ChainWorkspace) -> float:
    if mode == STUCK:
        return 0.0
    return -(pull + mode * coefficients.kinetic_friction) * series.mobility[0] - coefficients.slope


@compiled
def _mass(series: ChainWorkspace) -> float:
    mass = 0.0
    for j in range(len(series.mobility)):
        mass += 1.0 / series.mobility[j]
    return mass


@compiled
def _momentum(change: NDArray[np.float64], series: ChainWorkspace) -> float:
    """Momentum of a change in which the foot has no velocity."""
    segments = series.stretches.shape[1]
    velocity = 0.0
    momentum = 0.0
    for j in range(segments):
        velocity += change[segments + j] / segments
        momentum += velocity / series.mobility[j + 1]
    return momentum


@compiled
def _orthonormalise(series: ChainWorkspace) -> None:
    first, second = series.tangents[0], series.tangents[1]
    for k in range(_VECTORS):
        vector = series.tangents[k]
        if k == 1:
            along = 0.0
            for j in range(len(first)):
                along += first[j] * second[j]
            for j in range(len(first)):
                second[j] -= along * first[j]
        size = 0.0
        for j in range(len(vector)):
            size += vector[j] * vector[j]
        size = math.sqrt(size)
        series.growth[k] += math.log(size)
        for j in range(len(vector)):
            vector[j] /= size
