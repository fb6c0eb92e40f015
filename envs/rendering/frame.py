"""What one picture shows."""

from typing import Any, NamedTuple

from numpy.typing import NDArray

from ...crawler.model.state import Body
from ..infos import place_of

__all__ = ["Frame", "frame_of"]

_SPEED, _MEMORY, _VALVE = place_of("speed"), place_of("memory"), place_of("valve")


class Frame(NamedTuple):
    """What one picture shows: the crawler at the end of a hold, in dimensionless units.

    Attributes
    ----------
    time : float
        Time since the episode began, in t_c.
    deformation : float
        Stretch of the body, in z_c.
    pressure : float
        Pressure in the body, in [0, 1].
    foot : float
        Position of the foot, in z_c.
    contact_mode : int
        State of the foot at the end of the hold: 0 sticks, +1 slides forward, -1 slides backward.
    slid : bool
        Whether the foot slid at any time during the hold.
    valve : int
        1 while the valve feeds the body, 0 while it vents it.
    speed : float
        Mean speed over the hold, in z_c / t_c.
    memory : float or None
        The reward's memory term; None where there is no message to remember.
    """

    time: float
    deformation: float
    pressure: float
    foot: float
    contact_mode: int
    slid: bool
    valve: int
    speed: float
    memory: float | None


def frame_of(time: float, body: Body, told: NDArray[Any], remembers: bool) -> Frame:
    """Frame of a crawler at the end of a hold.

    Parameters
    ----------
    time : float
    body : Body
    told : array
        What the step has told: `stickslip.envs.infos.TOLD`.
    remembers : bool
        Whether there is a message, of which the first picture of an episode knows nothing yet.
    """
    speed = float(told[_SPEED])
    return Frame(
        time,
        body.deformation,
        body.pressure,
        body.foot,
        int(body.mode),
        speed != 0.0,
        int(told[_VALVE]),
        speed,
        float(told[_MEMORY]) if remembers and time > 0.0 else None,
    )
