"""The linear readout: ridge regression from reservoir states to targets."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import qr, solve_triangular

from ..validation import finite_array, number_within
from .orthonormal import Array, centre, whiten, Whitening

if TYPE_CHECKING:
    from .readouts import RidgeReadout

# A share such as 0.3 is not exact in binary; a count that misses a whole number by this much is that number.
_ROUNDING = 1e-9


def fit_readout(
    states: ArrayLike, targets: ArrayLike, *, ridge: float = 1e-6, fit_intercept: bool = True
) -> RidgeReadout:
    """Fit one readout for all targets in a single solve.

    Without an intercept this is equation (11) of the paper, with the states R and the targets Y as columns::

        W_out = Y R^T (R R^T + ridge I)^-1

    R R^T squares the condition number, and states sampled within one hold of the valve are close to collinear, so
    it is solved in an orthonormal basis of the states.

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
    RidgeReadout
        Fitted; ``coef_`` is W_out, of shape (outputs, features), or (features,) for a single output.

    Raises
    ------
    ValueError
        If an array has a wrong shape or is not finite, the lengths differ, or `ridge` is out of range.
    """
    # Imported here because scikit-learn takes a second, and whoever only steps an environment needs none of it.
    from .readouts import RidgeReadout

    x, y = states_and_targets(states, targets)
    penalty = number_within("ridge", ridge, "[0, inf)")
    return RidgeReadout(penalty, fit_intercept=fit_intercept).fit(x, y)


def states_and_targets(states: ArrayLike, targets: ArrayLike) -> tuple[Array, Array]:
    """Convert to arrays of one length, or refuse.

    Parameters
    ----------
    states : array_like of shape (samples, features)
    targets : array_like of shape (samples,) or (samples, outputs)

    Returns
    -------
    states, targets : ndarray of float64

    Raises
    ------
    ValueError
        If an array has a wrong shape or is not finite, or the lengths differ.
    """
    x = finite_array("states", states, 2)
    y = finite_array("targets", targets, (1, 2))
    if len(x) != len(y):
        raise ValueError(f"targets must have as many samples as states, {len(x)}, got {len(y)}")
    return x, y


def ridge_weights(x: Array, white: Whitening | None, y: Array, ridge: float) -> Array:
    """Minimize ``||x W - y||^2 + ridge ||W||^2``.

    Where columns Q = x M are nearly orthonormal, with Q^T Q = T^T T, the least squares of T and sqrt(ridge) M stacked
    are the answer: they are small and well conditioned. Where there is no such M, the singular values of x are taken.

    Parameters
    ----------
    x : ndarray of shape (samples, features)
        Centred, if there is to be an intercept.
    white : Whitening or None
        Of `x`.
    y : ndarray of shape (samples, outputs)
    ridge : float, in [0, inf)

    Returns
    -------
    ndarray of shape (features, outputs)
        Of least norm where `ridge` is zero and several would do.
    """
    if white is None:
        left, singular, right = singular_vectors(x)
        return right.T @ ((singular / (singular**2 + ridge))[:, None] * (left.T @ y))
    projected = solve_triangular(white.triangle, white.project(x, y), trans="T", check_finite=False)
    stacked, triangle = qr(np.vstack([white.triangle, math.sqrt(ridge) * white.map]), mode="economic")
    weights: Array = white.map @ solve_triangular(triangle, stacked[: len(triangle)].T @ projected, check_finite=False)
    return weights


def singular_vectors(x: Array) -> tuple[Array, Array, Array]:
    """Decompose ``x = left * singular @ right`` without the directions that are its rounding.

    Parameters
    ----------
    x : ndarray of shape (samples, features)

    Returns
    -------
    left : ndarray of shape (samples, rank)
    singular : ndarray of shape (rank,)
    right : ndarray of shape (rank, features)
    """
    q, triangle = qr(x, mode="economic", check_finite=False)
    left, singular, right = np.linalg.svd(triangle, full_matrices=False)
    kept = singular > np.finfo(np.float64).eps * max(triangle.shape) * singular[0]
    return q @ left[:, kept], singular[kept], right[kept]


def leave_one_out(states: Array, targets: Array, ridge: float, fit_intercept: bool = True) -> Array:
    """Predict every sample by a readout fitted on all the others, in closed form [1]_.

    With the prediction p of the readout fitted on all samples and its leverage h, the diagonal of the matrix that
    maps targets to predictions, the readout fitted without sample k predicts it as ``y - (y - p) / (1 - h)``.

    Parameters
    ----------
    states : ndarray of shape (samples, features)
    targets : ndarray of shape (samples, outputs)
    ridge : float, in [0, inf)
    fit_intercept : bool

    Returns
    -------
    ndarray of shape (samples, outputs)
        Not a number, or infinite, where a sample is alone in some direction and nothing is penalized.

    References
    ----------
    .. [1] R. D. Cook, "Detection of influential observation in linear regression", Technometrics 19, 15, 1977.
    """
    left, singular, _ = singular_vectors(centre(states).states if fit_intercept else states)
    mean = targets.mean(axis=0) if fit_intercept else 0.0
    return left_out(left, singular**2 / (singular**2 + ridge), targets - mean, fit_intercept) + mean


def left_out(left: Array, kept: Array, targets: Array, fit_intercept: bool) -> Array:
    """Leave-one-out predictions from singular vectors.

    Parameters
    ----------
    left : ndarray of shape (samples, rank)
        Left singular vectors of the states, which are centred if there is an intercept.
    kept : ndarray of shape (rank,)
        Share of each direction that the penalty leaves.
    targets : ndarray of shape (samples, outputs)
        Centred if there is an intercept.
    fit_intercept : bool

    Returns
    -------
    ndarray of shape (samples, outputs)
    """
    residual = targets - left @ (kept[:, None] * (left.T @ targets))
    alone = 1 - left**2 @ kept - (1 / len(left) if fit_intercept else 0)
    return targets - residual / alone[:, None]


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
    x, y = states_and_targets(states, targets)
    holdout = number_within("holdout", holdout, "(0, 1)")
    penalty = number_within("ridge", ridge, "[0, inf)")
    samples, features = x.shape
    needed = samples_needed(features, holdout)
    if samples < needed:
        raise ValueError(
            f"states must have at least {needed} samples for {features} features and holdout={holdout}, got {samples}"
        )
    train = training_samples(samples, holdout)
    targets_in_columns = y[:train].reshape(train, -1)
    level = targets_in_columns.mean(axis=0) if fit_intercept else np.zeros(targets_in_columns.shape[1])
    prediction, _ = predict_rest(x, targets_in_columns - level, penalty, fit_intercept)
    return (prediction.T + level).reshape(y[train:].shape), y[train:]


def training_samples(samples: int, holdout: float) -> int:
    """Count the samples that are not held out.

    Parameters
    ----------
    samples : int
    holdout : float, in (0, 1)

    Returns
    -------
    int
    """
    return math.floor((1 - holdout) * samples + _ROUNDING)


def predict_rest(
    states: Array, targets: Array, ridge: float, fit_intercept: bool
) -> tuple[Array, Whitening | None]:
    """Fit on as many first samples as there are targets, and predict the others.

    Parameters
    ----------
    states : ndarray of shape (samples, features)
    targets : ndarray of shape (training samples, outputs)
        Their means are small beside their spread, and are left out of the prediction.
    ridge : float, in [0, inf)
    fit_intercept : bool

    Returns
    -------
    prediction : ndarray of shape (outputs, samples - training samples)
    white : Whitening or None
        Of the states that were fitted, centred if there is an intercept.
    """
    seen, rest = states[: len(targets)], states[len(targets) :]
    if not fit_intercept:
        white = whiten(seen)
        return ridge_weights(seen, white, targets, ridge).T @ rest.T, white
    moved = centre(seen)
    white = whiten(moved.states)
    weights = ridge_weights(moved.states, white, targets, ridge)
    # Moved before it is multiplied, or the digits of a large offset would cancel after.
    prediction = weights.T @ (rest - moved.origin).T
    prediction -= (moved.mean @ weights)[:, None]
    return prediction, white
