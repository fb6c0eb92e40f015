"""One sub-environment of a batch, as far as it can be asked for alone."""

from typing import Any, TYPE_CHECKING

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from ..crawler import Groups, Scene
from .settings import Settings
from .single import StickSlipCrawlerEnv
from .state import CrawlerState

if TYPE_CHECKING:
    from .vector import StickSlipCrawlerVectorEnv

__all__ = ["SubEnvironment"]


class SubEnvironment(gym.Env[NDArray[np.float32], np.int64]):
    """What `call`, `get_attr` and `set_attr` of a batch reach.

    It has the attributes of `StickSlipCrawlerEnv` and keeps what else is set on it. It can be reset, drawn and its
    state saved, not stepped.

    Parameters
    ----------
    batch : StickSlipCrawlerVectorEnv
    index : int
        Of the sub-environment.
    """

    metadata = StickSlipCrawlerEnv.metadata
    get_keys_to_action = staticmethod(StickSlipCrawlerEnv.get_keys_to_action)

    def __init__(self, batch: "StickSlipCrawlerVectorEnv", index: int) -> None:
        self._batch, self._index = batch, index

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Reset this one alone."""
        return self._batch.reset_one(self._index, seed, options)

    def step(self, action: Any) -> Any:
        """Refused."""
        raise RuntimeError(f"sub-environment {self._index} cannot be stepped alone; step them all")

    def render(self) -> NDArray[np.uint8] | list[NDArray[np.uint8]] | None:  # type: ignore[override]
        """Draw this one; None where it is not among the `rendered`, or a window shows all."""
        return self._batch.render_one(self._index)

    def readout_states(self) -> NDArray[np.float64]:
        """What the memory readout of this one has seen of the hold just ended."""
        return self._batch.readout_states()[self._index]

    def get_state(self, *, generator: bool = True) -> CrawlerState:
        """State of this one."""
        return self._batch.get_state(generator=generator)[self._index]

    def set_state(self, state: CrawlerState) -> None:
        """Set the state of this one."""
        states: list[CrawlerState | None] = [None] * self._batch.num_envs
        states[self._index] = state
        self._batch.set_state(states)

    @property
    def settings(self) -> Settings:
        """Arguments of the environment."""
        return self._batch.settings_of_each[self._index]

    @property
    def episode_groups(self) -> Groups:
        """Groups of the episode."""
        return self._batch.crawler_of(self._index)[0]

    @property
    def episode_scene(self) -> Scene:
        """Scene of the episode."""
        return self._batch.crawler_of(self._index)[1]

    @property
    def render_mode(self) -> str | None:  # type: ignore[override]
        """As given."""
        return self._batch.render_mode

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override]
        """What the batch was made from."""
        return self._batch.spec

    @property
    def observation_space(self) -> gym.spaces.Space[NDArray[np.float32]]:  # type: ignore[override]
        """Of one."""
        return self._batch.single_observation_space

    @property
    def action_space(self) -> gym.spaces.Space[np.int64]:  # type: ignore[override]
        """Of one."""
        return self._batch.single_action_space

    @property
    def np_random(self) -> np.random.Generator:
        """Its generator."""
        return self._batch.np_random[self._index]

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        generators = list(self._batch.np_random)
        generators[self._index] = value
        self._batch.np_random = generators

    @property
    def np_random_seed(self) -> int | None:  # type: ignore[override]
        """Seed of its generator; -1 where a generator was given."""
        return self._batch.np_random_seed[self._index]
