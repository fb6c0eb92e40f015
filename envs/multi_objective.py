"""StickSlipCrawlerMO-v0: speed and memory as a vector, single and in a batch, by the conventions of MO-Gymnasium."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from .reward import OBJECTIVES, reward_space
from .single import StickSlipCrawlerEnv
from .sub_environment import SubEnvironment
from .vector import StickSlipCrawlerVectorEnv

__all__ = ["StickSlipCrawlerMOEnv", "StickSlipCrawlerMOVectorEnv", "objectives_of"]


def _gains(told: Mapping[str, Any]) -> NDArray[np.float64]:
    """Objectives of what was told of a step, of one crawler or of many; shape (..., objectives)."""
    return np.stack([told[each.name] for each in OBJECTIVES], axis=-1)


def objectives_of(infos: Mapping[str, Any]) -> NDArray[np.float64]:
    """Objectives of a step of a batch, from its infos; where an episode has ended, those of its last step.

    Parameters
    ----------
    infos : mapping
        Of `StickSlipCrawlerVectorEnv.step`.

    Returns
    -------
    (num_envs, objectives) array
    """
    gains = _gains(infos)
    if "final_info" in infos:  # the others are of the episodes that have begun
        ended = infos["_final_info"]
        gains[ended] = _gains(infos["final_info"])[ended]
    return gains


def _checked(arguments: Mapping[str, Any], **changed: Any) -> dict[str, Any]:
    """Arguments of the environment with one reward.

    Raises
    ------
    TypeError
        If there is a weight among them.
    ValueError
        If memory could never be earned.
    """
    if "memory_weight" in arguments:
        raise TypeError("memory_weight is no argument of StickSlipCrawlerMO-v0, whose reward is not weighed")
    if arguments.get("dither") == 0:
        raise ValueError("dither must be in (0, 0.5] where memory is an objective, got 0: there is nothing to remember")
    return {**arguments, **changed, "memory_weight": 0.0}


class StickSlipCrawlerMOEnv(StickSlipCrawlerEnv):
    """`StickSlipCrawlerEnv` with a vector for a reward: speed and memory, unweighed.

    ``gymnasium.make("StickSlipCrawlerMO-v0")`` makes it, and so does ``mo_gymnasium.make``. All but the reward is to
    the last bit as in the environment with one reward, and that is ``(1 - memory_weight) * speed + memory_weight *
    memory`` of this one's.

    Parameters
    ----------
    **arguments
        Of `StickSlipCrawlerEnv`, but `memory_weight`; `dither` must not be 0.

    Attributes
    ----------
    reward_space : Box of shape (2,), float64
        Of the rewards, as MO-Gymnasium wants it.
    reward_dim : int
        2.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range, unknown or of the wrong type; the message names it.
    """

    def __init__(self, **arguments: Any) -> None:
        super().__init__(**_checked(arguments))
        self.reward_space: spaces.Space[NDArray[np.float64]] = reward_space(self.settings.scene)
        self.reward_dim = len(OBJECTIVES)

    def step(  # type: ignore[override]
        self, action: int | np.integer
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], bool, bool, dict[str, Any]]:
        """Hold the valve as commanded, or flipped, for one hold.

        Parameters
        ----------
        action : int
            0 or 1.

        Returns
        -------
        observation : array of float32
        reward : (2,) array of float64
            Speed and memory.
        terminated, truncated, info
            As of `StickSlipCrawlerEnv`, and so is what it raises.
        """
        observation, _, terminated, truncated, info = super().step(action)
        return observation, _gains(info), terminated, truncated, info


class _SubEnvironment(SubEnvironment):
    @property
    def reward_space(self) -> spaces.Space[NDArray[np.float64]]:
        return self._batch.reward_space  # type: ignore[attr-defined]

    @property
    def reward_dim(self) -> int:
        return self._batch.reward_dim  # type: ignore[attr-defined]


class StickSlipCrawlerMOVectorEnv(StickSlipCrawlerVectorEnv):
    """A batch of `StickSlipCrawlerMOEnv`, stepped together: see `StickSlipCrawlerVectorEnv`.

    ``gymnasium.make_vec("StickSlipCrawlerMO-v0", num_envs=n)`` makes it. Rewards have the shape (num_envs, 2), as those
    of MO-Gymnasium's `MOSyncVectorEnv`.

    Parameters
    ----------
    num_envs : int, >= 1
    **arguments
        Of `StickSlipCrawlerVectorEnv`, but `memory_weight`; `dither` must not be 0.

    Attributes
    ----------
    reward_space : Box of shape (2,), float64
        Of one sub-environment, as MO-Gymnasium wants it.
    reward_dim : int
        2.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range, unknown or of the wrong type; the message names it.
    """

    _sub_environment = _SubEnvironment

    def __init__(self, num_envs: int = 1, **arguments: Any) -> None:
        super().__init__(num_envs, **_checked(arguments))
        self.reward_space: spaces.Space[NDArray[np.float64]] = reward_space(self.settings.scene)
        self.reward_dim = len(OBJECTIVES)

    def step(
        self, actions: ArrayLike
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Hold every valve as commanded, or flipped, for one hold.

        Parameters
        ----------
        actions : (num_envs,) array of int
            Each 0 or 1.

        Returns
        -------
        observations : (num_envs, ...) array of float32
        rewards : (num_envs, 2) array of float64
            Speed and memory of each.
        terminations, truncations, infos
            As of `StickSlipCrawlerVectorEnv`, and so is what it raises.
        """
        observations, _, terminations, truncations, infos = super().step(actions)
        return observations, objectives_of(infos), terminations, truncations, infos
