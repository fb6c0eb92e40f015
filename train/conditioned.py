"""One policy for every weight of memory: a network that takes the weight beside the observation."""

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ..common.extras import optional_import
from ..common.threads import library_threads
from ..envs.multi_objective import StickSlipCrawlerMOVectorEnv
from .algorithms import algorithm_class
from .hyperparameters import resolve
from .policies.from_model import policy_of
from .policies.policy import Policy
from .run import Configuration

with optional_import():
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.vec_env import VecMonitor
    from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvIndices, VecEnvStepReturn

__all__ = ["ENVIRONMENT", "WeightedVecEnv", "drawn_weights", "train_conditioned", "unit_of_reward"]

ENVIRONMENT = "StickSlipCrawlerMO-v0"
"""Whose entry of a hyperparameter file is for this training."""

# What the best policies come to at dither 0.1: the fastest, and the valve held open.
_MOST_SPEED, _MOST_MEMORY = 0.84, 4.0


def drawn_weights(count: int, generator: np.random.Generator) -> NDArray[np.float64]:
    """Weights of memory, spread evenly over what is drawn from: the square of a uniform number.

    Half of them are below 1/4: the front bends between 0 and 1/2, and above the best policy is always the same.

    Parameters
    ----------
    count : int, >= 1
    generator : numpy.random.Generator

    Returns
    -------
    (count,) array, each in [0, 1)
    """
    strata = (generator.permutation(count) + generator.random(count)) / count
    squares: NDArray[np.float64] = strata**2
    return squares


def unit_of_reward(weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """Reward that a good policy earns at a weight: in units of it no weight drowns another.

    Parameters
    ----------
    weight : array, in [0, 1]

    Returns
    -------
    array of that shape
    """
    unit: NDArray[np.float64] = np.maximum((1.0 - weight) * _MOST_SPEED, weight * _MOST_MEMORY)
    return unit


class WeightedVecEnv(VecEnv):
    """A batch of crawlers, each with a weight of memory for the episode, which is the last number of its observation.

    The reward is ``(1 - weight) * speed + weight * memory`` in units of `unit_of_reward`.

    Parameters
    ----------
    num_envs : int, >= 1
    max_episode_steps : int, >= 1
    **arguments
        Of `StickSlipCrawlerMOVectorEnv`.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.

    Attributes
    ----------
    weights : (num_envs,) array
        Of the episodes that go on; `seed` settles which follow.
    """

    def __init__(self, num_envs: int, *, max_episode_steps: int = 1000, **arguments: Any) -> None:
        self.env = StickSlipCrawlerMOVectorEnv(
            num_envs, **arguments, max_episode_steps=max_episode_steps, autoreset_mode="SameStep"
        )
        seen = self.env.single_observation_space
        assert isinstance(seen, gym.spaces.Box)
        low, high = np.append(seen.low, 0.0), np.append(seen.high, 1.0)
        space = gym.spaces.Box(low.astype(np.float32), high.astype(np.float32))
        super().__init__(num_envs, space, self.env.single_action_space)
        self._generator = np.random.default_rng()
        self._actions: NDArray[Any] | None = None
        self.weights = np.zeros(num_envs)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Settle the flips, the draws and the weights from the next `reset` on."""
        self._generator = np.random.default_rng(seed)
        return super().seed(seed)

    def reset(self) -> NDArray[np.float32]:
        """Put all crawlers at rest, each with a weight of its own.

        Returns
        -------
        (num_envs, d + 1) array of float32
        """
        observations, _ = self.env.reset(seed=self._seeds)
        self._reset_seeds()
        self.weights = drawn_weights(self.num_envs, self._generator)
        return self._beside_weights(observations)

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions of a step, an int of 0 or 1 for each crawler."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Take the step.

        Returns
        -------
        observations : (num_envs, d + 1) array of float32
            Of the next episode where one has ended.
        rewards : (num_envs,) array of float32
        dones : (num_envs,) array of bool
        infos : list of dict
            ``TimeLimit.truncated``, and at the end of an episode ``terminal_observation``.
        """
        assert self._actions is not None
        observations, gains, _, truncations, told = self.env.step(self._actions)
        speed, memory = gains.T
        rewards = ((1.0 - self.weights) * speed + self.weights * memory) / unit_of_reward(self.weights)
        infos: list[dict[str, Any]] = [{"TimeLimit.truncated": bool(cut)} for cut in truncations]
        over = np.flatnonzero(truncations)
        for i in over.tolist():
            last = np.append(told["final_obs"][i], self.weights[i])
            infos[i]["terminal_observation"] = last.astype(np.float32)
        if len(over):
            self.weights[over] = drawn_weights(len(over), self._generator)
        return self._beside_weights(observations), rewards.astype(np.float32), truncations.copy(), infos

    def close(self) -> None:
        """End the threads."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of some crawlers, of all by default."""
        return [getattr(self.env.sub_environments[i], attr_name) for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of some crawlers, of all by default."""
        for i in self._get_indices(indices):
            setattr(self.env.sub_environments[i], attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of some crawlers, of all by default."""
        chosen = [self.env.sub_environments[i] for i in self._get_indices(indices)]
        return [getattr(each, method_name)(*method_args, **method_kwargs) for each in chosen]

    def env_is_wrapped(self, wrapper_class: type[gym.Wrapper], indices: VecEnvIndices = None) -> list[bool]:
        """Whether some crawlers are wrapped: none is."""
        return [False for _ in self._get_indices(indices)]

    def _beside_weights(self, observations: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.column_stack([observations, self.weights.astype(np.float32)])


def train_conditioned(
    configuration: Configuration, *, on_progress: Callable[[int], Any] = lambda steps: None
) -> Policy:
    """Train one policy for every weight of memory.

    Parameters
    ----------
    configuration : Configuration
        Without `memory_weight`, with some dither. Its hyperparameters are as in a training of one weight; a file's
        entry of :data:`ENVIRONMENT` is meant for this one.
    on_progress : callable
        Told the number of environment steps done, every so often.

    Returns
    -------
    Policy
        That takes the weight.

    Raises
    ------
    ValueError, TypeError
        If an argument of the environment or the algorithm is wrong.
    """
    entry = dict(configuration.hyperparameters)
    count, total, network = (entry.pop(name) for name in ("n_envs", "n_timesteps", "policy"))
    arguments = resolve(entry)
    environments = VecMonitor(WeightedVecEnv(count, **configuration.env_kwargs))
    try:
        environments.seed(configuration.seed)
        with library_threads(1):
            model = algorithm_class(configuration.algorithm)(
                network, environments, seed=configuration.seed, device="cpu", **arguments
            )
            model.learn(total, callback=_Telling(on_progress))
    finally:
        environments.close()
    return policy_of(model, configuration, conditioned=True)


class _Telling(BaseCallback):
    """Tells how many steps are done."""

    def __init__(self, on_progress: Callable[[int], Any]) -> None:
        super().__init__()
        self._on_progress = on_progress

    def _on_step(self) -> bool:
        self._on_progress(self.num_timesteps)
        return True
