r"""Memory capacity as a running score: predict the message of d steps ago, then learn it.

The message is the innovation, or another target that is made of the innovations (`stickslip.reservoir.targets`).

Step k earns, for every delay d,

.. math:: \left(e^2 - \frac{(e - \hat e)^2}{1 + h_d}\right) / \mathrm{Var}\,e, \qquad e = e_{k-d},

where :math:`\hat e` is predicted from the state before e is learned, so that the mean tends to the memory capacity of
the readout. The score is honest at every step: a prediction that is worse than none costs.

A readout of N weights that starts knowing nothing has prediction errors that are larger than those of the best readout,
by what its weights still lack. For least squares that is known: the square of the error exceeds the best readout's by
the factor 1 + h, the leverage h of a state x being :math:`x^T P x` with P the inverse of the sum of squared features.
Errors divided by its root are the recursive residuals of [1]_, whose variance does not depend on the sample; without
the division an episode of 1000 steps hides a sixth of the capacity at the environment's defaults. The weights of delay
d have learned from all but the first d of the k samples, while P is that of all k: :math:`h_d = h (k - d) / k`.

Where h exceeds 1 there are hardly more samples than weights in the state's direction, and nothing is known of the
error. Such a step counts for less, and for nothing from h = 2. Leverages cannot be large for long: the sum of
log(1 + h) over all steps is the logarithm of the growth of det P^-1, so that no policy can live on them.

References
----------
.. [1] R. L. Brown, J. Durbin, J. M. Evans, "Techniques for testing the constancy of regression relationships over
   time", J. R. Stat. Soc. B 37, 149, 1975.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within, whole_number
from ..compiling.compilation import compiled
from .recursive_least_squares import predict_then_learn
from .targets import aimed, itself, LONGEST, Target

__all__ = ["RIDGE", "PrequentialMemory"]

RIDGE = 1e-3
"""Penalty on the squared weights, that of a thousandth of a sample in each direction: virtual nodes of one pressure are
affine in each other, and a direction in which nothing was seen must not be learned from rounding."""

_CENTRE, _SCALE, _FEATURES, _GAIN = range(4)


class PrequentialMemory:
    """A running estimate of memory capacity.

    Parameters
    ----------
    states : (samples, features) array_like
        Of a calibration run; they set the centre and the scale of each feature, and nothing else.
    delays : int, >= 1
        Delays 0 to delays - 1 are read out.
    variance : float, > 0
        Var e of the message.
    target : Target, optional
        What is to be told of the innovations, with its own variance; by default they themselves.

    Attributes
    ----------
    centre, scale : (features,) arrays
        A feature is (state - centre) * scale.
    delays : int
    variance : float
    target : Target
    arrays : tuple of arrays
        Of the readout as it is: what `score` takes first.

    Raises
    ------
    ValueError, TypeError
        If an argument has the wrong shape or is out of range; the message names it.
    """

    def __init__(self, states: ArrayLike, delays: int, *, variance: float = 1.0, target: Target | None = None) -> None:
        states = finite_array("states", states, 2)
        self.delays = whole_number("delays", delays, 1)
        variance = number_within("variance", variance, "(0, inf)")
        self.target = target or itself(variance)
        self.variance = self.target.variance
        self.centre = states.mean(axis=0)
        spread = states.std(axis=0)
        self.scale = 1.0 / np.where(spread > 0.0, spread, 1.0)
        self._rows = np.zeros((4, states.shape[1] + 1))
        self._rows[_CENTRE, :-1] = self.centre
        self._rows[_SCALE, :-1] = self.scale
        self.reset()

    def reset(self) -> None:
        """Forget all that was scored."""
        size = self._rows.shape[1]
        # Whoever remembers the innovations themselves keeps nothing beside them.
        history = np.zeros((4, max(self.delays, LONGEST)) if self.target.kind else (2, self.delays))
        self.arrays = np.zeros((self.delays, size)), np.eye(size) / RIDGE, history, self._rows
        self._seen = 0

    def packed(self) -> tuple[NDArray[np.float64], ...]:
        """Copies of weights, of the lower half of the covariance by rows, and of past messages, newest first.

        Of what a target other than memory is made of too, as `aimed` has it.
        """
        weights, covariance, history, _ = self.arrays
        kept = weights.copy(), covariance[np.tril_indices(len(covariance))], history[0, : self.delays].copy()
        return (*kept, history[2:, :LONGEST].copy()) if self.target.kind else kept

    def unpack(self, packed: tuple[NDArray[np.float64], ...], seen: int) -> None:
        """Go on from what `packed` returned after `seen` samples."""
        self.reset()
        weights, covariance, history, _ = self.arrays
        weights[:], half, history[0, : self.delays], *recent = packed
        if recent:
            history[2:, :LONGEST] = recent[0]
        rows, columns = np.tril_indices(len(covariance))
        covariance[rows, columns] = covariance[columns, rows] = half
        self._seen = seen

    def score(self, state: NDArray[np.float64], innovation: float) -> float:
        """Take in one sample and return what it earned.

        Parameters
        ----------
        state : (features,) array
            After the innovation's input has been absorbed.
        innovation : float

        Returns
        -------
        float
            Its mean over many samples tends to the memory capacity.
        """
        self._seen += 1
        kind, order, mean, variance, lead, _ = self.target
        message = aimed(kind, order, mean, self.arrays[2][2:], innovation)
        return score(*self.arrays, self._seen, lead, state[np.newaxis], message, variance)


@compiled
def score(
    weights: NDArray[np.float64],
    covariance: NDArray[np.float64],
    history: NDArray[np.float64],
    rows: NDArray[np.float64],
    seen: int,
    lead: int,
    states: NDArray[np.float64],
    message: float,
    variance: float,
) -> float:
    """Score one sample and learn it, in place.

    Few arrays, because each costs a quarter of a microsecond to hand over from Python.

    Parameters
    ----------
    weights, covariance : (delays, features + 1) and (features + 1, features + 1) arrays
        Of the readout; the last feature is the constant 1.
    history : (>= 2, >= delays) array
        Messages, newest first, and their predictions.
    rows : (4, features + 1) array
        The centre and scale of each feature, (state - centre) * scale, then two rows of scratch.
    seen : int
        Samples so far with this one: messages from before the first are neither scored nor learned.
    lead : int
        Of those, how many came before the first message.
    states : (readings, instants) array
        The features, row by row; rows beyond them do not count.
    message : float
    variance : float
        Of the message.
    """
    features, gain = rows[_FEATURES], rows[_GAIN]
    size = len(features) - 1
    instants = states.shape[1]
    for reading in range(size // instants):
        for instant in range(instants):
            i = reading * instants + instant
            features[i] = (states[reading, instant] - rows[_CENTRE, i]) * rows[_SCALE, i]
    features[size] = 1.0
    past, prediction = history[0], history[1]
    delays = len(weights)
    for d in range(delays - 1, 0, -1):
        past[d] = past[d - 1]
    past[0] = message
    known = max(min(seen - lead, delays), 0)
    predict_then_learn(weights[:known], covariance, features, past[:known], 1.0, prediction[:known], gain)
    uncertainty = 1.0
    for i in range(size + 1):
        uncertainty += features[i] * gain[i]
    leverage = uncertainty - 1.0
    earned = 0.0
    for d in range(known):
        error = past[d] - prediction[d]
        share = (float(seen - lead) - float(d)) / float(seen)
        earned += past[d] * past[d] - error * error / (1.0 + leverage * share)
    certainty = min(max(2.0 - leverage, 0.0), 1.0)
    return certainty * earned / variance
