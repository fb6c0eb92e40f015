"""A policy as the beginning of a training: the network learns to act as it does, before it is paid."""

from collections.abc import Callable
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..common.extras import optional_import
from ..envs import StickSlipCrawlerVectorEnv
from .episodes import long_episode
from .imitation import CRAWLERS, fit, optimizer_of
from .scores import judging

with optional_import():
    import torch
    from stable_baselines3.common.policies import ActorCriticPolicy

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

__all__ = ["Teacher", "begin_from"]

_HOLDS, _UPDATES = 300, 600
# How often it does otherwise than what it imitates: enough to try what lies near.
_OTHERWISE = 0.05

Teacher = Callable[[NDArray[np.float32]], NDArray[np.int64]]
"""Takes the observations (n, d) of n crawlers, and gives the commands (n,) of 0 and 1, as `Policy.predict` does."""


def begin_from(model: "BaseAlgorithm", teacher: Teacher, env_kwargs: dict[str, Any], *, seed: int = 0) -> None:
    """Have a model that has not learned yet act as a teacher does, but less certainly, so that it tries what lies near.

    Its network is fitted to what the teacher commands where the teacher crawls, now and then led astray, with labels
    that are smoothed [1]_. The critic is left as it is.

    Parameters
    ----------
    model : BaseAlgorithm
        Of PPO or A2C, with a network as the policy's; changed in place.
    teacher : callable
        What is imitated.
    env_kwargs : dict
        Of the environment that it is to learn in.
    seed : int
        Of flips, of what leads astray and of batches.

    Raises
    ------
    ValueError
        If the model's policy has no chances of actions.

    References
    ----------
    .. [1] Szegedy et al. (2016). Rethinking the inception architecture for computer vision, section 7.
    """
    policy: Any = model.policy
    if not isinstance(policy, ActorCriticPolicy):
        raise ValueError(
            f"a training that begins with a policy must be of an actor and a critic, got {type(policy).__name__}"
        )
    generator = np.random.default_rng(seed)
    seen, wanted = _shown(teacher, env_kwargs, generator)
    optimizer = optimizer_of([*policy.mlp_extractor.policy_net.parameters(), *policy.action_net.parameters()])

    def logits(states: torch.Tensor) -> torch.Tensor:
        acting: Any = policy.get_distribution(states).distribution
        chances: torch.Tensor = acting.logits
        return chances

    fit(logits, optimizer, seen, wanted, _UPDATES, generator, smoothing=2 * _OTHERWISE)


def _shown(
    teacher: Teacher, env_kwargs: dict[str, Any], generator: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """What is seen as the teacher crawls, now and then led astray, and what it commands there."""
    states: list[NDArray[np.float32]] = []
    answers: list[NDArray[np.int64]] = []

    def act(_: int, observations: NDArray[np.float32]) -> NDArray[np.int64]:
        states.append(observations.copy())
        answers.append(teacher(observations))
        return answers[-1] ^ (generator.random(len(observations)) < _OTHERWISE)

    batch = StickSlipCrawlerVectorEnv(CRAWLERS, **judging(env_kwargs), max_episode_steps=None)
    for _ in long_episode(batch, act, _HOLDS, seed=int(generator.integers(2**31))):
        pass
    return np.concatenate(states), np.concatenate(answers)
