"""Where a map's exponent changes its sign, and whether anything else is largest there."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from ...reservoir import Estimate, mean_over_runs

__all__ = ["Best", "best_cell", "chaotic", "difference", "edge_cells", "rank_correlation"]

Array = NDArray[np.float64]
Cells = NDArray[np.bool_]

# Standard errors by which an exponent must be above 0 to be chaos.
_TOLD = 3.0


class Best(NamedTuple):
    """The cell where a measure is largest, each half of the seeds judging what the other half has chosen."""

    cell: tuple[int, ...]
    """Chosen by all seeds."""
    judged: Array
    """(seeds,): what the choice of the other half comes to on each seed."""
    estimate: Estimate
    """Mean of these, without the luck of the choice."""


def best_cell(values: Array, among: Cells | None = None, *, least: float | None = 0.0) -> Best | None:
    """The cell of the largest mean, and what it is worth.

    The largest of many means is one of the luckiest too. So every other seed chooses a cell that the rest judge, and
    the other way round.

    Parameters
    ----------
    values : (..., seeds) array
        Four seeds at least.
    among : (...) array of bool, optional
        Cells to choose from; all by default.
    least : float or None
        Below which no value can be.

    Returns
    -------
    Best or None
        None if there is no cell to choose from.
    """
    allowed = np.isfinite(values).all(axis=-1) & (True if among is None else among)
    if not allowed.any():
        return None

    def chosen(by: Array) -> tuple[int, ...]:
        place = int(np.where(allowed, by.mean(axis=-1), -np.inf).argmax())
        return tuple(int(each) for each in np.unravel_index(place, allowed.shape))

    judged = np.empty(values.shape[-1])
    for half in (0, 1):
        judged[1 - half :: 2] = values[chosen(values[..., half::2])][1 - half :: 2]
    return Best(chosen(values), judged, mean_over_runs(judged, bounds=None if least is None else (least, np.inf)))


def difference(one: Best, other: Best) -> Estimate:
    """How much more one choice comes to than another, on the same seeds; 0 exactly if they are one."""
    if np.array_equal(one.judged, other.judged):
        return Estimate(0.0, 0.0, 0.0, len(one.judged))
    return mean_over_runs(one.judged - other.judged)


def edge_cells(exponent: Array) -> Cells:
    """Cells at which the exponent changes its sign: of two neighbours of other signs the one that is closer to 0.

    Parameters
    ----------
    exponent : array of one or two dimensions

    Returns
    -------
    array of bool
    """
    edge = np.zeros(exponent.shape, np.bool_)
    for axis in range(exponent.ndim):
        along, view = np.moveaxis(exponent, axis, 0), np.moveaxis(edge, axis, 0)
        before, after = along[:-1], along[1:]
        changed = before * after <= 0.0
        closer = np.abs(before) <= np.abs(after)
        view[:-1] |= changed & closer
        view[1:] |= changed & ~closer
    return edge


def chaotic(exponents: Array, within: Array | None = None) -> Cells:
    """Cells whose exponent is above 0 by three standard errors.

    Parameters
    ----------
    exponents : (..., seeds) array
    within : (..., seeds) array, optional
        Standard errors within each run, which tell for a single seed.
    """
    seeds = exponents.shape[-1]
    if seeds > 1:
        error = exponents.std(axis=-1, ddof=1) / np.sqrt(seeds)
    else:
        error = np.full(exponents.shape[:-1], np.inf) if within is None else within[..., 0]
    told: Cells = exponents.mean(axis=-1) > _TOLD * error
    return told


def rank_correlation(one: Array, other: Array) -> float:
    """Spearman's rank correlation of two measures over the cells that have both; nan where one is constant."""
    both = np.isfinite(one) & np.isfinite(other)
    if both.sum() < 3 or np.ptp(one[both]) == 0.0 or np.ptp(other[both]) == 0.0:
        return float("nan")
    return float(spearmanr(one[both], other[both]).statistic)
