"""The energies that pass through a crawler in a step."""

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled
from .body import Body, Ledger, Physics
from .polynomial import horner, LARGEST_DEGREE
from .taylor import P, V, Z

__all__ = ["account"]

# Row m: nodes and weights of the m-point Gauss-Legendre rule on [0, 1].
_MOST_NODES = LARGEST_DEGREE // 2 + 2
_NODES = np.zeros((_MOST_NODES + 1, _MOST_NODES))
_WEIGHTS = np.zeros((_MOST_NODES + 1, _MOST_NODES))
for _count in range(1, _MOST_NODES + 1):
    _x, _w = np.polynomial.legendre.leggauss(_count)
    _NODES[_count, :_count], _WEIGHTS[_count, :_count] = 0.5 * (1.0 + _x), 0.5 * _w


@compiled
def account(
    ledger: Ledger,
    before: Body,
    after: Body,
    physics: Physics,
    order: int,
    length: float,
    series: NDArray[np.float64],
) -> Ledger:
    """Add one step's energies: int p (1 + Pi5 z) v dt (equation S28), int 2 Pi2 v^2 dt, and drag times distance.

    A product of two series oscillates twice as fast as either, so that truncating it at their order would cost most
    of their accuracy. Gauss-Legendre quadrature of the truncated series on order / 2 + 2 nodes costs as much and loses
    nothing.
    """
    nodes = order // 2 + 2
    work = 0.0
    viscous = 0.0
    for i in range(nodes):
        t = length * _NODES[nodes, i]
        z = horner(series[Z], order + 1, t)
        v = horner(series[V], order + 1, t)
        p = horner(series[P], order, t)
        work += _WEIGHTS[nodes, i] * p * (1.0 + physics.radial_coupling * z) * v
        viscous += _WEIGHTS[nodes, i] * v * v
    return Ledger(
        ledger.work + length * work,
        ledger.viscous + length * physics.damping * viscous,
        ledger.friction + physics.kinetic_friction * abs(after.foot - before.foot),
    )
