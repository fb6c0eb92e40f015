"""Intervals of confidence: from one run by resampling blocks of it, and over independent runs by Student's t."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import finite_array, number_within

Array = NDArray[np.float64]

# Correlation whose inverse hyperbolic tangent keeps digits.
_NEARLY_ONE = 1 - 1e-14


@dataclass(frozen=True)
class Estimate:
    """A mean over independent runs, and where the true mean lies.

    Attributes
    ----------
    mean : float
    low, high : float
        Ends of the interval of confidence.
    runs : int
    """

    mean: float
    low: float
    high: float
    runs: int


def mean_over_runs(values: ArrayLike, confidence: float = 0.95) -> Estimate:
    """Average a score over independent runs.

    The interval is Student's: ``mean ± t s / sqrt(runs)``, s being the sample standard deviation. For the five or ten
    runs that are usual, a bootstrap over them would be far too narrow.

    Parameters
    ----------
    values : array_like of shape (runs,)
        Two at least, each with its own seed.
    confidence : float, in (0, 1)

    Returns
    -------
    Estimate

    Raises
    ------
    ValueError
        If there are fewer than two values, one is not finite, or `confidence` is out of range.
    """
    # Imported where it is used: it takes a fifth of a second, and whoever only steps an environment needs none of it.
    from scipy.special import stdtrit

    x = finite_array("values", values, 1)
    confidence = number_within("confidence", confidence, "(0, 1)")
    if len(x) < 2:
        raise ValueError(f"values must hold two runs at least to tell how much they differ, got {len(x)}")
    half = stdtrit(len(x) - 1, (1 + confidence) / 2) * x.std(ddof=1) / math.sqrt(len(x))
    return Estimate(float(x.mean()), float(x.mean() - half), float(x.mean() + half), len(x))


def usual_block(samples: int, delays: Sequence[int] | NDArray[np.int64]) -> int:
    """Choose the length of the blocks: the usual cube root of the samples, and all that one input is a target of.

    Parameters
    ----------
    samples : int
    delays : sequence of int
        Delays at which the same input is a target.

    Returns
    -------
    int
        A tenth of the samples at most, so that blocks remain to be drawn.
    """
    span = int(max(delays)) - int(min(delays)) + 1
    return max(1, min(max(math.ceil(samples ** (1 / 3)), span), samples // 10))


def resampled_correlations(prediction: Array, target: Array, block: int, resamples: int, seed: int) -> Array:
    """Correlations on series made of blocks drawn from a series, with replacement.

    Neighbours in time depend on each other, and stay together in a block. The series is closed to a circle, so that
    every sample is drawn as often as any other [1]_. All rows are drawn alike, for the same input is a target in many.

    Parameters
    ----------
    prediction, target : ndarray of shape (outputs, samples)
    block : int, in [1, samples]
        Samples in a block.
    resamples : int
    seed : int

    Returns
    -------
    ndarray of shape (resamples, outputs)
        In [-1, 1]; 0 where a prediction or a target came out constant.

    References
    ----------
    .. [1] D. N. Politis and J. P. Romano, "A circular block-resampling procedure for stationary data", in "Exploring
       the limits of bootstrap", 1992.
    """
    outputs, samples = prediction.shape
    p = _standardized(prediction)
    t = _standardized(target)
    moments = np.concatenate([p, t, p * p, t * t, p * t]).T
    running = np.zeros((samples + block, moments.shape[1]))
    np.cumsum(np.concatenate([moments, moments[: block - 1]]), axis=0, out=running[1:])
    of_block = running[block:] - running[:-block]

    random = np.random.default_rng(seed)
    blocks = math.ceil(samples / block)
    starts = random.integers(0, samples, (resamples, blocks))
    sums = np.stack([of_block[drawn].sum(axis=0) for drawn in starts]) / (blocks * block)
    p1, t1, p2, t2, pt = sums.reshape(resamples, 5, outputs).transpose(1, 0, 2)
    covariance = pt - p1 * t1
    scale = np.sqrt(np.maximum(p2 - p1**2, 0) * np.maximum(t2 - t1**2, 0))
    return np.clip(np.divide(covariance, scale, out=np.zeros_like(scale), where=scale > 0), -1, 1)


def squared_interval(drawn: Array, estimate: Array, confidence: float) -> Array:
    """Basic interval of a correlation in the scale of its inverse hyperbolic tangent, squared.

    In that scale a correlation scatters alike wherever it lies, and no end leaves [-1, 1]. Where the lower end is
    negative the square's is 0.

    Parameters
    ----------
    drawn : ndarray of shape (resamples, outputs)
        Correlations of resamples.
    estimate : ndarray of shape (outputs,)
        Correlation of the series itself.
    confidence : float, in (0, 1)

    Returns
    -------
    ndarray of shape (2, outputs)
    """
    known = _spread_out(estimate)
    ends = np.tanh(2 * known - percentiles(_spread_out(drawn), confidence)[::-1])
    squared: Array = np.maximum(ends, 0) ** 2
    # At 1 the tangent's digits end, and a score of the series is in its interval.
    score = np.maximum(estimate, 0) ** 2
    return np.array([np.minimum(squared[0], score), np.maximum(squared[1], score)])


def percentiles(values: Array, confidence: float) -> Array:
    """Ends of the central interval that holds a share of resampled values.

    Parameters
    ----------
    values : ndarray of shape (resamples, ...)
    confidence : float, in (0, 1)

    Returns
    -------
    ndarray of shape (2, ...)
    """
    return np.quantile(values, [(1 - confidence) / 2, (1 + confidence) / 2], axis=0)


def _spread_out(correlation: Array) -> Array:
    return np.arctanh(np.clip(correlation, -_NEARLY_ONE, _NEARLY_ONE))


def _standardized(rows: Array) -> Array:
    # Running sums of what is of the order of 1 lose nothing that matters.
    moved = rows - rows.mean(axis=1, keepdims=True)
    spread = moved.std(axis=1, keepdims=True)
    return moved / np.where(spread > 0, spread, 1)
