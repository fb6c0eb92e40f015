"""Capacities of functions that are not quite orthogonal: each without those before it and without chance."""

import math
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Iterations of a contraction by the share of chance, which is a tenth or so.
_TURNS = 20
# Share of a function left by those before it below which it is one of them, but for rounding.
_NEW = 1e-6


class SequentialCapacity(NamedTuple):
    """What each of some functions adds to the capacity of those before it.

    Attributes
    ----------
    capacity : ndarray of shape (functions,)
        Without what chance explains.
    chance : ndarray of shape (functions,)
        Share that chance explains.
    influence : ndarray of shape (functions, blocks)
        Of each block of samples on each capacity: what moves it, to first order.
    """

    capacity: Array
    chance: Array
    influence: Array


def sequential_capacity(q: Array, rows: Array, block: int) -> SequentialCapacity:
    """Capacity of what each function adds to those before it: a decomposition of the trace of two projections.

    Parameters
    ----------
    q : ndarray of shape (samples, rank)
        Orthonormal basis of the states, of zero mean.
    rows : ndarray of shape (functions, samples)
    block : int, at most the samples
        Samples in a block; the last that make no whole one move nothing.

    Returns
    -------
    SequentialCapacity
    """
    blocks = len(q) // block
    if rows.size == 0:
        return SequentialCapacity(np.zeros(len(rows)), np.zeros(len(rows)), np.zeros((len(rows), blocks)))
    moved = (rows - rows.mean(axis=1, keepdims=True)).T
    norms = np.linalg.norm(moved, axis=0)
    turned, triangle = scipy.linalg.qr(moved, mode="economic", check_finite=False)
    new = np.abs(triangle.diagonal()) > _NEW * norms[: len(triangle)]
    turned[:, ~new] = 0
    projected = q.T @ turned
    explained = np.minimum(np.einsum("ij,ij->j", projected, projected), 1)
    leverage = np.vecdot(q, q)
    capacity, by_chance = _without_chance(explained, leverage @ turned**2, q.shape[1])
    # Of a capacity 1 - e^2 / y^2, the residual e being that of a readout that was not fitted to its own sample, nearly.
    alone = np.maximum(1 - leverage, 1 / len(q))
    influence = np.zeros((len(rows), blocks))
    for i in np.flatnonzero(new):
        missed = (turned[:, i] - q @ projected[:, i]) ** 2 / alone
        moved_by = (1 - capacity[i]) * turned[:, i] ** 2 - missed
        influence[i] = moved_by[: blocks * block].reshape(blocks, block).sum(axis=1)
    beyond = len(rows) - len(new)
    return SequentialCapacity(np.pad(capacity, (0, beyond)), np.pad(by_chance, (0, beyond)), influence)


def _without_chance(explained: Array, by_chance: Array, rank: int) -> tuple[Array, Array]:
    """Capacities as they would be in an endless series, and what chance explains of each in this one.

    Functions of capacities C in the mean explain ``sum_i sum_j (1 - C_i) (1 - C_j) / samples`` too much in all, the
    second sum being over the states' directions: what is explained already is not left to chance. The first function
    has its share of that as if it were alone, and those after it ever less, for they are turned away from the first.
    """
    capacity, share = explained, by_chance
    for _ in range(_TURNS):
        before = np.cumsum(capacity) - capacity
        share = by_chance * np.maximum(1 - 2 * before / rank, 0)
        left = np.maximum(1 - share, np.finfo(np.float64).tiny)
        capacity = np.clip((explained - share) / left, 0, 1)
    return capacity, share


def intervals(each: SequentialCapacity, confidence: float, rank: int) -> tuple[Array, tuple[float, float]]:
    """Intervals of confidence of the capacities and of their sum, from the influence of blocks of samples.

    Parameters
    ----------
    each : SequentialCapacity
    confidence : float, in (0, 1)
    rank : int
        Of the states, which bounds the sum.

    Returns
    -------
    ends : ndarray of shape (2, functions)
    total : tuple of two floats
    """
    # Imported where it is used: it takes a fifth of a second, and whoever only steps an environment needs none of it.
    from scipy.special import stdtrit

    sums = each.influence
    count, blocks = sums.shape
    if count == 0:
        return np.zeros((2, 0)), (0.0, 0.0)
    reach = float(stdtrit(max(blocks - 1, 1), (1 + confidence) / 2))
    inflation = blocks / max(blocks - 1, 1)
    error = np.sqrt(inflation * np.vecdot(sums, sums))
    c = np.clip(each.capacity, 1e-12, 1 - 1e-12)
    logit, spread = np.log(c / (1 - c)), reach * error / (c * (1 - c))
    ends = 1 / (1 + np.exp(-np.clip(logit + np.array([[-1], [1]]) * spread, -700, 700)))
    ends[0] = np.minimum(ends[0], each.capacity)
    ends[1] = np.maximum(ends[1], each.capacity)
    total, half = float(each.capacity.sum()), reach * math.sqrt(inflation) * float(np.linalg.norm(sums.sum(axis=0)))
    return ends, (max(total - half, 0.0), min(total + half, max(float(rank), total)))
