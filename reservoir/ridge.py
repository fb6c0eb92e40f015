"""The linear readout: ridge regression from reservoir states to targets."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import finite_array, number_within

if TYPE_CHECKING:
    from sklearn.linear_model import Ridge

# A share such as 0.3 is not exact in binary; a count that misses a whole number by this much is that number.
_ROUNDING = 1e-9


def fit_readout(states: ArrayLike, targets: ArrayLike, *, ridge: float = 1e-6, fit_intercept: bool = True) -> Ridge:
    """Fit one readout for all targets in a single solve.

    Without an intercept this is equation (11) of the paper, with the states R and the targets Y as columns::

        W_out = Y R^T (R R^T + ridge I)^-1

    It is solved through the singular values of R, since R R^T squares the condition number, and states
    sampled within one hold of the valve are close to collinear.

    Parameters
    ----------
    states : array_like of shape (samples, features)
        Row k is the state after input k was absorbed.
    targets : array_like of shape (samples,) or (samples, outputs)
        What the readout is to report at the same instants.
    ridge : float, in [0, inf)
        Penalty on the squared weights, in squared units of `states`, not scaled by the number of samples.
        Zero gives the least-squares solution of least norm.
    fit_intercept : bool
        Whether to learn an unpenalized constant beside the weights.

    Returns
    -------
    sklearn.linear_model.Ridge
        Fitted; ``coef_`` is W_out, of shape (outputs, features), or (features,) for a single output.

    Raises
    ------
    ValueError
        If an array has a wrong shape or is not finite, the lengths differ, or `ridge` is out of range.
    """
    # Imported here because it takes a second, and whoever only steps an environment needs none of it.
    from sklearn.linear_model import Ridge

    x = finite_array("states", states, 2)
    y = finite_array("targets", targets, (1, 2))
    if len(x) != len(y):
        raise ValueError(f"targets must have as many samples as states, {len(x)}, got {len(y)}")
    penalty = number_within("ridge", ridge, "[0, inf)")
    return Ridge(alpha=penalty, fit_intercept=fit_intercept, solver="svd").fit(x, y)


def samples_needed(features: int, holdout: float) -> int:
    """Count the samples that give a training part no smaller than `features`, and two to test on.

    Parameters
    ----------
    features : int
        Number of weights an output of the readout has.
    holdout : float, in (0, 1)
        Share of the samples that is tested on.

    Returns
    -------
    int
    """
    return max(math.ceil(features / (1 - holdout) - _ROUNDING), math.ceil(2 / holdout))


def predict_held_out(
    states: ArrayLike,
    targets: ArrayLike,
    *,
    holdout: float = 0.5,
    ridge: float = 1e-6,
    fit_intercept: bool = True,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit the readout on the first samples and predict the last ones, which it has never seen.

    The split is contiguous: neighbours in time are not independent, so a shuffled split would leak the test
    part into the training part.

    Parameters
    ----------
    states : array_like of shape (samples, features)
        With the washout already removed.
    targets : array_like of shape (samples,) or (samples, outputs)
        What the readout is to report at the same instants.
    holdout : float, in (0, 1)
        Share of the samples, at the end, that is predicted.
    ridge, fit_intercept
        As in `fit_readout`.

    Returns
    -------
    prediction, target : ndarray of shape (test samples,) or (test samples, outputs)

    Raises
    ------
    ValueError
        If an argument is invalid, or there are fewer training samples than features.
    """
    x = finite_array("states", states, 2)
    y = finite_array("targets", targets, (1, 2))
    holdout = number_within("holdout", holdout, "(0, 1)")
    samples, features = x.shape
    needed = samples_needed(features, holdout)
    if samples < needed:
        raise ValueError(
            f"states must have at least {needed} samples for {features} features and holdout={holdout}, got {samples}"
        )
    train = math.floor((1 - holdout) * samples + _ROUNDING)
    readout = fit_readout(x[:train], y[:train], ridge=ridge, fit_intercept=fit_intercept)
    # scikit-learn drops the axis of a single output.
    return readout.predict(x[train:]).reshape(y[train:].shape), y[train:]
