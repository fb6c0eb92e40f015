"""Intervals of confidence: from one run by resampling blocks of it, and over independent runs by Student's t."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within

Array = NDArray[np.float64]

# Correlation whose inverse hyperbolic tangent keeps digits.
_NEARLY_ONE = 1 - 1e-14
# Share of the mean that a run counts for at least in a logarithm: 0 has none.
_FLOOR = 0.1
# Lengths of Student's half interval that skew may add to it: two runs would be worth nothing otherwise.
_FURTHEST = 5
_ROUNDING = 1e-9
# Share of the largest score by which equal ones may differ, by rounding alone.
_EQUAL = 1e-13


@dataclass(frozen=True)
class Estimate:
    """A mean over independent runs, and where the true mean lies.

    Attributes
    ----------
    mean : float
    low, high : float
        Ends of the interval of confidence; NaN where none is known.
    runs : int
    """

    mean: float
    low: float
    high: float
    runs: int

    def at_most(self, bound: float) -> Self:
        """The same, with an upper end that does not pass a bound of the true mean; the mean itself may, by chance."""
        return replace(self, high=float(np.maximum(self.mean, np.minimum(self.high, bound))))


def mean_over_runs(
    values: ArrayLike, confidence: float = 0.95, *, bounds: tuple[float, float] | None = None
) -> Estimate:
    """Average a score over independent runs.

    The interval is Student's: ``mean ± t s / sqrt(runs)``, s being the sample standard deviation. For the five or ten
    runs that are usual, a bootstrap over them would be far too narrow.

    A score near a bound is skewed away from it, and five runs seldom hold the few that make its mean: Student's
    interval then covers 84% where it says 95%. So where there is a lower bound the upper end is at least
    ``mean exp(t s' / sqrt(runs))``, with s' the standard deviation of the logarithms of what is above the bound, each
    at least a tenth of its mean (but at most five times as far from the mean as Student's end). Likewise for an upper
    bound; and no end passes a bound. Without bounds, values of one sign are treated as bounded by 0, but for the end
    that may pass it. `docs/trust.md` says what that covers: at 95%, from three to ten runs, 94% and more of normal and
    exponential scores and of parities, but 90% to 93% of lognormal ones and of a gamma law of shape 0.3.

    Runs that all score the same, to rounding, tell no spread, and both ends are NaN. Of scores of which one in five is
    1, and the rest 0, three are all 0 in every second trial and five in every third; an interval from 0 to 0 would be
    wrong there.

    Parameters
    ----------
    values : array_like of shape (runs,)
        Two at least, each with its own seed.
    confidence : float, in (0, 1)
    bounds : tuple of two floats, optional
        Between which the score always lies: (0, inf) for a capacity or an error, none for a difference of scores.

    Returns
    -------
    Estimate

    Raises
    ------
    ValueError
        If there are fewer than two values, one is not finite or out of bounds, or `confidence` is out of range.
    """
    # Imported where it is used: it takes a fifth of a second, and whoever only steps an environment needs none of it.
    from scipy.special import stdtrit

    x = finite_array("values", values, 1)
    confidence = number_within("confidence", confidence, "(0, 1)")
    if len(x) < 2:
        raise ValueError(f"values must hold two runs at least to tell how much they differ, got {len(x)}")
    least, most = (-math.inf, math.inf) if bounds is None else bounds
    # A score may miss its bound by rounding.
    if not least < most or (x < least - _ROUNDING).any() or (x > most + _ROUNDING).any():
        raise ValueError(f"bounds must hold all values, from {x.min()} to {x.max()}, got {bounds}")
    errors = float(stdtrit(len(x) - 1, (1 + confidence) / 2)) / math.sqrt(len(x))
    if np.ptp(x) <= _EQUAL * float(np.abs(x).max()):
        return Estimate(float(x.mean()), math.nan, math.nan, len(x))
    mean, half = float(x.mean()), errors * float(x.std(ddof=1))
    low, high = max(mean - half, least), min(mean + half, most)
    below, above = (0.0 if (x >= 0).all() else least, 0.0 if (x <= 0).all() else most) if bounds is None else bounds
    if math.isfinite(above):
        low = max(least, min(low, max(above - _skewed_end(above - x, errors), mean - _FURTHEST * half)))
    if math.isfinite(below):
        high = min(most, max(high, min(below + _skewed_end(x - below, errors), mean + _FURTHEST * half)))
    return Estimate(mean, low, high, len(x))


def _skewed_end(x: Array, errors: float) -> float:
    mean = float(x.mean())
    if mean <= 0:
        return 0.0
    logs = np.log(np.maximum(x, _FLOOR * mean))
    return mean * math.exp(errors * float(logs.std(ddof=1)))


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


def squared_interval(drawn: Array, estimate: Array, confidence: float, blocks: int) -> Array:
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
    blocks : int
        As in `basic_interval`.

    Returns
    -------
    ndarray of shape (2, outputs)
    """
    ends = np.tanh(basic_interval(_spread_out(drawn), _spread_out(estimate), confidence, blocks))
    squared: Array = np.maximum(ends, 0) ** 2
    # At 1 the tangent's digits end, and a score of the series is in its interval.
    score = np.maximum(estimate, 0) ** 2
    return np.array([np.minimum(squared[0], score), np.maximum(squared[1], score)])


def basic_interval(drawn: Array, estimate: Array | float, confidence: float, blocks: int) -> Array:
    """Interval by how far resampled values lie from the estimate, which lies as far from the truth.

    A spread that is known from a few blocks alone is that of Student's law: the ends are moved away from the estimate
    by ``t / z sqrt(blocks / (blocks - 1))``, t and z being the quantiles of Student's law with ``blocks - 1`` degrees
    of freedom and of the normal one. It is 1.22 for ten blocks, 1.02 for a hundred.

    Parameters
    ----------
    drawn : ndarray of shape (resamples, ...)
    estimate : ndarray of shape (...), or float
    confidence : float, in (0, 1)
    blocks : int
        Of which a resample is made.

    Returns
    -------
    ndarray of shape (2, ...)
    """
    # Imported where it is used: it takes a fifth of a second, and whoever only steps an environment needs none of it.
    from scipy.special import ndtri, stdtrit

    beyond, degrees = (1 - confidence) / 2, max(blocks - 1, 1)
    wider = float(stdtrit(degrees, 1 - beyond) / ndtri(1 - beyond)) * math.sqrt((degrees + 1) / degrees)
    ends: Array = estimate + wider * (estimate - np.quantile(drawn, [1 - beyond, beyond], axis=0))
    return ends


def _spread_out(correlation: Array) -> Array:
    return np.arctanh(np.clip(correlation, -_NEARLY_ONE, _NEARLY_ONE))


def _standardized(rows: Array) -> Array:
    # Running sums of what is of the order of 1 lose nothing that matters.
    moved = rows - rows.mean(axis=1, keepdims=True)
    spread = moved.std(axis=1, keepdims=True)
    return moved / np.where(spread > 0, spread, 1)
