"""A floor on speed in place of a weight of memory, which finds policies that no weight prefers.

Linear weights find what lies on the convex hull of all that is possible. The most memory at a speed that is at least so
much may lie below it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..envs.multi_objective import objectives_of
from .vec_env import StickSlipVecEnv

__all__ = ["Floor", "FloorVecEnv"]

# What speed is worth below the floor, in memory: it rises by _STEEPNESS a unit of speed up to _MOST, beyond which a
# policy at rest would hear nothing of its memory.
_STEEPNESS, _MOST = 100.0, 9.0
# Steps that the mean speed of a batch goes over, about.
_STEPS = 100


@dataclass(frozen=True)
class Floor:
    """Memory, less a penalty on mean speed below a floor: quadratic close to it, linear further away.

    It is no mean over steps of anything, so that a policy climbs its gradient instead [1]_: that of a mean of speed and
    memory with the weight which its present speed gives.

    Parameters
    ----------
    speed : float
        Of the floor, z_c / t_c.

    References
    ----------
    .. [1] Utilities of expected returns, which are not linear: Hayes et al., "A practical guide to multi-objective
       reinforcement learning and planning", Autonomous Agents and Multi-Agent Systems 36, 26, 2022. The penalty is
       Huber's.
    """

    speed: float

    def utility(self, speed: float, memory: float) -> float:
        """What a policy of some mean speed and memory is worth."""
        lack = max(0.0, self.speed - speed)
        near = min(lack, _MOST / _STEEPNESS)
        return memory - _STEEPNESS * near * (lack - near / 2.0)

    def weight(self, speed: float) -> float:
        """Weight of memory, of two that sum to 1 and are as the derivatives of the utility at a mean speed."""
        return 1.0 / (1.0 + min(_STEEPNESS * max(0.0, self.speed - speed), _MOST))


class FloorVecEnv(StickSlipVecEnv):
    """A batch whose reward climbs the utility of a `Floor`: a mean of speed and memory, weighed by how fast it is.

    Parameters
    ----------
    num_envs : int, >= 1
    floor : Floor
    **arguments
        Of `StickSlipVecEnv`; a `memory_weight` among them is of no effect.

    Attributes
    ----------
    mean_speed : float
        Of all crawlers over about the last hundred steps, by which the next is paid.
    """

    def __init__(self, num_envs: int = 1, *, floor: Floor, **arguments: Any) -> None:
        super().__init__(num_envs, **arguments)
        self.floor = floor
        self.mean_speed = 0.0

    def _paid(self, rewards: NDArray[np.float64], told: dict[str, Any]) -> NDArray[np.float64]:
        speed, memory = objectives_of(told).T
        weight = self.floor.weight(self.mean_speed)
        self.mean_speed += (float(speed.mean()) - self.mean_speed) / _STEPS
        paid: NDArray[np.float64] = (1.0 - weight) * speed + weight * memory
        return paid
