"""The linear readout: ridge regression from reservoir states to targets."""

import math

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within
from .orthonormal import Array, centre, of_usual_size, repaired, whitening

# A share such as 0.3 is not exact in binary; a count that misses a whole number by this much is that number.
_ROUNDING = 1e-9

RIDGE = 1e-9
"""The penalty unless another is chosen. A score that moves when it is ten times less is one that noise will take."""


def penalty_on_weights(ridge: float, squares: float, features: int) -> float:
    """Penalty on the squared weights, in squared units of the states: what every `ridge` here means.

    ``ridge * squares / features``, the trace of the Gram matrix over its size being the sum of squares of a typical
    feature. So a ridge has no unit, asks for no other value with more samples, and shrinks a weight as noise of that
    share of the states' variance would, in every feature. One factor on all states changes no prediction.

    Parameters
    ----------
    ridge : float, in [0, inf)
    squares : float
        Sum of the squares of all states, centred if there is an intercept.
    features : int

    Returns
    -------
    float
    """
    return ridge * squares / features


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


def ridge_weights(x: Array, y: Array, penalty: float) -> Array:
    """Minimize ``||x W - y||^2 + penalty ||W||^2``.

    Parameters
    ----------
    x : ndarray of shape (samples, features)
        Centred, if there is to be an intercept.
    y : ndarray of shape (samples, outputs)
    penalty : float, in [0, inf)
        In squared units of `x`.

    Returns
    -------
    ndarray of shape (features, outputs)
        Of least norm where `penalty` is zero and several would do.
    """
    white = whitening(x.T @ x)
    if white is not None and white.nine_digits:
        return whitened_weights(white.map, np.eye(x.shape[1]), white.map.T @ (x.T @ y), penalty)
    found = repaired(x, white)
    if white is not None and found is not None:
        columns, triangle = found
        return whitened_weights(white.map, triangle, columns.T @ y, penalty)
    left, singular, right = singular_vectors(x)
    weights: Array = right.T @ ((singular / (singular**2 + penalty))[:, None] * (left.T @ y))
    return weights


def whitened_weights(to_white: Array, triangle: Array, projected: Array, penalty: float) -> Array:
    """Ridge weights by way of nearly orthonormal columns ``Q = x M``, with ``Q^T Q = T^T T``.

    They are M times the least-squares solution of T and sqrt(penalty) M, stacked: a small problem, well conditioned.

    Parameters
    ----------
    to_white : ndarray of shape (features, features)
        M.
    triangle : ndarray of shape (features, features)
        T, upper triangular.
    projected : ndarray of shape (features, outputs)
        Q^T y.
    penalty : float, in [0, inf)
        In squared units of `x`.

    Returns
    -------
    ndarray of shape (features, outputs)
    """
    stacked, factor = scipy.linalg.qr(
        np.vstack([triangle, math.sqrt(penalty) * to_white]), mode="economic", check_finite=False
    )
    target = scipy.linalg.solve_triangular(triangle, projected, trans="T", check_finite=False)
    weights: Array = to_white @ scipy.linalg.solve_triangular(
        factor, stacked[: len(factor)].T @ target, check_finite=False
    )
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
    q, triangle = scipy.linalg.qr(x, mode="economic", check_finite=False)
    left, singular, right = np.linalg.svd(triangle, full_matrices=False)
    kept = singular > np.finfo(np.float64).eps * max(triangle.shape) * singular[0]
    return q @ left[:, kept], singular[kept], right[kept]


def leave_one_out(states: Array, targets: Array, ridge: float, fit_intercept: bool = True) -> Array:
    """Predict every sample by a readout fitted on all the others, in closed form [1]_.

    With the prediction p of the readout fitted on all samples and its leverage h, the diagonal of the matrix that
    maps targets to predictions, the readout fitted without sample k predicts it as ``y - (y - p) / (1 - h)``. The
    penalty on its weights is that of all samples.

    Parameters
    ----------
    states : ndarray of shape (samples, features)
    targets : ndarray of shape (samples, outputs)
    ridge : float, in [0, inf)
        As in `stickslip.reservoir.fit_readout`.
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
    penalty = penalty_on_weights(ridge, np.vecdot(singular, singular), states.shape[1])
    return left_out(left, singular**2 / (singular**2 + penalty), targets - mean, fit_intercept) + mean


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
    ridge: float = RIDGE,
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
        As in `stickslip.reservoir.fit_readout`.

    Returns
    -------
    prediction, target : ndarray of shape (test samples,) or (test samples, outputs)

    Raises
    ------
    ValueError
        If an argument is invalid, or there are fewer training samples than features.
    """
    x, y = states_and_targets(states, targets)
    x = of_usual_size(x)
    holdout = number_within("holdout", holdout, "(0, 1)")
    ridge = number_within("ridge", ridge, "[0, inf)")
    samples, features = x.shape
    needed = samples_needed(features, holdout)
    if samples < needed:
        raise ValueError(
            f"states must have at least {needed} samples for {features} features and holdout={holdout}, got {samples}"
        )
    train = training_samples(samples, holdout)
    weights, constant = affine_weights(x[:train], y[:train].reshape(train, -1), ridge, fit_intercept)
    # Moved before it is multiplied, or the digits of a large offset would cancel after.
    prediction = (x[train:] - x[0]) @ weights + constant
    return prediction.reshape(y[train:].shape), y[train:].copy()


def affine_weights(x: Array, y: Array, ridge: float, fit_intercept: bool) -> tuple[Array, Array]:
    """Weights and constant of the readout ``(x - x[0]) @ weights + constant``.

    Parameters
    ----------
    x : ndarray of shape (samples, features)
    y : ndarray of shape (samples, outputs)
    ridge : float, in [0, inf)
        As in `stickslip.reservoir.fit_readout`.
    fit_intercept : bool
        If not, the readout is linear: its constant is ``x[0] @ weights``.

    Returns
    -------
    weights : ndarray of shape (features, outputs)
    constant : ndarray of shape (outputs,)
    """
    if not fit_intercept:
        weights = ridge_weights(x, y, penalty_on_weights(ridge, float(np.vdot(x, x)), x.shape[1]))
        return weights, x[0] @ weights
    moved, level = centre(x), y.mean(axis=0)
    penalty = penalty_on_weights(ridge, float(np.vdot(moved.states, moved.states)), x.shape[1])
    weights = ridge_weights(moved.states, y - level, penalty)
    return weights, level - moved.mean @ weights


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
