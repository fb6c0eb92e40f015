"""What spreads the work: the variance over an ensemble, split into what inputs and what starts make of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Split", "split"]

_DRAWS = 2000


@dataclass(frozen=True)
class Split:
    """Variances of work, and the share that the start has in it.

    Attributes
    ----------
    of_inputs : float
        Variance of the work's mean over starts.
    of_starts : float
        Mean over inputs of the variance over starts: what is left where the input is fixed.
    share, low, high : float
        of_starts / (of_inputs + of_starts), and its 95% interval by bootstrap over inputs.
    """

    of_inputs: float
    of_starts: float
    share: float
    low: float
    high: float


def split(works: NDArray[np.float64], seed: int = 0) -> Split:
    """Split the variance of work by the law of total variance.

    Var W = Var E(W | input) + E Var(W | input), each without bias: from the variance of the means over J starts the
    J-th part of the other is taken off (one-way analysis of variance with random effects: Searle, Casella and
    McCulloch, Variance Components, 1992, section 3.6).

    Parameters
    ----------
    works : (inputs, starts) array
        Two of either at least.
    seed : int
        Of the bootstrap.

    Returns
    -------
    Split
    """
    draws = np.random.default_rng(seed).integers(len(works), size=(_DRAWS, len(works)))
    means, within = works.mean(axis=1), works.var(axis=1, ddof=1)
    of_inputs, of_starts = _variances(means, within, works.shape[1])
    low, high = np.quantile(_share(*_variances(means[draws], within[draws], works.shape[1])), [0.025, 0.975])
    share = _share(of_inputs, of_starts)
    return Split(float(of_inputs), float(of_starts), float(share), float(low), float(high))


def _variances(
    means: NDArray[np.float64], within: NDArray[np.float64], starts: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    of_starts = within.mean(axis=-1)
    return np.maximum(means.var(axis=-1, ddof=1) - of_starts / starts, 0.0), of_starts


def _share(of_inputs: NDArray[np.float64], of_starts: NDArray[np.float64]) -> NDArray[np.float64]:
    whole = np.asarray(of_inputs + of_starts)
    return np.divide(of_starts, whole, out=np.zeros_like(whole), where=whole > 0.0)
