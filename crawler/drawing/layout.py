"""Where a picture has what, in its pixels, and where the things of a frame are in it."""

from typing import NamedTuple

from .frame import fitting, Frame, World

__all__ = [
    "FOOT_AT",
    "GROUND",
    "HEADER",
    "HEIGHT",
    "HOSE_AT",
    "LOWER",
    "PIVOT",
    "REST_PIXELS",
    "WIDTH",
    "Pose",
    "posed",
    "written",
]

# Both sides are multiples of 16, so video encoders neither pad nor rescale.
WIDTH, HEIGHT = 960, 480
HEADER = 76  # of valve, gauge and numbers
GROUND = 262  # height of the ground's surface
LOWER = 338  # where the lower panels begin
PIVOT = (480.0, float(GROUND))  # about which a slope turns
FOOT_AT = 290  # where the camera puts a resting foot
REST_PIXELS = 240  # of a body that is not stretched
HOSE_AT = (44, 62)  # where it leaves the valve

_FARTHEST = 1e6
# Stretches that are drawn, in rest lengths; the words tell the numbers themselves.
_SHORTEST, _LONGEST = -0.55, 1.1
_GREATEST_SPEED = 1e3


class Pose(NamedTuple):
    """A frame in pixels, fit to draw, on level ground."""

    scale: float  # pixels a z_c
    origin: float  # of the ground's coordinate
    foot: float
    ends: tuple[float, ...]  # of the segments, the last that of the payload
    pressure: float
    speed: float  # of the foot
    heading: int  # where the foot slides to; 0 where it sticks


def posed(frame: Frame, world: World) -> Pose:
    """Where the things of a frame are."""
    scale = REST_PIXELS / world.rest_length
    foot = fitting(frame.foot, -_FARTHEST, _FARTHEST)
    camera = fitting(frame.camera, -_FARTHEST, _FARTHEST)
    origin = FOOT_AT - camera * scale
    rest = REST_PIXELS / len(frame.stretches)
    end, ends = origin + foot * scale, []
    for stretch in frame.stretches:
        end += rest + fitting(stretch * scale, _SHORTEST * rest, _LONGEST * rest)
        ends.append(end)
    speed = fitting(frame.foot_velocity, -_GREATEST_SPEED, _GREATEST_SPEED)
    return Pose(
        scale=scale,
        origin=origin,
        foot=origin + foot * scale,
        ends=tuple(ends),
        pressure=fitting(frame.pressure, 0.0, 1.0),
        speed=speed,
        heading=int(speed > 0.0) - int(speed < 0.0),
    )


def written(value: float, decimals: int) -> str:
    """A number in words: fixed decimals, or a power of ten where it is large."""
    text = f"{value:.{decimals}f}" if abs(value) < _FARTHEST else f"{value:.0e}"
    if not text.strip("-0."):
        text = text.removeprefix("-")
    return text.replace("-", "−")
