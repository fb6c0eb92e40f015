"""What one picture shows: a crawler at one instant, where it is, and what of the past is still to be seen."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model.actuator import Actuator
from ..model.groups import Groups
from ..model.scene import Scene

__all__ = [
    "NATURAL",
    "NOTHING",
    "Frame",
    "Message",
    "Past",
    "Units",
    "World",
    "fitting",
    "static_stretch",
    "units_of",
    "world_of",
]

Array = NDArray[np.float64]

_STEEPEST = math.radians(7.0)  # that is drawn; the words tell the truth
_LONGEST_REST = 4.0  # rest lengths that the stretch of a body under full pressure has in a picture


class Units(NamedTuple):
    """What one natural unit is in what the words of a picture are in, and what that is called."""

    length: float = 1.0
    length_name: str = "z_c"
    time: float = 1.0
    time_name: str = "t_c"
    speed_name: str = "z_c/t_c"
    pressure: float = 1.0
    pressure_name: str = ""


NATURAL = Units()


def units_of(actuator: Actuator | None) -> Units:
    """Millimetres, seconds and kilopascals of an actuator; natural units of none."""
    if actuator is None:
        return NATURAL
    length, time, _, pressure = actuator.scales
    return Units(1e3 * length, "mm", time, "s", "mm/s", 1e-3 * pressure, "kPa")


class World(NamedTuple):
    """What stays the same through a film.

    Attributes
    ----------
    anchored, ratchet : bool
        As in `Scene`.
    angle : float
        By which the ground is drawn to rise, rad.
    slope : str
        Words for it; empty on level ground.
    rest_length : float
        From foot to payload where the body is not stretched, in z_c: the model leaves it free, a picture cannot.
    units : Units
    """

    anchored: bool
    ratchet: bool
    angle: float
    slope: str
    rest_length: float
    units: Units


def world_of(scene: Scene, stretch: float, actuator: Actuator | None = None) -> World:
    """World of a film.

    Parameters
    ----------
    scene : Scene
    stretch : float
        That the body has at a usual instant, in z_c: its rest length is drawn as four of these, so that the payload
        never runs into the foot and every stretch can be seen.
    actuator : Actuator, optional
        Whose units to write in. It also says how steep a slope is, which groups alone do not.
    """
    angle, words = math.atan(scene.slope), f"slope {scene.slope:.3g}"
    if actuator is not None and actuator.gravity > 0.0:
        sine = scene.slope * actuator.scales.force / (actuator.mass) / actuator.gravity
        if abs(sine) <= 1.0:
            angle = math.asin(sine)
            words = f"slope {math.degrees(angle):.3g}°"
    return World(
        anchored=scene.anchored,
        ratchet=scene.ratchet,
        angle=fitting(angle, -_STEEPEST, _STEEPEST),
        slope=words.replace("-", "−") if scene.slope else "",
        rest_length=_LONGEST_REST * stretch,
        units=units_of(actuator),
    )


def static_stretch(groups: Groups) -> float:
    """Stretch of a body that rests under full pressure, z + duffing z^3 = 1, but for the coupling's part in it; z_c."""
    stretch = min(1.0, groups.duffing ** (-1 / 3)) if groups.duffing > 0.0 else 1.0
    for _ in range(20):  # Newton's steps come down on the root from above
        stretch -= (stretch + groups.duffing * stretch**3 - 1.0) / (1.0 + 3.0 * groups.duffing * stretch**2)
    return stretch


class Past(NamedTuple):
    """What happened so far, up to the instant of the picture and in order of time; arrays of one length.

    Attributes
    ----------
    time : array
        In t_c.
    foot, payload : arrays
        Their displacements, in z_c.
    foot_velocity : array
        Not 0 where the foot slides.
    valve : array
        1 where it was open just before.
    """

    time: Array
    foot: Array
    payload: Array
    foot_velocity: Array
    valve: Array


NOTHING = Past(*(np.empty(0) for _ in Past._fields))
"""The past of a film that begins."""


class Message(NamedTuple):
    """What the body is to remember, and what a readout recalls of it; newest first.

    Attributes
    ----------
    valves : tuple of int
        States of the valve in the holds so far, the one that goes on among them.
    flips : tuple of bool
        Whether they were not as commanded.
    going : int
        1 while the newest of these holds goes on, 0 at its end.
    sent : array
        Message of each completed hold.
    recalled : array
        What the readout makes of the body; may be shorter.
    largest : float
        Size of the largest message there can be.
    """

    valves: tuple[int, ...]
    flips: tuple[bool, ...]
    going: int
    sent: Array
    recalled: Array
    largest: float


class Frame(NamedTuple):
    """What one picture shows, in natural units.

    Attributes
    ----------
    time : float
        In t_c.
    stretches : tuple of float
        Of the segments, foot first, in z_c.
    pressure : float
        In [0, 1].
    foot, foot_velocity : float
        Of the foot, in z_c and z_c / t_c: it sticks where its velocity is 0.
    valve : int
        1 while the valve feeds the body, 0 while it vents it.
    camera : float
        Place that is looked at, in z_c.
    past : Past
    memory : float or None
        The reward's memory term of the last hold; None where there is none.
    message : Message or None
        None where nothing is sent.
    """

    time: float
    stretches: tuple[float, ...]
    pressure: float
    foot: float
    foot_velocity: float
    valve: int
    camera: float = 0.0
    past: Past = NOTHING
    memory: float | None = None
    message: Message | None = None


def fitting(value: float, low: float, high: float) -> float:
    """Clip a number into an interval; what is not a number is drawn as zero."""
    return 0.0 if math.isnan(value) else min(max(value, low), high)
