"""Memory capacity as a running score: predict the message of d steps ago, then learn it.

Step k earns sum_d (e^2 - (e - ehat)^2) / Var e with e = e_{k-d} and ehat predicted from the state before e is
learned, so that its mean tends to the memory capacity of the readout. The score is honest at every step: a
prediction that is worse than none costs.

A readout that starts knowing nothing pays for its ignorance, which over an episode of 1000 steps hides a quarter of the
capacity. This one starts as if it had already seen a few samples of a calibration run;
`benchmarks/memory_reward.py` measures what that is worth.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..compilation import compiled
from ..validation import finite_array, number_within, whole_number
from .recursive_least_squares import predict_then_learn

__all__ = ["PrequentialMemory"]

# Least eigenvalue granted to the features' correlation. Virtual nodes of one pressure are affine in each other, and a
# direction in which nothing was seen must not be learned from rounding.
_RIDGE = 1e-4
_CENTRE, _SCALE, _FEATURES, _GAIN = range(4)


class PrequentialMemory:
    """A running estimate of memory capacity.

    Parameters
    ----------
    states : (samples, features) array_like
        Of a calibration run; they set the scale of each feature and where the readout starts.
    message : (samples,) array_like
        Innovations of the calibration run.
    delays : int, >= 1
        Delays 0 to delays - 1 are read out.
    variance : float, > 0
        Var e of the message.
    weight : float, > 0
        Samples that the calibration run counts for.

    Attributes
    ----------
    first_weights : (delays, features + 1) array
        Where the readout starts; the last feature is the constant 1.
    first_covariance : (features + 1, features + 1) array
    centre, scale : (features,) arrays
        A feature is (state - centre) * scale.
    variance : float

    Raises
    ------
    ValueError, TypeError
        If an argument has the wrong shape or is out of range; the message names it.
    """

    def __init__(
        self, states: ArrayLike, message: ArrayLike, delays: int, *, variance: float, weight: float = 30.0
    ) -> None:
        states = finite_array("states", states, 2)
        message = finite_array("message", message, 1)
        delays = whole_number("delays", delays, 1)
        if len(states) != len(message) or len(states) <= delays:
            raise ValueError(
                f"states and message must have one length above delays = {delays}, got {len(states)} and {len(message)}"
            )
        self.variance = number_within("variance", variance, "(0, inf)")
        weight = number_within("weight", weight, "(0, inf)")
        centre = states.mean(axis=0)
        spread = states.std(axis=0)
        self.centre = centre
        self.scale = 1.0 / np.where(spread > 0.0, spread, 1.0)

        features = np.column_stack([(states - centre) * self.scale, np.ones(len(states))])[delays - 1 :]
        past = np.lib.stride_tricks.sliding_window_view(message, delays)[:, ::-1]
        correlation = features.T @ features / len(features) + _RIDGE * np.eye(features.shape[1])
        covariance = np.linalg.inv(weight * correlation)
        self.first_covariance = (covariance + covariance.T) / 2.0  # to the last digit, see `predict_then_learn`
        self.first_weights = np.ascontiguousarray(np.linalg.solve(correlation, features.T @ past / len(features)).T)

        self._rows = np.zeros((4, features.shape[1]))
        self._rows[_CENTRE, :-1] = centre
        self._rows[_SCALE, :-1] = self.scale
        self.reset()

    def reset(self) -> None:
        """Forget all but the calibration run."""
        self._weights = self.first_weights.copy()
        self._covariance = self.first_covariance.copy()
        self._history = np.zeros((2, self.first_weights.shape[0]))
        self._seen = 0

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
        return score(
            self._weights,
            self._covariance,
            self._history,
            self._seen,
            state,
            innovation,
            self._rows,
            self.variance,
        )


@compiled
def score(
    weights: NDArray[np.float64],
    covariance: NDArray[np.float64],
    history: NDArray[np.float64],
    seen: int,
    state: NDArray[np.float64],
    innovation: float,
    rows: NDArray[np.float64],
    variance: float,
) -> float:
    """Score one sample and learn it, in place.

    Few arrays, because each costs a quarter of a microsecond to hand over from Python.

    Parameters
    ----------
    weights, covariance : (delays, features + 1) and (features + 1, features + 1) arrays
        Of the readout; the last feature is the constant 1.
    history : (2, delays) array
        Innovations, newest first, and their predictions.
    seen : int
        Samples so far with this one: messages from before the first are neither scored nor learned.
    state : (features,) array
    innovation : float
    rows : (4, features + 1) array
        The centre and scale of each feature, (state - centre) * scale, then two rows of scratch.
    variance : float
        Var e.
    """
    features, gain = rows[_FEATURES], rows[_GAIN]
    size = len(state)
    for i in range(size):
        features[i] = (state[i] - rows[_CENTRE, i]) * rows[_SCALE, i]
    features[size] = 1.0
    past, prediction = history[0], history[1]
    for d in range(len(past) - 1, 0, -1):
        past[d] = past[d - 1]
    past[0] = innovation
    known = min(seen, len(past))
    predict_then_learn(weights[:known], covariance, features, past[:known], 1.0, prediction[:known], gain)
    earned = 0.0
    for d in range(known):
        earned += (2.0 * past[d] - prediction[d]) * prediction[d]
    return earned / variance
