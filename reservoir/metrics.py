"""How close a prediction comes to its target."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array


def nrmse(prediction: ArrayLike, target: ArrayLike) -> float:
    """Root-mean-square error as a fraction of the target's standard deviation.

    ``sqrt(mean((prediction - target)^2) / Var target)``: 0 is perfect, 1 is what the target's mean scores.

    Parameters
    ----------
    prediction, target : array_like of shape (samples,)
        The variance is the target's over these same samples.

    Returns
    -------
    float
        In [0, inf).

    Raises
    ------
    ValueError
        If the shapes differ, a value is not finite, or a target is constant.
    """
    guess, truth = _pair(prediction, target, 1)
    return float(np.sqrt(np.mean((guess - truth) ** 2) / np.var(truth)))


def squared_correlation(prediction: ArrayLike, target: ArrayLike) -> NDArray[np.float64]:
    """Squared correlation of a held-out prediction with its target, zero where the correlation is negative.

    ``Cov(prediction, target)^2 / (Var prediction Var target)``, equation (12) of the paper. The square alone
    would take a prediction that runs against its target for knowledge of it. On data the readout has not
    seen, that happens by chance only, so it scores 0, and so does a constant prediction.

    Parameters
    ----------
    prediction, target : array_like of shape (samples,) or (samples, outputs)
        Means and variances are taken over these same samples, which keeps the result at or below 1.

    Returns
    -------
    ndarray of shape () or (outputs,)
        In [0, 1].

    Raises
    ------
    ValueError
        If the shapes differ, a value is not finite, or a target is constant.
    """
    guess, truth = _pair(prediction, target, (1, 2))
    # Outputs become rows, whose sums run along memory.
    scores = squared_correlation_of_rows(np.atleast_2d(guess.T), np.atleast_2d((truth - truth.mean(axis=0)).T))
    return scores.reshape(guess.shape[1:])


def squared_correlation_of_rows(prediction: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """`squared_correlation` without the checks, of each row.

    Parameters
    ----------
    prediction : ndarray of shape (outputs, samples)
    target : ndarray of shape (outputs, samples)
        Of means that are no larger than the spread, or not by much.

    Returns
    -------
    ndarray of shape (outputs,)
    """
    samples = target.shape[1]
    average = np.full(samples, 1 / samples)
    guess = prediction - (prediction @ average)[:, None]
    # A centred prediction asks for no centred target.
    covariance = np.maximum(np.vecdot(guess, target), 0)
    scale = np.vecdot(guess, guess) * (np.vecdot(target, target) - samples * (target @ average) ** 2)
    # Rounding can carry a perfect correlation past 1 in the last digit.
    return np.minimum(np.divide(covariance**2, scale, out=np.zeros_like(scale), where=scale > 0), 1)


def _pair(
    prediction: ArrayLike, target: ArrayLike, ndim: int | tuple[int, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    guess = finite_array("prediction", prediction, ndim)
    truth = finite_array("target", target, ndim)
    if guess.shape != truth.shape:
        raise ValueError(f"prediction must have the shape of target, {truth.shape}, got {guess.shape}")
    if (np.ptp(truth, axis=0) == 0).any():
        raise ValueError(f"target must vary to be scored, got a constant over {len(truth)} samples")
    return guess, truth
