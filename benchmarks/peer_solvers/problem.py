"""What every solver is asked for: one trajectory whose end is known to 25 digits, and the equations they share."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.crawler import Groups

__all__ = [
    "DAMPING",
    "DRAG",
    "FOOT",
    "GRIP",
    "GROUPS",
    "HOLD",
    "LAG_RATE",
    "LIGHT",
    "PAYLOAD",
    "SLIPS",
    "WORD",
    "Contender",
    "Journey",
    "Word",
    "force",
    "inverse_masses",
    "travel",
]

Word = NDArray[np.int8]

GROUPS = Groups()
HOLD = 1.0
WORD: Word = np.array([1, 1, 1, 1, 0, 0, 0, 0] * 25, np.int8)
FOOT = 32.03368882790800707974502  # after WORD from rest, 40-digit arithmetic
SLIPS = 50

DAMPING = 2.0 * GROUPS.damping_ratio
LAG_RATE = 1.0 / GROUPS.deborah
LIGHT = GROUPS.foot_mass_fraction
PAYLOAD = 1.0 - LIGHT
GRIP = GROUPS.static_friction
DRAG = GROUPS.kinetic_friction
inverse_masses = (1.0 / PAYLOAD, 1.0 / (LIGHT * PAYLOAD))
"""Rate v' per force while the foot sticks, and while it slides."""


class Journey(NamedTuple):
    """Where the foot got to, and after how many slips; None from a model that cannot tell a slip."""

    foot: float
    slips: int | None


class Contender(NamedTuple):
    """One solver at one setting.

    `run` maps the valve's states, one a hold, to the journey from rest. `tolerance` orders the settings of a method,
    the smallest the most accurate: a tolerance or a time step.
    """

    library: str
    method: str
    setting: str
    tolerance: float
    run: Callable[[Word], Journey]
    note: str = ""


def force(z: Any, v: Any, p: Any) -> Any:
    """F = p (1 + Pi5 z) - z - Pi1 z^3 - 2 Pi2 v, of numbers, of arrays or of a library's symbols.

    The cube is a product: heyoka's series of a power divides by its base, and a body at rest has z = 0.
    """
    return p + z * (GROUPS.radial_coupling * p - 1.0 - GROUPS.duffing * (z * z)) - DAMPING * v


def travel(speed: Any, stretch: Any, rate: Any, time: Any) -> Any:
    """Way of the foot that slides for `time`, from the momentum.

    Parameters
    ----------
    speed, rate
        Velocity of the foot, and of the deformation, as the time begins.
    stretch
        Growth of the deformation in it.
    """
    return (speed + PAYLOAD * rate - 0.5 * DRAG * time) * time - PAYLOAD * stretch
