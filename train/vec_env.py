"""Crawlers in a batch, as Stable-Baselines3 wants its environments."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, cast

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from ..common.extras import optional_import
from ..common.validation import truth_value
from ..envs import StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv
from ..envs.infos import infos_of_each
from ..envs.sub_environment import SubEnvironment

with optional_import():
    from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvIndices, VecEnvStepReturn

__all__ = ["StickSlipVecEnv"]

_NAME = "StickSlipCrawler-v0"
_TRUNCATED = "TimeLimit.truncated"
_infos_of_each = infos_of_each({_TRUNCATED: False})


class StickSlipVecEnv(VecEnv):
    """A batch of `StickSlipCrawlerEnv` as a `VecEnv` of Stable-Baselines3, one compiled call a step.

    It does, to the last bit, what a `DummyVecEnv` of as many ``gym.make("StickSlipCrawler-v0")`` does, seeded alike:
    observations, rewards, ends and infos, however often it is reset.

    Parameters
    ----------
    num_envs : int, >= 1
    sparse_infos : bool
        Whether only the last step of an episode tells what `StickSlipCrawlerEnv` documents under Information. The other
        infos then say ``TimeLimit.truncated`` alone, which is all that the algorithms ask of them; dicts of Python's
        numbers, one for each sub-environment and step, are what a large batch waits for longest.
    **arguments
        Of `StickSlipCrawlerVectorEnv`, `max_episode_steps`, `render_mode` and `rendered` among them.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range, of the wrong type, or settled by SB3's contract; the message names it.

    Attributes
    ----------
    env : StickSlipCrawlerVectorEnv

    Notes
    -----
    There are no single environments behind it: `get_attr`, `set_attr` and `env_method` reach its `SubEnvironment`s.
    """

    def __init__(self, num_envs: int = 1, *, sparse_infos: bool = False, **arguments: Any) -> None:
        for name in ("autoreset_mode", "copy"):
            if name in arguments:
                raise ValueError(f"{name} must not be set: SB3 resets in the same step and keeps what it is given")
        if "vectorization_mode" in arguments:
            raise ValueError("vectorization_mode must not be set: the batch is one environment")
        sparse = truth_value("sparse_infos", sparse_infos)
        made = gym.make_vec(_NAME, num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **arguments)
        self.env = cast(StickSlipCrawlerVectorEnv, made)
        self._sparse = sparse
        self._actions: NDArray[Any] | None = None
        self._rendered = list(range(num_envs) if arguments.get("rendered") is None else arguments["rendered"])
        self.num_envs = self.env.num_envs  # `get_attr`, which the parent calls, counts by it
        super().__init__(self.env.num_envs, self.env.single_observation_space, self.env.single_action_space)
        self.metadata = StickSlipCrawlerEnv.metadata
        made_from = cast(EnvSpec, made.spec)
        limit = arguments.get("max_episode_steps", made_from.max_episode_steps)
        self.spec = self.env.spec = replace(made_from, max_episode_steps=limit)

    def reset(self) -> NDArray[np.float32]:
        """Put all crawlers at rest, with the seeds of the last call of `seed` if there was one since.

        Returns
        -------
        (num_envs, ...) array of float32
            What else is told of the episodes is in `reset_infos`.
        """
        self._actions = None
        observations, _ = self.env.reset(seed=self._seeds, options=_together(self._options))
        self._keep_reset_infos(range(self.num_envs))
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions of a step, an int of 0 or 1 for each sub-environment."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Take the step.

        Returns
        -------
        observations : (num_envs, ...) array of float32
            Of the next episode where one has ended.
        rewards : (num_envs,) array of float32
        dones : (num_envs,) array of bool
        infos : list of dict

        Raises
        ------
        RuntimeError
            If there was no `step_async`.
        ValueError, TypeError
            If the actions are wrong; nothing is stepped then.
        """
        if self._actions is None:
            raise RuntimeError("step_wait needs a call of step_async first")
        actions, self._actions = self._actions, None
        observations, rewards, terminations, truncations, told = self.env.step(actions)
        dones = terminations | truncations
        over = np.flatnonzero(dones).tolist()
        infos = self._infos_within(told, all_over=len(over) == self.num_envs)
        if over:
            self._tell_the_ends(infos, told, over, truncations & ~terminations)
            self._keep_reset_infos(over)
        return observations, self._paid(rewards, told).astype(np.float32), dones, infos

    def close(self) -> None:
        """End the threads, and close the window if there is one."""
        self.env.close()

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """A picture of each of the `rendered` sub-environments; None of each without ``render_mode="rgb_array"``."""
        if self.render_mode != "rgb_array":
            warnings.warn(f"get_images needs render_mode='rgb_array', got {self.render_mode!r}", stacklevel=2)
            return [None] * self.num_envs
        pictures = self.env.render()
        assert pictures is not None
        return cast("tuple[NDArray[np.uint8], ...]", pictures)

    def render(self, mode: str | None = None) -> NDArray[np.uint8] | None:
        """Draw the `rendered` sub-environments, as one picture or in one window."""
        if self.render_mode == "human" and mode in (None, "human"):
            self.env.render()
            return None
        return super().render(mode)

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of some sub-environments, of all by default."""
        return [getattr(crawler, attr_name) for crawler in self._chosen(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of some sub-environments; what `StickSlipCrawlerEnv` is made of cannot be set."""
        for crawler in self._chosen(indices):
            setattr(crawler, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of some sub-environments."""
        return [getattr(crawler, method_name)(*method_args, **method_kwargs) for crawler in self._chosen(indices)]

    def env_is_wrapped(self, wrapper_class: type[gym.Wrapper], indices: VecEnvIndices = None) -> list[bool]:
        """Whether some sub-environments are wrapped: none is."""
        return [False for _ in self._chosen(indices)]

    def _chosen(self, indices: VecEnvIndices) -> list[SubEnvironment]:
        return [self.env.sub_environments[i] for i in self._get_indices(indices)]

    def _paid(self, rewards: NDArray[np.float64], told: dict[str, Any]) -> NDArray[np.float64]:
        """What the steps are paid, given what the batch pays and tells."""
        return rewards

    def _infos_within(self, told: Mapping[str, Any], all_over: bool) -> list[dict[str, Any]]:
        """Infos of a step, as if no episode had ended with it."""
        if self._sparse or all_over:
            return [{_TRUNCATED: False} for _ in range(self.num_envs)]
        return _infos_of_each(told, self.env.crawlers_by_name)

    def _tell_the_ends(
        self, infos: list[dict[str, Any]], told: Mapping[str, Any], over: list[int], cut: NDArray[np.bool_]
    ) -> None:
        last, observations = told["final_info"], told["final_obs"]
        for i in over:
            infos[i] = _one_of(last, i)
            infos[i] |= {_TRUNCATED: bool(cut[i]), "terminal_observation": observations[i]}

    def _keep_reset_infos(self, begun: Sequence[int]) -> None:
        for i in begun:
            self.reset_infos[i] = self.env.begun(i)


def _one_of(told: Mapping[str, Any], i: int) -> dict[str, Any]:
    """Infos of one sub-environment, as it tells them itself."""
    return {
        name: _one_of(values, i) if isinstance(values, Mapping) else values[i].item()
        for name, values in told.items()
        if not name.startswith(("_", "final_"))
    }


def _together(options: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Options of each sub-environment, as the batch takes them."""
    names = {name for one in options for name in one}
    return {name: [one.get(name) for one in options] for name in names}
