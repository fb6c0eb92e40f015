"""Physics of the crawler: parameters, equations, solver, events and energy."""

from .actuator import Actuator, Scales
from .balance import EnergyWarning
from .body import ChainState, REST, State
from .groups import Groups, GroupsLike, PRESETS
from .refusals import SolverError
from .scene import Scene
from .simulation import simulate
from .trajectory import EVENT, Trajectory

__all__ = [
    "EVENT",
    "PRESETS",
    "REST",
    "Actuator",
    "ChainState",
    "EnergyWarning",
    "Groups",
    "GroupsLike",
    "Scales",
    "Scene",
    "SolverError",
    "State",
    "Trajectory",
    "simulate",
]
