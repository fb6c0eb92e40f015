"""What a policy comes to on seeds that no training saw: means and intervals, ready for its file."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.validation import whole_number
from ..crawler import Groups, Scene
from ..envs import StickSlipCrawlerVectorEnv
from ..reservoir import mean_over_runs
from .episodes import long_episode
from .evaluation import Acting, actor
from .schedules import measured_under, Performance, performance

__all__ = ["HELD_OUT", "HELD_OUT_SEEDS", "Rollout", "interval", "judging", "roll_outs", "score", "summary"]

HELD_OUT = 2_000_000
"""The first of the seeds that judge: those of trainings, and of the evaluations within them that choose the best
policy, are below, and those that choose schedules are millions above."""

HELD_OUT_SEEDS = tuple(range(HELD_OUT, HELD_OUT + 10))


class Rollout(NamedTuple):
    """One long episode of a policy."""

    command: NDArray[np.int64]
    """Of shape (steps,), 0 or 1: what the policy asked for."""
    valve: NDArray[np.int64]
    """Of shape (steps,), 0 or 1: what came of it."""
    paid: NDArray[np.float64]
    """Of shape (2, steps): speed and memory of each step, as the environment pays them, before their weights."""
    groups: Groups
    scene: Scene
    performance: Performance


def judging(env_kwargs: dict[str, Any]) -> dict[str, Any]:
    """Arguments of the environment in which a policy is judged: what its reward was made of is told apart."""
    return {**env_kwargs, "memory_weight": 0.0}


def roll_outs(
    policy: Acting, env_kwargs: dict[str, Any], *, steps: int = 6000, seeds: Sequence[int] = HELD_OUT_SEEDS
) -> list[Rollout]:
    """Let a policy act, deterministically, through one long episode a seed, all side by side.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
        That takes no weight; `Policy.at` makes one.
    env_kwargs : dict
        Of the environment; what says how to weigh and what to reward is left out.
    steps : int
        1000 at least: the memory is held out on the second half of them.
    seeds : sequence of int
        Of the flips and the draws, one an episode.

    Returns
    -------
    list of Rollout
        Each to the bit as alone.
    """
    whole_number("steps", steps, 1000)
    batch = StickSlipCrawlerVectorEnv(len(seeds), **judging(env_kwargs), max_episode_steps=None, copy=False)
    command, valve = (np.empty((steps, len(seeds)), np.int64) for _ in range(2))
    paid = np.empty((2, steps, len(seeds)))
    act = actor(policy, len(seeds))
    for k, commands, _, infos in long_episode(batch, lambda _, seen: act(seen), steps, seed=seeds):
        command[k], valve[k] = commands, infos["valve"]
        paid[:, k] = infos["speed"], infos["memory"]
    crawlers = list(zip(batch.get_attr("episode_groups"), batch.get_attr("episode_scene"), strict=True))
    conditions = measured_under(batch.settings)
    return [
        Rollout(
            asked,
            came,
            earned,
            groups,
            scene,
            performance(
                asked,
                came,
                **{**conditions, "groups": groups, "scene": scene},
            ),
        )
        for asked, came, earned, (groups, scene) in zip(
            command.T, valve.T, paid.transpose(2, 0, 1), crawlers, strict=True
        )
    ]


def score(
    policy: Acting, env_kwargs: dict[str, Any], *, steps: int = 6000, seeds: Sequence[int] = HELD_OUT_SEEDS
) -> dict[str, Any]:
    """Speed and memory of a policy over seeds.

    Parameters
    ----------
    policy, env_kwargs, steps, seeds
        As for `roll_outs`.

    Returns
    -------
    dict
        As `summary` returns it.
    """
    return summary([each.performance for each in roll_outs(policy, env_kwargs, steps=steps, seeds=seeds)], steps, seeds)


def summary(performances: Sequence[Performance], steps: int, seeds: Sequence[int]) -> dict[str, Any]:
    """Means and 95% intervals over seeds, ready for JSON.

    Parameters
    ----------
    performances : sequence of Performance
        One a seed.
    steps : int
    seeds : sequence of int

    Returns
    -------
    dict
        ``"measured"``, ``"steps"``, ``"seeds"``, ``"speed"`` (z_c / t_c) and, where there were flips, ``"memory"`` (the
        corrected total capacity), as `interval` tells them.
    """
    told: dict[str, Any] = {
        "measured": "in one long episode a seed, memory held out on its second half",
        "steps": steps,
        "seeds": list(seeds),
        "speed": interval([each.speed for each in performances]),
    }
    memories = [each.memory.corrected for each in performances if each.memory is not None]
    return told | ({"memory": interval(memories)} if memories else {})


def interval(values: Sequence[float]) -> dict[str, Any]:
    """``mean``, ``low``, ``high`` and ``runs`` of `mean_over_runs`; ends that are not known are None."""
    if len(values) < 2:
        return {"mean": float(np.mean(values)), "low": None, "high": None, "runs": len(values)}
    return {name: value if np.isfinite(value) else None for name, value in asdict(mean_over_runs(values)).items()}
