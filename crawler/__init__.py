"""Physics of the crawler: parameters, equations, solver, events and energy.

Nothing is imported here: parameters need NumPy at most, motion needs numba. The names below are imported on first use.
"""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from .derivatives import Sensitivities, sensitivities
    from .model.actuator import Actuator, Scales
    from .model.groups import Groups, GroupsLike, PRESETS
    from .model.scene import Scene
    from .model.state import ChainState, REST, State
    from .motion.balance import EnergyWarning
    from .refusals import SlipWarning, SolverError
    from .simulation import simulate
    from .spectrum import lyapunov_spectrum, LyapunovSpectrum
    from .trajectory import EVENT, Trajectory

_HOME = {
    "EVENT": ".trajectory",
    "PRESETS": ".model.groups",
    "REST": ".model.state",
    "Actuator": ".model.actuator",
    "ChainState": ".model.state",
    "EnergyWarning": ".motion.balance",
    "Groups": ".model.groups",
    "GroupsLike": ".model.groups",
    "LyapunovSpectrum": ".spectrum",
    "Scales": ".model.actuator",
    "Scene": ".model.scene",
    "Sensitivities": ".derivatives",
    "SlipWarning": ".refusals",
    "SolverError": ".refusals",
    "State": ".model.state",
    "Trajectory": ".trajectory",
    "lyapunov_spectrum": ".spectrum",
    "sensitivities": ".derivatives",
    "simulate": ".simulation",
}

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
    "Sensitivities",
    "SlipWarning",
    "SolverError",
    "State",
    "Trajectory",
    "lyapunov_spectrum",
    "sensitivities",
    "simulate",
]


if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name not in _HOME:
            raise AttributeError(f"module 'stickslip.crawler' has no attribute {name!r}")
        return getattr(import_module(_HOME[name], __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
