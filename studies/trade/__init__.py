"""Distance against memory: what no policy has to be learned for, the yardsticks of every one that is."""

from .evolution import Evolved, evolved_feedback, Feedback
from .gap import Gap, gap
from .hypervolume import hypervolume
from .judgement import judge, Judgement
from .open_loop import open_loop_front, OpenLoop
from .registers import best_registers, Registers
from .speed_limit import Planner, speed_limit, SpeedLimit

__all__ = [
    "Evolved",
    "Feedback",
    "Gap",
    "Judgement",
    "OpenLoop",
    "Planner",
    "Registers",
    "SpeedLimit",
    "best_registers",
    "evolved_feedback",
    "gap",
    "hypervolume",
    "judge",
    "open_loop_front",
    "speed_limit",
]
