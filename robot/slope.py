"""The rate of a position that is only measured now and then."""

import numpy as np

from ..common.validation import whole_number

__all__ = ["Slope"]


class Slope:
    """Derivative at the newest of the last samples, by the polynomial of least squares through them.

    What its samples lie on exactly, it differentiates exactly, whenever they were taken (A. Savitzky and
    M. J. E. Golay, Analytical Chemistry 36 (1964) 1627, at the end of the window instead of in its middle).

    Parameters
    ----------
    window : int, >= 2
        Samples that it keeps. More of them average noise, and look farther back.
    degree : int, >= 1
        Of the polynomial, less than `window`.
    """

    def __init__(self, window: int, degree: int) -> None:
        self._window = whole_number("window", window, 2)
        self._degree = whole_number("degree", degree, 1, window - 1)
        self._samples: list[tuple[float, float]] = []

    def add(self, time: float, value: float) -> None:
        """Take a sample, later than those before."""
        if self._samples and time <= self._samples[-1][0]:
            return
        self._samples.append((time, value))
        del self._samples[: -self._window]

    @property
    def now(self) -> float:
        """The derivative at the newest sample; 0 before there are two."""
        count = len(self._samples)
        if count < 2:
            return 0.0
        times, values = np.array(self._samples).T
        span = times[-1] - times[0]
        powers = np.vander((times - times[-1]) / span, min(self._degree, count - 1) + 1, increasing=True)
        return float(np.linalg.lstsq(powers, values - values[-1], rcond=None)[0][1] / span)
