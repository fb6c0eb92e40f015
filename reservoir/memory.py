"""Linear memory capacity: how much of its past input a reservoir's state still holds."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import finite_array, number_within, whole_number
from .metrics import squared_correlation
from .ridge import predict_held_out, samples_needed


@dataclass(frozen=True, eq=False)
class MemoryCapacity:
    """The memory of a reservoir, delay by delay.

    Attributes
    ----------
    delays : ndarray of shape (delays,)
        Steps into the past; 0 is the input the state has just absorbed.
    profile : ndarray of shape (delays,)
        Capacity MC_d at each delay, in [0, 1].
    cutoff : float
        The capacity at or below which a delay cannot be told from chance.
    bound : int
        Rank of the centred states. Summed over all delays no linear readout of them can remember more, but for
        what chance adds in a finite sample.
    """

    delays: NDArray[np.int64]
    profile: NDArray[np.float64]
    cutoff: float
    bound: int

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
    holdout: float = 0.5,
    ridge: float = 1e-6,
    fit_intercept: bool = True,
    significance: float = 1e-4,
) -> MemoryCapacity:
    """Measure how well a linear readout of the state recovers past values of a message.

    MC_d is the squared correlation of ``message[k - d]`` with its prediction from ``states[k]``, over samples
    the readout was not fitted on; one ridge solve serves all delays. Equation (12) of the paper, after [1]_.

    The cutoff is that of [2]_, what a state without memory would score, for held-out scores. In [2]_ the
    readout is scored on the samples it was fitted on, where chance grows with the number of features. Here,
    if the state knows nothing of ``message[k - d]``, the prediction is independent of it, and
    test samples x correlation^2 follows a chi-squared law with one degree of freedom, however many the
    features. A negative correlation scores 0, so only the half of that law with positive sign passes q::

        P(correlation > 0 and test samples * correlation^2 > q) = P(N(0, 1) > sqrt(q)) = significance

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
    holdout : float, in (0, 1)
        Share of the remaining samples, at the end, on which the prediction is scored.
    ridge, fit_intercept
        As in `fit_readout`.
    significance : float, in (0, 1/2)
        Probability that a delay without memory passes the cutoff.

    Returns
    -------
    MemoryCapacity

    Raises
    ------
    TypeError
        If `delays` or `washout` is not integer.
    ValueError
        If an array has a wrong shape, is not finite or too short, the message is constant, or a number is out
        of range.

    References
    ----------
    .. [1] H. Jaeger, "Short term memory in echo state networks", GMD Report 152, 2001.
    .. [2] J. Dambre, D. Verstraeten, B. Schrauwen and S. Massar, "Information processing capacity of
       dynamical systems", Scientific Reports 2, 514, 2012.
    """
    x = finite_array("states", states, 2)
    e = finite_array("message", message, 1)
    samples, features = x.shape
    lags = _lags(delays)
    washout = whole_number("washout", washout, 0)
    holdout = number_within("holdout", holdout, "(0, 1)")
    significance = number_within("significance", significance, "(0, 0.5)")
    if len(e) != samples:
        raise ValueError(f"message must have as many samples as states, {samples}, got {len(e)}")
    if np.ptp(e) == 0:
        raise ValueError(f"message must vary, or there is nothing to remember, got {e[0]} throughout")
    # The message before the washout is known even though the state is not yet trusted, so the two overlap.
    start = max(washout, int(lags.max()))
    needed = start + samples_needed(features, holdout)
    if samples < needed:
        raise ValueError(
            f"states must have at least {needed} samples for {features} features, washout={washout}, "
            f"delays up to {lags.max()} and holdout={holdout}, got {samples}"
        )
    settled = x[start:]
    delayed = e[np.arange(start, samples)[:, None] - lags]
    prediction, target = predict_held_out(settled, delayed, holdout=holdout, ridge=ridge, fit_intercept=fit_intercept)
    return MemoryCapacity(
        delays=lags,
        profile=squared_correlation(prediction, target),
        cutoff=NormalDist().inv_cdf(significance) ** 2 / len(target),
        bound=_centred_rank(settled),
    )


def _centred_rank(states: NDArray[np.float64]) -> int:
    # Relative to the states before centring, or the rounding of their mean would pass for a direction.
    rounding = np.linalg.norm(states) * max(states.shape) * np.finfo(np.float64).eps
    return int(np.linalg.matrix_rank(states - states.mean(axis=0), tol=rounding))


def _lags(delays: int | Sequence[int]) -> NDArray[np.int64]:
    if not isinstance(delays, Iterable):
        return np.arange(whole_number("delays", delays, 1))
    lags = np.array([whole_number("delays", d, 0) for d in delays], dtype=np.int64)
    if lags.size == 0 or len(np.unique(lags)) < lags.size:
        raise ValueError(f"delays must hold at least one delay and none twice, got {lags.tolist()}")
    return lags
