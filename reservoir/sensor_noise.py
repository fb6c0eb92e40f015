"""What sensors add to states: a noise model, so that capacities and ranks mean something on hardware."""

import numpy as np
from numpy.typing import NDArray

from ..common.validation import number_within

Array = NDArray[np.float64]

# Keeps the noise apart from what else is drawn with the caller's seed.
_STREAM = 0x4E01


def noise_over_signal(noise: float) -> float:
    """Standard deviation of the noise over that of the signal, for a signal-to-noise ratio in decibels.

    Parameters
    ----------
    noise : float
        Ratio of the variances, ``10 log10(signal / noise)``: 20 is a tenth of the signal's standard deviation, 60 a
        thousandth.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If `noise` is not finite.
    """
    return float(10 ** (-number_within("noise", noise, "(-inf, inf)") / 20))


def with_sensor_noise(states: Array, noise: float | None, seed: int) -> Array:
    """States as sensors of a signal-to-noise ratio would read them.

    Each feature gets white normal noise of its own, in proportion to its standard deviation over the samples, so that
    units do not matter; a feature that stands still stays so.

    Parameters
    ----------
    states : ndarray of shape (samples, features)
    noise : float or None
        Signal-to-noise ratio in decibels; None adds nothing.
    seed : int
        Equal seeds add equal noise.

    Returns
    -------
    ndarray of shape (samples, features)
    """
    if noise is None:
        return states
    level = noise_over_signal(noise) * (states - states[0]).std(axis=0)
    return states + level * np.random.default_rng([_STREAM, seed]).standard_normal(states.shape)
