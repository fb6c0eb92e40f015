"""What the measurements come to: arrays in, numbers out."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

__all__ = ["Loss", "deviations", "exponent_from", "loss", "tolerance_effect"]


class Loss(NamedTuple):
    """How a result at some tolerance differs from the reference's, seed by seed."""

    bias: float
    """Mean of the paired differences."""
    scatter: float
    """Their standard deviation."""
    rms: float
    """Their root mean square."""
    spread: float
    """Standard deviation of the reference's result over seeds: what a user sees who changes the seed."""

    @property
    def relative(self) -> float:
        """Root mean square of the differences, in spreads: the share of the seeds' noise that the solver adds."""
        return self.rms / self.spread


def loss(values: ArrayLike, reference: ArrayLike) -> Loss:
    """Compare results with the reference's.

    Parameters
    ----------
    values, reference : array_like of shape (seeds,)
        Entry i of both had the same random bits. Two seeds at least.
    """
    true = np.asarray(reference, dtype=float)
    difference = np.asarray(values, dtype=float) - true
    return Loss(
        bias=float(difference.mean()),
        scatter=float(difference.std(ddof=1)),
        rms=float(np.sqrt((difference**2).mean())),
        spread=float(true.std(ddof=1)),
    )


def deviations(table: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean of each tolerance less the mean of all, and its standard error.

    What the seeds have in common at all tolerances is taken out first, so that only the difference is in doubt.

    Parameters
    ----------
    table : array_like of shape (tolerances, seeds)

    Returns
    -------
    deviation, standard_error : ndarray of shape (tolerances,)
    """
    paired = np.asarray(table, dtype=float)
    paired = paired - paired.mean(axis=0)
    return paired.mean(axis=1), paired.std(axis=1, ddof=1) / np.sqrt(paired.shape[1])


def tolerance_effect(table: ArrayLike) -> float:
    """Probability of means as different as these if the tolerance had no effect.

    F-test of a two-way analysis of variance without interaction, tolerance by seed.

    Parameters
    ----------
    table : array_like of shape (tolerances, seeds)
        Two of each at least.
    """
    values = np.asarray(table, dtype=float)
    tolerances, seeds = values.shape
    effect = values.mean(axis=1, keepdims=True) - values.mean()
    residual = values - effect - values.mean(axis=0, keepdims=True)
    between = seeds * (effect**2).sum() / (tolerances - 1)
    within = (residual**2).sum() / ((tolerances - 1) * (seeds - 1))
    return float(stats.f.sf(between / within, tolerances - 1, (tolerances - 1) * (seeds - 1)))


def exponent_from(tolerances: ArrayLike, parted: ArrayLike) -> float:
    """Rate at which motions part, from when they are apart: the slope of -log(tolerance) on time.

    An error of `tolerance` grows as exp(rate t), so tightening by a factor e buys 1 / rate of time. It estimates the
    largest Lyapunov exponent.

    Parameters
    ----------
    tolerances, parted : array_like of shape (tolerances,)
    """
    return float(-1.0 / np.polyfit(np.log(np.asarray(tolerances)), np.asarray(parted), 1)[0])
