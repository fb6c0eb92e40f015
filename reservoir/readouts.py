"""Readouts as scikit-learn estimators: for pipelines, grid searches and cross-validation.

Importing this module imports scikit-learn, which takes a second; `stickslip.reservoir` does so when they are asked for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from ..common.validation import finite_array, number_within
from .orthonormal import centre, of_usual_size
from .recursive_least_squares import RecursiveLeastSquares
from .ridge import affine_weights, penalty_on_weights, RIDGE, singular_vectors, states_and_targets

Array = NDArray[np.float64]

# Penalties tried by default: from the square of the states' rounding, below which no direction is kept, up to where
# hardly anything is left even of the largest direction of a hundred features.
_PENALTIES = np.logspace(-30, 2, 33)


class RidgeReadout(MultiOutputMixin, RegressorMixin, BaseEstimator):
    """Ridge regression that keeps its digits on nearly collinear states, and can choose its penalty.

    The penalty is chosen by the mean squared error of leave-one-out predictions, in closed form: all candidates cost
    one singular value decomposition. scikit-learn's ``RidgeCV`` does the same; this one is never solved through the
    Gram matrix, takes penalties relative to the states, so that their unit does not matter, and guards against a
    leverage of 1.

    Parameters
    ----------
    penalty : float, sequence of float or None
        Penalty on the squared weights, or candidates for it, relative to the sum of squares of a typical feature as in
        `fit_readout`. None tries the powers of ten from 1e-30 to 100.
    fit_intercept : bool
        Whether to learn an unpenalized constant beside the weights.
    per_output : bool
        Whether each output gets a penalty of its own.

    Attributes
    ----------
    coef_ : ndarray of shape (features,) or (outputs, features)
    intercept_ : float or ndarray of shape (outputs,)
    penalty_ : float or ndarray of shape (outputs,)
        The penalty that was used, relative like `penalty`.
    leave_one_out_error_ : ndarray of shape (candidates, outputs)
        Mean squared error of each candidate; only if there was a choice.
    candidates_ : ndarray of shape (candidates,)
        Likewise.
    n_features_in_ : int

    Notes
    -----
    States of one run are no independent samples. Where they are correlated for longer than their targets, as
    in capacities of random input, leaving out one sample is fair; for targets that vary slowly its neighbours give it
    away, and ``GridSearchCV`` with ``TimeSeriesSplit`` over `penalty` is the honest choice.
    """

    def __init__(
        self, penalty: float | Sequence[float] | None = None, *, fit_intercept: bool = True, per_output: bool = False
    ) -> None:
        self.penalty = penalty
        self.fit_intercept = fit_intercept
        self.per_output = per_output

    def fit(self, X: ArrayLike, y: ArrayLike) -> RidgeReadout:
        """Learn the weights.

        Parameters
        ----------
        X : array_like of shape (samples, features)
        y : array_like of shape (samples,) or (samples, outputs)

        Returns
        -------
        RidgeReadout
            Itself.

        Raises
        ------
        ValueError
            If an array has a wrong shape or is not finite, or a penalty is negative.
        """
        x, targets = validate_data(self, X, y, multi_output=True, y_numeric=True, dtype=np.float64)
        columns = np.asarray(targets, dtype=np.float64).reshape(len(x), -1)
        x = of_usual_size(unscaled := x)
        single = self.penalty is not None and np.ndim(self.penalty) == 0
        weights, constant, penalty = self._fit_one(x, columns) if single else self._fit_best(x, columns)
        coefficients, intercept = weights.T, constant - x[0] @ weights
        if x is not unscaled:
            coefficients = coefficients * (np.abs(x).max() / np.abs(unscaled).max())
        # As in scikit-learn, the axis of a single output that was given without one is dropped.
        flat = targets.ndim == 1
        self.coef_ = coefficients[0] if flat else coefficients
        self.intercept_ = 0.0 if not self.fit_intercept else intercept[0] if flat else intercept
        self.penalty_ = penalty
        self._origin, self._constant = unscaled[0].copy(), constant
        return self

    def predict(self, X: ArrayLike) -> Array:
        """Predict the targets.

        Parameters
        ----------
        X : array_like of shape (samples, features)

        Returns
        -------
        ndarray of shape (samples,) or (samples, outputs)
        """
        check_is_fitted(self)
        x = validate_data(self, X, reset=False, dtype=np.float64)
        weights = np.atleast_2d(self.coef_).T
        # Moved before it is multiplied, or the digits of a large offset would cancel after.
        prediction = (x - self._origin) @ weights + self._constant
        return prediction[:, 0] if self.coef_.ndim == 1 else prediction

    def _fit_one(self, x: Array, y: Array) -> tuple[Array, Array, float]:
        penalty = number_within("penalty", self.penalty, "[0, inf)")
        weights, constant = affine_weights(x, y, penalty, self.fit_intercept)
        return weights, constant, penalty

    def _fit_best(self, x: Array, y: Array) -> tuple[Array, Array, float | Array]:
        offset = centre(x) if self.fit_intercept else None
        level = y.mean(axis=0) if self.fit_intercept else np.zeros(y.shape[1])
        left, singular, right = singular_vectors(x if offset is None else offset.states)
        self.candidates_ = self._candidates()
        penalties = self.candidates_ * penalty_on_weights(1.0, np.vecdot(singular, singular), x.shape[1])
        self.leave_one_out_error_ = _leave_one_out_errors(left, singular, y - level, penalties, self.fit_intercept)
        error = self.leave_one_out_error_
        if not np.isfinite(error).any(axis=0).all():
            raise ValueError(
                f"penalty must leave an error that is finite with {len(x)} samples of {x.shape[1]} features, "
                f"got candidates {self.candidates_}"
            )
        best = np.nanargmin(error, axis=0) if self.per_output else np.full(y.shape[1], np.nanargmin(error.sum(axis=1)))
        chosen = self.candidates_[best]
        shrunk = singular[:, None] / (singular[:, None] ** 2 + penalties[best])
        weights = right.T @ (shrunk * (left.T @ (y - level)))
        constant = x[0] @ weights if offset is None else level - offset.mean @ weights
        return weights, constant, chosen if self.per_output else float(chosen[0])

    def _candidates(self) -> Array:
        if self.penalty is None:
            return _PENALTIES.copy()
        candidates = finite_array("penalty", self.penalty, 1).copy()
        if candidates.min() < 0:
            raise ValueError(f"penalty must hold numbers in [0, inf), got {candidates.min()}")
        return candidates


def fit_readout(
    states: ArrayLike, targets: ArrayLike, *, ridge: float = RIDGE, fit_intercept: bool = True
) -> RidgeReadout:
    """Fit one readout for all targets in a single solve.

    Without an intercept this is equation (11) of the paper, with the N states R and the targets Y as columns::

        W_out = Y R^T (R R^T + ridge tr(R R^T) / N I)^-1

    R R^T squares the condition number, and states sampled within one hold of the valve are close to collinear, so
    it is solved in an orthonormal basis of the states.

    Parameters
    ----------
    states : array_like of shape (samples, features)
        Row k is the state after input k was absorbed.
    targets : array_like of shape (samples,) or (samples, outputs)
        What the readout is to report at the same instants.
    ridge : float, in [0, inf)
        Penalty on the squared weights, relative to the sum of squares of a typical feature (of its deviations, with an
        intercept): see `stickslip.reservoir.ridge.penalty_on_weights`. Zero gives the least-squares solution of least
        norm.
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
    x, y = states_and_targets(states, targets)
    penalty = number_within("ridge", ridge, "[0, inf)")
    return RidgeReadout(penalty, fit_intercept=fit_intercept).fit(x, y)


class RecursiveLeastSquaresReadout(MultiOutputMixin, RegressorMixin, BaseEstimator):
    """Recursive least squares: a ridge readout that learns one sample after the other.

    Without forgetting it is ridge regression on all samples so far, with the constant as a feature of a typical size
    like any other, and so penalized too. The arithmetic is that of `RecursiveLeastSquares`, the readout of the
    environment's reward.

    Parameters
    ----------
    ridge : float, in (0, inf)
        Penalty on the squared weights: the number of samples that it weighs as much as, each of the root mean square
        of the samples that were learned first.
    forgetting : float, in (0, 1]
        Factor by which a sample's influence shrinks with each later one.
    fit_intercept : bool
        Whether to learn a constant beside the weights.

    Attributes
    ----------
    coef_ : ndarray of shape (features,) or (outputs, features)
    intercept_ : float or ndarray of shape (outputs,)
    n_features_in_ : int
    """

    def __init__(self, ridge: float = 1.0, *, forgetting: float = 1.0, fit_intercept: bool = True) -> None:
        self.ridge = ridge
        self.forgetting = forgetting
        self.fit_intercept = fit_intercept

    def fit(self, X: ArrayLike, y: ArrayLike) -> RecursiveLeastSquaresReadout:
        """Forget all, then learn these samples in their order.

        Parameters
        ----------
        X : array_like of shape (samples, features)
        y : array_like of shape (samples,) or (samples, outputs)

        Returns
        -------
        RecursiveLeastSquaresReadout
            Itself.
        """
        return self._learn(X, y, fresh=True)

    def partial_fit(self, X: ArrayLike, y: ArrayLike) -> RecursiveLeastSquaresReadout:
        """Learn more samples, in their order.

        Parameters
        ----------
        X : array_like of shape (samples, features)
        y : array_like of shape (samples,) or (samples, outputs)

        Returns
        -------
        RecursiveLeastSquaresReadout
            Itself.
        """
        return self._learn(X, y, fresh=not hasattr(self, "_readout"))

    def predict(self, X: ArrayLike) -> Array:
        """Predict the targets.

        Parameters
        ----------
        X : array_like of shape (samples, features)

        Returns
        -------
        ndarray of shape (samples,) or (samples, outputs)
        """
        check_is_fitted(self)
        x = validate_data(self, X, reset=False, dtype=np.float64)
        prediction = self._features(x) @ self._readout.weights.T
        return prediction[:, 0] if self.coef_.ndim == 1 else prediction

    def _learn(self, X: ArrayLike, y: ArrayLike, fresh: bool) -> RecursiveLeastSquaresReadout:
        x, targets = validate_data(self, X, y, reset=fresh, multi_output=True, y_numeric=True, dtype=np.float64)
        if fresh:
            self._scale = float(np.sqrt(np.mean(x**2))) or 1.0
        features = self._features(x)
        columns = np.asarray(targets, dtype=np.float64).reshape(len(x), -1)
        if fresh:
            self._readout = RecursiveLeastSquares(
                features.shape[1], columns.shape[1], ridge=self.ridge, forgetting=self.forgetting, scale=self._scale
            )
        for row, target in zip(features, columns, strict=True):
            self._readout.learn(row, target)
        weights = self._readout.weights
        coefficients = weights[:, : x.shape[1]]
        intercept = self._scale * weights[:, -1] if self.fit_intercept else np.zeros(len(weights))
        flat = targets.ndim == 1
        self.coef_ = coefficients[0].copy() if flat else coefficients.copy()
        self.intercept_ = float(intercept[0]) if flat else intercept.copy()
        return self

    def _features(self, x: Array) -> Array:
        return np.column_stack([x, np.full(len(x), self._scale)]) if self.fit_intercept else x


def _leave_one_out_errors(left: Array, singular: Array, targets: Array, penalties: Array, fit_intercept: bool) -> Array:
    """Mean squared errors as in `left_out`, all penalties at once, shape (penalties, outputs)."""
    squares = (singular**2)[:, None]
    # Shares of each direction that the penalties leave: a penalty of 0 leaves all, since no direction is of length 0.
    kept = squares / (squares + penalties)
    alone = 1 - left**2 @ kept - (1 / len(left) if fit_intercept else 0)
    errors = np.empty((len(penalties), targets.shape[1]))
    with np.errstate(divide="ignore", invalid="ignore"):
        for output, target in enumerate(targets.T):
            missed = (target[:, None] - left @ (kept * (left.T @ target)[:, None])) / alone
            errors[:, output] = np.einsum("ij,ij->j", missed, missed) / len(missed)
    return errors
