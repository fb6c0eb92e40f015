"""Encodings: how a real-valued series becomes what a valve does that is either open or shut.

Every encoding spends the same number of holds on each sample, so that at an equal hold the cost in time, and nearly
that in computing, is the number of holds a sample takes. What it loses is how far the share of the sample that the
valve is open, all that a slow body feels, misses the sample's value:

=============  =====================  =====================================================================
encoding       holds a sample         loses
=============  =====================  =====================================================================
threshold      1                      all but one bit: up to `level` or 1 - `level`
pulse width    1, of two parts        nothing; the valve turns at an exact instant within the hold
sigma-delta    `holds_per_sample`     at most 1 / `holds_per_sample` in one sample, and 1 / 2 hold in all of them
=============  =====================  =====================================================================

`benchmarks/encodings.py` measures what that does to capacities and tasks.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within, whole_number

__all__ = ["ENCODINGS", "Encoding", "encode", "pulse_width", "sigma_delta", "threshold"]

Encoding = Callable[[ArrayLike, int], NDArray[Any]]
"""Takes a series (samples,) in [0, 1] and the holds a sample; gives a schedule (samples * holds a sample,)."""


def threshold(series: ArrayLike, holds_per_sample: int = 1, *, level: float = 0.5) -> NDArray[np.int8]:
    """Open the valve for a sample that is at least as high as a level.

    Parameters
    ----------
    series : array_like of shape (samples,), in [0, 1]
    holds_per_sample : int, at least 1
        Holds that each sample lasts.
    level : float, in [0, 1]

    Returns
    -------
    ndarray of int8, shape (samples * holds_per_sample,)
        Of 0 and 1.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    values = unit_series("series", series)
    level = number_within("level", level, "[0, 1]")
    opened = (values >= level).astype(np.int8)
    return np.repeat(opened, whole_number("holds_per_sample", holds_per_sample, 1))


def pulse_width(series: ArrayLike, holds_per_sample: int = 1) -> NDArray[np.float64]:
    """Open the valve for the first part of each hold, as long a part as the sample is high.

    Parameters
    ----------
    series : array_like of shape (samples,), in [0, 1]
    holds_per_sample : int, at least 1
        Holds that each sample lasts, all of the same duty cycle.

    Returns
    -------
    ndarray of float64, shape (samples * holds_per_sample,)
        Duty cycles for `stickslip.simulate`.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    return np.repeat(unit_series("series", series), whole_number("holds_per_sample", holds_per_sample, 1))


def sigma_delta(series: ArrayLike, holds_per_sample: int = 8) -> NDArray[np.int8]:
    """Open the valve so often that what it let in never misses the series by more than half a hold.

    A first-order modulator [1]_: what the valve has let in so far is subtracted from what the series asks for, and
    it opens where more than half a hold is owing. The debt is carried from sample to sample, and begins at zero.

    Parameters
    ----------
    series : array_like of shape (samples,), in [0, 1]
    holds_per_sample : int, at least 1
        Holds that each sample lasts, the oversampling ratio.

    Returns
    -------
    ndarray of int8, shape (samples * holds_per_sample,)
        Of 0 and 1.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    References
    ----------
    .. [1] H. Inose, Y. Yasuda and J. Murakami, "A telemetering system by code modulation: Delta-sigma modulation",
       IRE Trans. Space Electronics and Telemetry SET-8, 204, 1962.
    """
    values = np.repeat(unit_series("series", series), whole_number("holds_per_sample", holds_per_sample, 1))
    schedule = np.empty(len(values), np.int8)
    owing = 0.0
    for k, value in enumerate(values.tolist()):
        owing += value
        schedule[k] = opened = owing >= 0.5
        owing -= opened
    return schedule


ENCODINGS: dict[str, Encoding] = {"threshold": threshold, "pulse_width": pulse_width, "sigma_delta": sigma_delta}
"""The encodings known by name."""


def encode(series: ArrayLike, encoding: str, holds_per_sample: int) -> NDArray[Any]:
    """Apply one of :data:`ENCODINGS`.

    Parameters
    ----------
    series : array_like of shape (samples,), in [0, 1]
    encoding : str
    holds_per_sample : int, at least 1

    Returns
    -------
    ndarray of shape (samples * holds_per_sample,)

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    return known_encoding(encoding)(series, holds_per_sample)


def known_encoding(encoding: str) -> Encoding:
    """One of :data:`ENCODINGS`, or a ValueError that names them."""
    if encoding not in ENCODINGS:
        raise ValueError(f"encoding must be one of {list(ENCODINGS)}, got {encoding!r}")
    return ENCODINGS[encoding]


def unit_series(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Convert to a float array (samples,) of numbers in [0, 1], or raise an error that names the first other."""
    series = finite_array(name, value, 1)
    wrong = np.flatnonzero((series < 0.0) | (series > 1.0))
    if len(wrong):
        raise ValueError(f"{name} must be in [0, 1], got {series[wrong[0]]} at index {wrong[0]}")
    return series
