"""A readout that learns sample by sample: recursive least squares.

After every sample its weights are those of the ridge regression over all samples so far, at the cost of one
matrix-vector product. Asked for a prediction before it learns the answer, it scores itself on data it has not
seen: the prequential (predictive sequential) form of a held-out score.

The compiled functions hold the arithmetic; they work in place and allocate nothing, so that other compiled
code can call them at every step. `RecursiveLeastSquares` is the same for everybody else.

References
----------
S. Haykin, "Adaptive Filter Theory", 5th ed., 2014, chapter 10.
A. P. Dawid, "Statistical theory: the prequential approach", J. R. Stat. Soc. A 147, 278, 1984.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within, whole_number
from ..compiling.compilation import compiled

Array = NDArray[np.float64]


@compiled
def predict(weights: Array, features: Array, prediction: Array) -> None:
    """Write ``weights @ features`` into `prediction`.

    Parameters
    ----------
    weights : ndarray of shape (outputs, features)
    features : ndarray of shape (features,)
    prediction : ndarray of shape (outputs,)
        Overwritten.
    """
    for output in range(weights.shape[0]):
        total = 0.0
        for i in range(features.size):
            total += weights[output, i] * features[i]
        prediction[output] = total


@compiled
def predict_then_learn(
    weights: Array,
    covariance: Array,
    features: Array,
    targets: Array,
    forgetting: float,
    prediction: Array,
    gain: Array,
) -> None:
    """Predict the targets from the features, then learn them, in place.

    With features x, targets y, forgetting f and covariance P::

        g = P x / (f + x^T P x),   W <- W + (y - W x) g^T,   P <- (P - g (P x)^T) / f

    Rounding treats P[i, j] and P[j, i] alike, so a P that starts symmetric stays so to the last digit: its slow
    loss of symmetry is what makes textbook implementations blow up.

    Parameters
    ----------
    weights : ndarray of shape (outputs, features)
        Updated. Start from zeros.
    covariance : ndarray of shape (features, features)
        Updated. Start from the identity over the ridge penalty.
    features : ndarray of shape (features,)
    targets : ndarray of shape (outputs,)
    forgetting : float, in (0, 1]
        Factor by which a sample's influence shrinks with each later one.
    prediction : ndarray of shape (outputs,)
        Overwritten with the prediction made before learning.
    gain : ndarray of shape (features,)
        Scratch.
    """
    size = features.size
    predict(weights, features, prediction)
    # Row by row rather than by dot products, since sums over j cannot be vectorized without changing their order.
    gain[:] = 0.0
    for i in range(size):
        for j in range(size):
            gain[j] += features[i] * covariance[i, j]
    spread = forgetting
    for i in range(size):
        spread += features[i] * gain[i]
    shrink = 1.0 / spread
    for output in range(weights.shape[0]):
        step = (targets[output] - prediction[output]) * shrink
        for i in range(size):
            weights[output, i] += step * gain[i]
    grow = 1.0 / forgetting
    for i in range(size):
        for j in range(size):
            covariance[i, j] = (covariance[i, j] - gain[i] * gain[j] * shrink) * grow


class RecursiveLeastSquares:
    """Linear readout without intercept, learned one sample at a time.

    With ``forgetting=1`` the weights after any number of samples are those of ridge regression on them without
    intercept, the penalty on the squared weights being ``ridge * scale**2``.

    With ``forgetting=f < 1`` the penalty would be forgotten too, and where features stop varying in some direction, as
    collinear ones do, the covariance would grow without end until rounding decides. So the share 1 - f of it that is
    lost at every step is given back, to one feature after the other: with N features one learns at each step that its
    weight is 0, as from a sample ``sqrt((1 - f) N ridge) * scale`` of it alone. This is cyclic resetting [1]_. The
    covariance stays below ``1 / (f^N ridge scale^2)`` for ever.

    Parameters
    ----------
    features : int
        Number of features; append a constant one for an intercept.
    outputs : int
        Number of targets learned side by side.
    ridge : float, in (0, inf)
        Number of samples that the penalty on the squared weights weighs as much as. Larger learns more cautiously from
        the first samples.
    forgetting : float, in (0, 1]
        Factor by which a sample's influence shrinks with each later one: about 1 / (1 - forgetting) samples
        count.
    scale : float, in (0, inf), optional
        Size of a typical feature. By default the root mean square over the features of the first sample that is not
        zero, so that their unit does not matter.

    Attributes
    ----------
    weights : ndarray of shape (outputs, features)
    covariance : ndarray of shape (features, features)
        Inverse of the (forgotten) sum of squared features plus the penalty; until the scale is known, that of a
        scale of 1.
    scale : float or None
        None until it is known.

    Raises
    ------
    TypeError
        If a size is not an integer.
    ValueError
        If an argument is out of range.

    References
    ----------
    .. [1] B. Lai and D. S. Bernstein, "Exponential resetting and cyclic resetting recursive least squares", IEEE
       Control Systems Letters 7, 985, 2023.
    """

    def __init__(
        self,
        features: int,
        outputs: int,
        *,
        ridge: float = 1.0,
        forgetting: float = 1.0,
        scale: float | None = None,
    ) -> None:
        features = whole_number("features", features, 1)
        outputs = whole_number("outputs", outputs, 1)
        self.ridge = number_within("ridge", ridge, "(0, inf)")
        self.forgetting = number_within("forgetting", forgetting, "(0, 1]")
        self.scale = None if scale is None else number_within("scale", scale, "(0, inf)")
        self.weights = np.zeros((outputs, features))
        self.covariance = np.eye(features) / (self.ridge * (self.scale or 1.0) ** 2)
        self._gain = np.empty(features)
        self._renewed = 0

    def predict(self, features: ArrayLike) -> Array:
        """Predict the targets.

        Parameters
        ----------
        features : array_like of shape (features,)

        Returns
        -------
        ndarray of shape (outputs,)

        Raises
        ------
        ValueError
            If `features` has another shape or is not finite.
        """
        return self.weights @ _vector("features", features, self.weights.shape[1])

    def learn(self, features: ArrayLike, targets: ArrayLike) -> Array:
        """Learn one sample, and return what was predicted for it before.

        Parameters
        ----------
        features : array_like of shape (features,)
        targets : array_like of shape (outputs,)

        Returns
        -------
        ndarray of shape (outputs,)
            The prediction made before `targets` was learned.

        Raises
        ------
        ValueError
            If an array has another shape or is not finite; nothing is learned then.
        """
        outputs, size = self.weights.shape
        x, y = _vector("features", features, size), _vector("targets", targets, outputs)
        prediction = np.zeros(outputs)
        if self.scale is None:
            if not x.any():
                # Nothing is learned from a zero, and there is no scale to begin with.
                return prediction
            self.scale = float(np.linalg.norm(x) / np.sqrt(size))
            self.covariance /= self.scale**2
        predict_then_learn(self.weights, self.covariance, x, y, self.forgetting, prediction, self._gain)
        if self.forgetting < 1:
            self._renew_the_penalty()
        return prediction

    def _renew_the_penalty(self) -> None:
        outputs, size = self.weights.shape
        one = np.zeros(size)
        one[self._renewed] = np.sqrt((1 - self.forgetting) * size * self.ridge) * (self.scale or 1.0)
        self._renewed = (self._renewed + 1) % size
        nothing = np.zeros(outputs)
        predict_then_learn(self.weights, self.covariance, one, nothing, 1.0, np.empty(outputs), self._gain)


def _vector(name: str, value: ArrayLike, size: int) -> Array:
    vector = finite_array(name, value, 1)
    if vector.size != size:
        raise ValueError(f"{name} must have shape ({size},), got {vector.shape}")
    return vector
