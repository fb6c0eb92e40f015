"""What a trained policy comes to, measured as every schedule is."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TYPE_CHECKING, TypeAlias

import gymnasium as gym
import numpy as np
from gymnasium.wrappers import RecordVideo
from numpy.typing import NDArray

from ..common.extras import optional_import
from ..common.files import atomically
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


def film(policy: Acting, file: Path, *, env_kwargs: dict[str, Any], steps: int = 240, seed: int = 0) -> None:
    """Write a clip of a policy at work.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
    file : Path
        Ends in ``.mp4``; its folder must exist.
    env_kwargs : dict
        Arguments of the environment.
    steps : int
        Frames.
    seed : int
        Of the flips.
    """
    with optional_import():
        import moviepy  # noqa: F401  (Gymnasium films by it)

    folder = file.parent / f".{file.stem}"
    shutil.rmtree(folder, ignore_errors=True)
    environment = RecordVideo(
        gym.make("StickSlipCrawler-v0", **env_kwargs, render_mode="rgb_array", max_episode_steps=steps),
        video_folder=str(folder),
        name_prefix="clip",
        episode_trigger=lambda _: True,
    )
    act = actor(policy)
    observation, _ = environment.reset(seed=seed)
    finished = False
    while not finished:
        observation, _, terminated, truncated, _ = environment.step(int(act(observation)))
        finished = terminated or truncated
    environment.close()
    (clip,) = folder.glob("*.mp4")
    atomically(file, lambda path: clip.replace(path))
    folder.rmdir()


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
