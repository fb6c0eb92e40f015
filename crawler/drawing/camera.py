"""Where a film looks."""

import math

from .frame import fitting

__all__ = ["Camera"]

_TIME = 1.5  # the camera closes its distance to the crawler with this time constant, in t_c
_LAG = 0.35  # and is never farther behind than this, in rest lengths
_FARTHEST, _LATEST = 1e6, 1e12


class Camera:
    """Follows the foot smoothly, in the film's own time.

    Parameters
    ----------
    rest_length : float
        Of the crawler as it is drawn, in z_c.
    """

    def __init__(self, rest_length: float) -> None:
        self._lag = _LAG * rest_length
        self._position = 0.0
        self._time = math.inf

    def follow(self, foot: float, time: float) -> float:
        """Place that the picture is centred on, for a foot at `foot`; in z_c."""
        foot, time = fitting(foot, -_FARTHEST, _FARTHEST), fitting(time, -_LATEST, _LATEST)
        elapsed = time - self._time
        if elapsed < 0:  # the first picture
            self._position = foot
        else:
            self._position += (foot - self._position) * (1 - math.exp(-elapsed / _TIME))
        self._position = min(max(self._position, foot - self._lag), foot + self._lag)
        self._time = time
        return self._position
