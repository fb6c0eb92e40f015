"""Physics of the crawler: parameters, equations, solver, events and energy."""

from .actuator import Actuator, Scales
from .body import REST, State
from .groups import Groups, PRESETS
from .scene import Scene
from .simulation import simulate, SolverError
from .trajectory import EVENT, Trajectory

__all__ = [
    "EVENT",
    "PRESETS",
    "REST",
    "Actuator",
    "Groups",
    "Scales",
    "Scene",
    "SolverError",
    "State",
    "Trajectory",
    "simulate",
]
