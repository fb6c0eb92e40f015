"""Distance against memory: what no policy has to be learned for, the yardsticks of every one that is."""

from .hypervolume import hypervolume
from .judgement import judge, Judgement
from .open_loop import open_loop_front, OpenLoop
from .speed_limit import Planner, speed_limit, SpeedLimit

__all__ = ["Judgement", "OpenLoop", "Planner", "SpeedLimit", "hypervolume", "judge", "open_loop_front", "speed_limit"]
