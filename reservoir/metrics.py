"""How close a prediction comes to its target."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .validation import finite_array


def _pair(
    prediction: ArrayLike, target: ArrayLike, ndim: int | tuple[int, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    prediction = finite_array("prediction", prediction, ndim)
    target = finite_array("target", target, ndim)
    if prediction.shape != target.shape:
        raise ValueError(f"prediction must have the shape of target, {target.shape}, got {prediction.shape}")
    if (np.ptp(target, axis=0) == 0).any():
        raise ValueError(f"target must vary to be scored, got a constant over {len(target)} samples")
    return prediction, target


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
    prediction, target = _pair(prediction, target, 1)
    return float(np.sqrt(np.mean((prediction - target) ** 2) / np.var(target)))


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
    prediction, target = _pair(prediction, target, (1, 2))
    prediction = prediction - prediction.mean(axis=0)
    target = target - target.mean(axis=0)
    covariance = np.maximum((prediction * target).sum(axis=0), 0)
    scale = (prediction**2).sum(axis=0) * (target**2).sum(axis=0)
    # Rounding can carry a perfect correlation past 1 in the last digit.
    return np.minimum(np.divide(covariance**2, scale, out=np.zeros_like(scale), where=scale > 0), 1)
