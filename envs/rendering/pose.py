"""Where a frame puts things in the picture, in pixels."""

import math
from typing import NamedTuple

from .frame import Frame

__all__ = ["FARTHEST", "PIXELS_PER_LENGTH", "REST_LENGTH", "Camera", "Pose", "fitting", "posed"]

PIXELS_PER_LENGTH = 60
REST_LENGTH = 4.0  # foot to payload at zero deformation, in z_c: the model leaves it free, the picture cannot
FOOT_AT = 300  # where the camera puts a resting foot

# The drawing stays within these whatever the numbers; the readout always shows the numbers themselves.
DEFORMATION_LIMITS = (-2.2, 4.5)
FARTHEST = 1e6
LATEST = 1e12

CAMERA_TIME = 1.5  # the camera closes its distance to the crawler with this time constant, in t_c
CAMERA_LAG = 1.5  # and is never farther behind than this, in z_c


class Camera:
    """Follows the foot smoothly, in the frames' own time: a state drawn twice looks the same twice."""

    def __init__(self) -> None:
        self._position = 0.0
        self._time = math.inf

    def follow(self, position: float, time: float) -> float:
        """Position that the picture is centred on, for a foot at `position`."""
        elapsed = time - self._time
        if elapsed < 0:  # the first frame, or a new episode
            self._position = position
        else:
            self._position += (position - self._position) * (1 - math.exp(-elapsed / CAMERA_TIME))
        self._position = min(max(self._position, position - CAMERA_LAG), position + CAMERA_LAG)
        self._time = time
        return self._position


class Pose(NamedTuple):
    """A frame in pixels, fit to draw: where things stand and how the body looks."""

    origin: float  # of the ground's coordinate
    foot: int
    payload: int
    pressure: float
    contact_mode: int


def posed(frame: Frame, camera: Camera) -> Pose:
    """Where the things of a frame are."""
    foot = fitting(frame.foot, -FARTHEST, FARTHEST)
    length = REST_LENGTH + fitting(frame.deformation, *DEFORMATION_LIMITS)
    origin = FOOT_AT - camera.follow(foot, fitting(frame.time, -LATEST, LATEST)) * PIXELS_PER_LENGTH
    return Pose(
        origin=origin,
        foot=round(origin + foot * PIXELS_PER_LENGTH),
        payload=round(origin + (foot + length) * PIXELS_PER_LENGTH),
        pressure=fitting(frame.pressure, 0.0, 1.0),
        contact_mode=frame.contact_mode,
    )


def fitting(value: float, low: float, high: float) -> float:
    """Clip a number into an interval; what is not a number is drawn as zero."""
    return 0.0 if math.isnan(value) else min(max(value, low), high)
