"""Physics of the crawler: parameters, equations, solver, events and energy."""

from .model.actuator import Actuator, Scales
from .model.groups import Groups, GroupsLike, PRESETS
from .model.scene import Scene
from .model.state import ChainState, REST, State
from .motion.balance import EnergyWarning
from .refusals import SlipWarning, SolverError
from .simulation import simulate
from .spectrum import lyapunov_spectrum, LyapunovSpectrum
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
    "LyapunovSpectrum",
    "Scales",
    "Scene",
    "SlipWarning",
    "SolverError",
    "State",
    "Trajectory",
    "lyapunov_spectrum",
    "simulate",
]
