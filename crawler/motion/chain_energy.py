"""The energies that pass through a chain in a step."""

import numpy as np

from ...compiling.compilation import compiled
from ...compiling.roots import horner, LARGEST_DEGREE
from ..model.state import Body, Coefficients, Ledger
from ..steps.chain_series import ChainWorkspace, stretches_at
from ..steps.workspace import P
from .energy import posted

__all__ = ["account_chain"]

# Row m: nodes and weights of the m-point Gauss-Legendre rule on [0, 1].
_MOST_NODES = LARGEST_DEGREE // 2 + 2
_NODES = np.zeros((_MOST_NODES + 1, _MOST_NODES))
_WEIGHTS = np.zeros((_MOST_NODES + 1, _MOST_NODES))
for _count in range(1, _MOST_NODES + 1):
    _x, _w = np.polynomial.legendre.leggauss(_count)
    _NODES[_count, :_count], _WEIGHTS[_count, :_count] = 0.5 * (1.0 + _x), 0.5 * _w


@compiled
def account_chain(
    ledger: Ledger,
    before: Body,
    after: Body,
    coefficients: Coefficients,
    order: int,
    length: float,
    series: ChainWorkspace,
) -> Ledger:
    """Add one step's energies, each segment's share being a crawler's over N; overwrites `series.ahead`."""
    nodes = order // 2 + 2
    segments = series.ahead.shape[1]
    work = 0.0
    viscous = 0.0
    for i in range(nodes):
        t = length * _NODES[nodes, i]
        stretches_at(order, t, series)
        p = horner(series.rear[P], order, t)
        for j in range(segments):
            z = series.ahead[0, j]
            v = series.ahead[1, j]
            work += _WEIGHTS[nodes, i] * p * (1.0 + coefficients.radial_coupling * z) * v
            viscous += _WEIGHTS[nodes, i] * v * v
    work *= length / segments
    viscous *= length * coefficients.damping / segments
    return posted(ledger, before, after, coefficients, work, viscous)
