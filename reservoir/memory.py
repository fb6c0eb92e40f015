"""Linear memory capacity: how much of its past input a reservoir's state still holds."""

import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, known_names, number_within, whole_number
from .bootstrap import basic_interval, resampled_correlations, squared_interval, usual_block
from .delayed import delayed_products, delayed_rows, delayed_squared_correlations, Delays
from .metrics import squared_correlation_of_rows
from .orthonormal import (
    Array,
    column_norms,
    of_usual_size,
    orthonormal_basis,
    rank_of,
    repair,
    surely_full_rank,
    whitening,
)
from .ridge import (
    affine_weights,
    leave_one_out,
    penalty_on_weights,
    RIDGE,
    samples_needed,
    training_samples,
    whitened_weights,
)
from .sensor_noise import with_sensor_noise
from .significance import chance

# Samples a state in the readout's fit below which it is said that there are few.
_FEW = 5

Scoring = Literal["held out", "leave one out"]


@dataclass(frozen=True, eq=False)
class MemoryCapacity:
    """The memory of a reservoir, delay by delay.

    Attributes
    ----------
    delays : ndarray of shape (delays,)
        Steps into the past; 0 is the input the state has just absorbed.
    profile : ndarray of shape (delays,)
        Capacity MC_d at each delay, in [0, 1].
    cutoff : ndarray of shape (delays,), or float
        The capacity at or below which a delay cannot be told from chance.
    bound : int
        Rank of the centred states. Summed over all delays no linear readout of them can remember more, but for
        what chance adds in a finite sample.
    profile_interval : ndarray of shape (2, delays), or None
        Ends of the interval of confidence of each capacity, if resamples were asked for.
    total_interval : tuple of two floats, or None
        Of the sum of the true capacities of this readout over all delays. `total` overestimates it by what chance adds,
        and is in the interval none the less.
    corrected_interval : tuple of two floats, or None
        Of the sum of the true capacities, of this readout at the delays above the cutoff and of the best readout at all
        of them alike: the lower end is that of the former, the upper end that of all delays and of what the readout
        lost by being fitted to a finite series.
    """

    delays: Delays
    profile: Array
    cutoff: Array | float
    bound: int
    profile_interval: Array | None = None
    total_interval: tuple[float, float] | None = None
    corrected_interval: tuple[float, float] | None = None

    @property
    def total(self) -> float:
        """Sum of the profile. Chance adds about 1 / (2 test samples) for every delay."""
        return float(self.profile.sum())

    @property
    def corrected(self) -> float:
        """Sum of the capacities above the cutoff: exactly 0 for a reservoir that remembers nothing."""
        return float(self.profile[self.profile > self.cutoff].sum())


def memory_capacity(
    states: ArrayLike,
    message: ArrayLike,
    delays: int | Sequence[int],
    *,
    washout: int = 200,
    scoring: Scoring = "held out",
    holdout: float = 0.5,
    ridge: float = RIDGE,
    fit_intercept: bool = True,
    significance: float = 1e-4,
    noise: float | None = None,
    resamples: int = 0,
    confidence: float = 0.95,
    seed: int = 0,
) -> MemoryCapacity:
    """Measure how well a linear readout of the state recovers past values of a message.

    MC_d is the squared correlation of ``message[k - d]`` with its prediction from ``states[k]``, over samples
    the readout was not fitted on; one ridge solve serves all delays. Equation (12) of the paper, after [1]_.

    The cutoff follows [2]_, what a state without memory would score, for predictions of samples that were not
    fitted. In [2]_ the readout is scored on the samples it was fitted on, where chance grows with the number of
    features. Held out, if the state is uncorrelated with ``message[k - d]``, so is the prediction p. The correlation
    then has mean 0 and, in White's form [3]_, the variance ``sum p^2 e^2 / (sum p^2 sum e^2)``: 1 / test samples if p^2
    says nothing of e^2, and much more if both are large at the same rare flips. A negative correlation scores 0, so
    only the half of the normal law with positive sign passes::

        P(correlation > z sqrt(variance)) = P(N(0, 1) > z) = significance

    Left out one by one, the prediction of a message y is ``(H y - h y) / (1 - h)``, with H the projection on r
    centred directions and the constant, and h = (r + 1) / n its mean leverage. With s = y^T H y / Var y, less the
    constant's share, ``correlation = (s - r - 1) / sqrt(n (s - 2 h s + n h^2))``. The cutoff is its square at the
    quantile of s / n, which follows a beta law, or one of its own for each delay where e^2 is not constant:
    `stickslip.reservoir.significance`.

    That a state remembers rare flips rests on the flips. One that holds a product of two flips is a multiple of either
    until both fall together, and passes for memory below some ``9 / dither^2`` samples: with the fourth moment K of the
    message in units of its variance squared, ``-ln(significance) K^2``. A warning says so. `docs/trust.md` has the
    rates.

    The intervals, if resamples are asked for, are basic ones of a circular block bootstrap of the scored samples, for
    single capacities in the scale of ``artanh(correlation)``, widened to Student's law where blocks are few. They say
    how far a score can be trusted that was measured in a run as short as this one. What another run would give, with
    another readout and other random weights, is said by `memory_over_runs`.

    Parameters
    ----------
    states : array_like of shape (samples, features)
        Row k is the state after it absorbed input k.
    message : array_like of shape (samples,)
        What is to be remembered, in any unit: random bits, or the innovation of a valve that follows a
        command. It must be independent from step to step, or what is predictable passes for memory.
    delays : int or sequence of int
        Delays 0 to ``delays - 1``, or the delays themselves, distinct and not negative.
    washout : int
        Samples at the start that are left out: at least as many as the state takes to forget its start.
    scoring : {"held out", "leave one out"}
        Predict the last samples from a readout fitted on the first ones, or each sample from a readout fitted on all
        the others. The latter wastes nothing, and is the one for a short series; where the states drift, it sees the
        future.
    holdout : float, in (0, 1)
        Share of the remaining samples, at the end, on which the prediction is scored if held out.
    ridge, fit_intercept
        As in `fit_readout`.
    significance : float, in (0, 1/2)
        Probability that a delay without memory passes the cutoff.
    noise : float, optional
        Signal-to-noise ratio of the sensors that read the states, in decibels; see
        `stickslip.reservoir.sensor_noise`. None by default.
    resamples : int
        Of the bootstrap. A thousand are plenty; none by default.
    confidence : float, in (0, 1)
        Share of the resamples within the interval.
    seed : int
        Of the bootstrap and the noise.

    Returns
    -------
    MemoryCapacity

    Raises
    ------
    TypeError
        If `delays`, `washout`, `resamples` or `seed` is not integer.
    ValueError
        If an array has a wrong shape, is not finite or too short, the message is constant where it is scored, or an
        argument is out of range.

    Warns
    -----
    UserWarning
        If the readout is fitted on fewer than five samples a state, or the message moves so seldom that too few samples
        are scored to tell it from its products.

    References
    ----------
    .. [1] H. Jaeger, "Short term memory in echo state networks", GMD Report 152, 2001.
    .. [2] J. Dambre, D. Verstraeten, B. Schrauwen and S. Massar, "Information processing capacity of
       dynamical systems", Scientific Reports 2, 514, 2012.
    .. [3] H. White, "A heteroskedasticity-consistent covariance matrix estimator and a direct test for
       heteroskedasticity", Econometrica 48, 817, 1980.
    """
    x = of_usual_size(finite_array("states", states, 2))
    e = finite_array("message", message, 1)
    lags = _lags(delays)
    washout = whole_number("washout", washout, 0)
    known_names("scoring", [scoring], ["held out", "leave one out"])
    holdout = number_within("holdout", holdout, "(0, 1)")
    ridge = number_within("ridge", ridge, "[0, inf)")
    significance = number_within("significance", significance, "(0, 0.5)")
    resamples = whole_number("resamples", resamples, 0)
    confidence = number_within("confidence", confidence, "(0, 1)")
    seed = whole_number("seed", seed, 0)
    start = max(washout, int(lags.max()))
    _refuse_what_cannot_be_scored(x, e, lags, start, washout, holdout if scoring == "held out" else None)

    if fit_intercept:
        # Its level is the constant's, and sums of products keep more digits without it.
        e = e - e.mean()
    x = with_sensor_noise(x, noise, seed)
    first = start if scoring == "leave one out" else start + training_samples(len(x) - start, holdout)
    _refuse_a_constant(e, lags, first)
    if scoring == "leave one out":
        scored = _left_out(x, e, lags, start, ridge, fit_intercept, significance)
    else:
        scored = _held_out(x, e, lags, start, first, ridge, fit_intercept, significance, predicted=resamples > 0)
    _warn_of_few_samples(e, len(x) - first, scored, significance)
    if resamples == 0 or scored.prediction is None:
        return MemoryCapacity(lags, scored.profile, scored.cutoff, scored.bound)
    return _with_intervals(lags, scored, delayed_rows(e, lags, first, len(e)), resamples, confidence, seed)


class _Scored(NamedTuple):
    """How well the message at each delay was read out."""

    profile: Array
    cutoff: Array
    bound: int  # rank of the states
    training: int  # samples that the readout was fitted on
    prediction: Array | None  # (delays, scored samples); None where nobody asked for it


def _left_out(
    x: Array, e: Array, lags: Delays, start: int, ridge: float, fit_intercept: bool, significance: float
) -> _Scored:
    """Each sample predicted by a readout that was fitted on all the others."""
    basis = orthonormal_basis(x[start:])
    target = delayed_rows(e, lags, start, len(e))
    cutoff = _leave_one_out_cutoff(basis, target, significance)
    prediction = leave_one_out(x[start:], target.T, ridge, fit_intercept).T
    profile = squared_correlation_of_rows(prediction, target)
    return _Scored(profile, cutoff, basis.shape[1], len(x) - start, prediction)


def _held_out(
    x: Array,
    e: Array,
    lags: Delays,
    start: int,
    first: int,
    ridge: float,
    fit_intercept: bool,
    significance: float,
    *,
    predicted: bool,
) -> _Scored:
    """The samples from `first` on predicted by a readout that was fitted on those before."""
    weights, bound = _weights_and_bound(x, e, lags, start, first, ridge, fit_intercept)
    profile, scatter = delayed_squared_correlations(x, weights, x[start], e - e.mean(), lags, first, len(x))
    cutoff = NormalDist().inv_cdf(significance) ** 2 * scatter
    if not predicted:
        return _Scored(profile, cutoff, bound, first - start, None)
    prediction = weights.T @ (x[first:] - x[start]).T
    profile = squared_correlation_of_rows(prediction, delayed_rows(e, lags, first, len(e)))
    return _Scored(profile, cutoff, bound, first - start, prediction)


def _warn_of_few_samples(e: Array, samples: int, scored: _Scored, significance: float) -> None:
    if scored.training < _FEW * scored.bound:
        warnings.warn(
            f"the readout is fitted on {scored.training} samples of {scored.bound} independent states: below {_FEW} "
            f"samples a state it misses much of the memory that is there",
            stacklevel=3,
        )
    needed = -math.log(significance) * _kurtosis(e) ** 2
    if samples < needed:
        warnings.warn(
            f"{samples} scored samples are few for a message that moves so seldom: "
            f"below some {needed:.0f} a state that holds products of it passes for memory of it",
            stacklevel=3,
        )


def _with_intervals(
    lags: Delays, scored: _Scored, target: Array, resamples: int, confidence: float, seed: int
) -> MemoryCapacity:
    """Intervals by resampling blocks of the scored samples."""
    profile, cutoff, bound, training, prediction = scored
    assert prediction is not None
    block = usual_block(target.shape[1], lags)
    blocks = target.shape[1] // block
    drawn = resampled_correlations(prediction, target, block, resamples, seed)
    signed = np.sqrt(profile) - np.sqrt(squared_correlation_of_rows(-prediction, target))
    total = _interval(drawn, profile, confidence, blocks)
    of_found = _interval(drawn, profile, confidence, blocks, profile > cutoff)
    # To first order in features / samples, of the best readout's capacity C a share of 1 - C is lost.
    lost = float(np.sum((1 - profile)[profile > cutoff])) * bound / training
    return MemoryCapacity(
        lags,
        profile,
        cutoff,
        bound,
        profile_interval=squared_interval(drawn, signed, confidence, blocks),
        total_interval=total,
        corrected_interval=(of_found[0], max(of_found[1], total[1]) + lost),
    )


def _refuse_what_cannot_be_scored(
    x: Array, e: Array, lags: Delays, start: int, washout: int, holdout: float | None
) -> None:
    samples, features = x.shape
    if len(e) != samples:
        raise ValueError(f"message must have as many samples as states, {samples}, got {len(e)}")
    if np.ptp(e) == 0:
        raise ValueError(f"message must vary, or there is nothing to remember, got {e[0]} throughout")
    # Left out one by one, the others must determine the weights, the constant and one thing more.
    needed = start + (features + 3 if holdout is None else samples_needed(features, holdout))
    if samples < needed:
        scoring = "scoring='leave one out'" if holdout is None else f"holdout={holdout}"
        raise ValueError(
            f"states must have at least {needed} samples for {features} features, washout={washout}, "
            f"delays up to {lags.max()} and {scoring}, got {samples}"
        )


def _kurtosis(message: Array) -> float:
    squares = (message - message.mean()) ** 2
    return float(np.mean(squares**2) / np.mean(squares) ** 2)


def _refuse_a_constant(message: Array, lags: Delays, first: int) -> None:
    changes = np.append(np.flatnonzero(np.diff(message)), len(message))
    still = changes[np.searchsorted(changes, first - lags)] >= len(message) - lags - 1
    if still.any():
        raise ValueError(
            f"message must vary where it is scored, got a constant over the {len(message) - first} samples "
            f"that delay {lags[still][0]} is scored on"
        )


def _weights_and_bound(
    x: Array, e: Array, lags: Delays, start: int, first: int, ridge: float, fit_intercept: bool
) -> tuple[Array, int]:
    """Readouts fitted on the samples from `start` to `first`, and the rank of all from `start` on."""

    def products(to_white: Array | None = None) -> tuple[Array, Array]:
        return delayed_products(x, e, lags, start, first, to_white=to_white, centred=fit_intercept)

    gram, cross = products()
    penalty = penalty_on_weights(ridge, gram.trace(), len(gram))
    white, triangle = whitening(gram), None
    if white is not None and white.nine_digits:
        triangle, projected = np.eye(len(gram)), white.map.T @ cross
    elif white is not None:
        gram, projected = products(white.map)
        triangle = repair(gram)
    if white is None or triangle is None:
        weights, _ = affine_weights(x[start:first], delayed_rows(e, lags, start, first).T, ridge, fit_intercept)
        return weights, rank_of(x[start:])
    full = fit_intercept and surely_full_rank(white, column_norms(x[start:first]))
    return whitened_weights(white.map, triangle, projected, penalty), len(gram) if full else rank_of(x[start:])


def _leave_one_out_cutoff(basis: Array, rows: Array, significance: float) -> Array:
    samples, rank = basis.shape
    if rank == 0:
        return np.zeros(len(rows))
    leverage = (rank + 1) / samples
    s = samples * chance(basis, rows, significance).cutoff
    cutoff: Array = np.maximum(s - rank - 1, 0) ** 2 / (samples * (s - 2 * leverage * s + samples * leverage**2))
    return np.minimum(cutoff, 1)


def _interval(
    drawn: Array, profile: Array, confidence: float, blocks: int, chosen: NDArray[np.bool_] | slice = slice(None)
) -> tuple[float, float]:
    """Basic interval of a sum of squared correlations, and the estimate in it."""
    estimate = float(profile[chosen].sum())
    sums = (np.maximum(drawn, 0) ** 2)[:, chosen].sum(axis=1)
    low, high = basic_interval(sums, estimate, confidence, blocks)
    return max(0.0, min(low, estimate)), min(max(high, estimate), float(profile[chosen].size))


def _lags(delays: int | Sequence[int]) -> Delays:
    if not isinstance(delays, Iterable):
        return np.arange(whole_number("delays", delays, 1))
    lags = np.array([whole_number("delays", d, 0) for d in delays], dtype=np.int64)
    if lags.size == 0 or len(np.unique(lags)) < lags.size:
        raise ValueError(f"delays must hold at least one delay and none twice, got {lags.tolist()}")
    return lags
