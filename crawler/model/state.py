"""The compiled solver's view of a crawler: plain tuples in, plain tuples out."""

from typing import NamedTuple

from numpy.typing import ArrayLike

from .groups import Groups
from .scene import Scene

__all__ = [
    "BACKWARD",
    "FOOT",
    "FORWARD",
    "NOTHING_YET",
    "REST",
    "SLIPS",
    "STUCK",
    "Body",
    "ChainState",
    "Coefficients",
    "Ledger",
    "State",
    "coefficients_of",
]

STUCK, FORWARD, BACKWARD = 0, 1, -1


class State(NamedTuple):
    """Where a simulation begins, in natural units; at rest by default."""

    deformation: float = 0.0
    velocity: float = 0.0
    pressure: float = 0.0
    foot: float = 0.0
    foot_velocity: float = 0.0


class ChainState(NamedTuple):
    """Where a simulation of segments begins, each with its own stretch; foot first, in natural units."""

    segment_deformation: ArrayLike
    segment_velocity: ArrayLike
    pressure: float = 0.0
    foot: float = 0.0
    foot_velocity: float = 0.0


REST = State()


class Body(NamedTuple):
    """State of one crawler at one instant, in natural units."""

    deformation: float
    velocity: float
    pressure: float
    foot: float
    foot_velocity: float
    mode: int  # STUCK, FORWARD or BACKWARD
    slips: int  # transitions into sliding so far


# Places in an array of these fields.
FOOT, SLIPS = Body._fields.index("foot"), Body._fields.index("slips")


class Ledger(NamedTuple):
    """Energy that has passed through one crawler so far, in units of P_max A_0 z_c."""

    work: float  # done by the pressure
    viscous: float  # lost in the elastomer
    friction: float  # lost under the foot
    flow: float  # all of these and what a slope gives and takes, each step's by its size


NOTHING_YET = Ledger(0.0, 0.0, 0.0, 0.0)


class Coefficients(NamedTuple):
    """Coefficients of one crawler's equations of motion, each computed once from its groups and scene."""

    duffing: float
    damping: float
    lag_rate: float
    radial_coupling: float
    payload_fraction: float
    foot_fraction: float
    static_friction: float
    kinetic_friction: float
    slope: float
    anchored: bool
    ratchet: bool


def coefficients_of(groups: Groups, scene: Scene) -> Coefficients:
    """Coefficients of the equations of motion in section 2 of the design, from `groups` and `scene`."""
    return Coefficients(
        duffing=groups.duffing,
        damping=2.0 * groups.damping_ratio,
        lag_rate=1.0 / groups.deborah,
        radial_coupling=groups.radial_coupling,
        payload_fraction=1.0 - groups.foot_mass_fraction,
        foot_fraction=groups.foot_mass_fraction,
        static_friction=groups.static_friction,
        kinetic_friction=groups.kinetic_friction,
        slope=scene.slope,
        anchored=scene.anchored,
        ratchet=scene.ratchet,
    )
