"""What a trained policy comes to, measured as every schedule is."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..crawler.drawing.film import film_file, write_film
from ..envs import StickSlipCrawlerEnv
from .policies.policy import Policy
from .schedules import measured_under, Performance, performance

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

__all__ = ["Acting", "actor", "film", "measure", "roll_out"]

Acting: TypeAlias = "Policy | BaseAlgorithm"
"""What acts: a policy of plain numbers, or a model of Stable-Baselines3."""


def roll_out(
    policy: Acting, environment: StickSlipCrawlerEnv, steps: int, seed: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Let a policy act, deterministically, through one long episode.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
    environment : StickSlipCrawlerEnv
        Bare: a time limit would cut the episode.
    steps : int
    seed : int
        Of the flips.

    Returns
    -------
    command, valve : (steps,) arrays of 0 and 1
    """
    command = np.empty(steps, np.int64)
    valve = np.empty(steps, np.int64)
    act = actor(policy)
    observation, _ = environment.reset(seed=seed)
    for k in range(steps):
        command[k] = int(act(observation))
        observation, _, _, _, info = environment.step(command[k])
        valve[k] = info["valve"]
    return command, valve


def measure(
    policy: Acting, environment: StickSlipCrawlerEnv, *, steps: int = 6000, seed: int = 0
) -> tuple[Performance, NDArray[np.int64], NDArray[np.int64]]:
    """Speed and held-out memory capacity of a policy.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
    environment : StickSlipCrawlerEnv
        Where it is measured. If it draws its groups, one draw is measured: its `episode_groups` and `episode_scene`
        afterwards.
    steps : int
    seed : int
        Of the flips and the draw.

    Returns
    -------
    performance : Performance
    command, valve : (steps,) arrays of 0 and 1
    """
    command, valve = roll_out(policy, environment, steps, seed)
    body = {"groups": environment.episode_groups, "scene": environment.episode_scene}
    result = performance(command, valve, **{**measured_under(environment.settings), **body})
    return result, command, valve


def film(
    policy: Acting,
    file: Path,
    *,
    env_kwargs: dict[str, Any],
    steps: int = 40,
    seed: int = 0,
    slow_motion: float = 1.0,
    washout: int = 0,
) -> None:
    """Write a clip of a policy at work.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
    file : Path
        Ends in ``.mp4``, ``.gif`` or ``.html``; its folder must exist.
    env_kwargs : dict
        Arguments of the environment.
    steps : int
        That are shown.
    seed : int
        Of the flips.
    slow_motion : float
        2 makes the clip twice as slow.
    washout : int
        Steps before those that are shown.
    """
    arguments: dict[str, Any] = {**env_kwargs, "render_mode": "rgb_array", "slow_motion": slow_motion}
    environment = StickSlipCrawlerEnv(**arguments)
    act = actor(policy)

    def pictures() -> Iterator[NDArray[np.uint8]]:
        observation, _ = environment.reset(seed=seed)
        for k in range(washout + steps):
            observation, *_ = environment.step(int(act(observation)))
            if k >= washout:
                yield from environment.frames()

    write_film(film_file(file), pictures())
    environment.close()


def actor(policy: Acting, count: int = 1) -> Callable[[NDArray[np.float32]], Any]:
    """Deterministic actions through one episode of each of a batch.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
        A recurrent one remembers the observations so far.
    count : int
        Of the batch.

    Returns
    -------
    callable
        From an observation, or (count, d) of them, to an action, or (count,) of them.
    """
    if isinstance(policy, Policy):
        return policy.predict
    state: tuple[NDArray[Any], ...] | None = None
    beginning = np.ones(count, np.bool_)

    def act(observation: NDArray[np.float32]) -> Any:
        nonlocal state
        action, state = policy.predict(observation, state=state, episode_start=beginning, deterministic=True)
        beginning[:] = False
        return action

    return act
