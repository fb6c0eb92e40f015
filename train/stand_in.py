"""One sub-environment of a batch, as far as Stable-Baselines3 asks for one."""

from dataclasses import replace
from typing import Any, TYPE_CHECKING

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from ..crawler import Groups, Scene
from ..envs import StickSlipCrawlerEnv
from ..envs.settings import Settings

if TYPE_CHECKING:
    from .vec_env import StickSlipVecEnv

__all__ = ["StandIn"]


class StandIn(gym.Env[NDArray[np.float32], np.int64]):
    """What `StickSlipVecEnv` reaches by `get_attr`, `set_attr` and `env_method`.

    It has the attributes of `StickSlipCrawlerEnv` and keeps what else is set on it. It can be reset and drawn, not
    stepped.

    Parameters
    ----------
    batch : StickSlipVecEnv
    index : int
        Of the sub-environment.
    settings : Settings
        Its own.
    """

    metadata = StickSlipCrawlerEnv.metadata

    def __init__(self, batch: "StickSlipVecEnv", index: int, settings: Settings) -> None:
        self._batch, self._index, self._settings = batch, index, settings

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Reset this one alone."""
        return self._batch.reset_one(self._index, seed)

    def step(self, action: Any) -> Any:
        """Refused."""
        raise RuntimeError(f"sub-environment {self._index} cannot be stepped alone; step them all")

    def render(self) -> NDArray[np.uint8] | None:
        """Draw this one; None where it is not among the `rendered`, or a window shows all."""
        return self._batch.picture_of(self._index)

    @property
    def settings(self) -> Settings:
        """Arguments of the environment."""
        return self._settings

    @property
    def episode_groups(self) -> Groups:
        """Groups of the episode."""
        return Groups(**self._told("groups"))

    @property
    def episode_scene(self) -> Scene:
        """Scene of the episode."""
        return replace(self._settings.scene, slope=self._told("slope"))

    def _told(self, name: str) -> Any:
        told = self._batch.reset_infos[self._index]
        if name not in told:
            raise AttributeError(f"no episode has begun, and its {name} not been settled; call reset first")
        return told[name]

    @property
    def render_mode(self) -> str | None:  # type: ignore[override]
        """As given."""
        return self._batch.env.render_mode

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override]
        """What the batch was made from, with its time limit."""
        return self._batch.spec

    @property
    def observation_space(self) -> gym.spaces.Space[NDArray[np.float32]]:  # type: ignore[override]
        """Of one."""
        return self._batch.env.single_observation_space

    @property
    def action_space(self) -> gym.spaces.Space[np.int64]:  # type: ignore[override]
        """Of one."""
        return self._batch.env.single_action_space

    @property  # type: ignore[misc]
    def np_random(self) -> np.random.Generator | None:  # type: ignore[override]
        """Its generator; None before the first reset."""
        return self._batch.env.np_random[self._index]

    @property
    def np_random_seed(self) -> int | None:  # type: ignore[override]
        """Seed of its generator; None before the first reset."""
        return self._batch.env.np_random_seed[self._index]
