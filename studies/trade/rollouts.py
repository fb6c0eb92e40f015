"""Many controllers at once through long episodes of the batched environment, scored by its own reward.

The prequential score of memory counts every hold, whereas a readout that is held out spends half of them on its fit:
of a short run it is the better estimate. So it is what chooses among thousands; `judgement` says what the chosen are.
"""

from collections.abc import Callable
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.sharing import processors
from ...envs import StickSlipCrawlerVectorEnv
from ...envs.settings import Settings
from ...train.episodes import Act, long_episode

__all__ = ["WASHOUT", "Rollouts", "roll_out_many"]

WASHOUT = 200
"""Holds at the start that are not scored, as in `memory_capacity`."""

Runs = Callable[[int], tuple[NDArray[np.int64], NDArray[np.int64]]]

# Of the scores of so many holds the means are nearly independent of each other.
_BLOCK = 100
# Crawlers that are stepped at once: the readouts of more would take gigabytes.
_CHUNK = 8192


class Rollouts(NamedTuple):
    """What n controllers came to."""

    speeds: NDArray[np.float64]
    """(n,) Mean speed of the foot, z_c / t_c."""
    memories: NDArray[np.float64]
    """(n,) Mean of what the prequential readout earned, had the flips the variance that they have on average; 0 without
    dither. By how much they differ is chance, and the larger part of it."""
    speed_errors: NDArray[np.float64]
    """(n,) Standard error of the speed, from means over blocks of holds."""
    memory_errors: NDArray[np.float64]
    """(n,)"""


def roll_out_many(
    controllers: Callable[[slice], Act],
    count: int,
    holds: int,
    settings: Settings,
    *,
    seed: int = 0,
    threads: int | None = None,
) -> Rollouts:
    """Let controllers act, each on a crawler of its own, and score them.

    Parameters
    ----------
    controllers : callable
        Takes a slice of the `count` and gives their joint action.
    count : int, >= 1
    holds : int
        Scored, after `WASHOUT` more: at least 200.
    settings : Settings
        See `conditions`.
    seed : int, >= 0
        Of the flips: controller i takes ``seed + i``.
    threads : int, optional
        All processors by default.

    Returns
    -------
    Rollouts
    """
    chunks = [slice(begin, min(begin + _CHUNK, count)) for begin in range(0, count, _CHUNK)]
    scores = [_scores(controllers(part), part, holds, settings, seed, threads) for part in chunks]
    means = np.concatenate([each.mean(axis=0) for each in scores], axis=1)
    errors = np.concatenate([each.std(axis=0, ddof=1) / np.sqrt(len(each)) for each in scores], axis=1)
    return Rollouts(*means, *errors)


def _scores(
    act: Act, part: slice, holds: int, settings: Settings, seed: int, threads: int | None
) -> NDArray[np.float64]:
    """Means of speed and memory over blocks of holds, shape (blocks, 2, controllers)."""
    count = part.stop - part.start
    environment = StickSlipCrawlerVectorEnv(
        count,
        **arguments_of(settings),
        max_episode_steps=None,
        copy=False,
        threads=processors() if threads is None else threads,
    )
    blocks = max(2, round(holds / _BLOCK))
    ends = WASHOUT + np.arange(blocks + 1) * holds // blocks
    sums = np.zeros((blocks, 3, count))
    for k, _, _, infos in long_episode(environment, act, WASHOUT + holds, seed=seed + part.start):
        if k >= WASHOUT:
            block = int(np.searchsorted(ends, k, side="right")) - 1
            sums[block, 0] += infos["speed"]
            sums[block, 1] += infos["memory"]
            sums[block, 2] += infos["innovation"] ** 2
    speeds, memories, squares = (sums / np.diff(ends)[:, np.newaxis, np.newaxis]).transpose(1, 0, 2)
    if settings.dither > 0.0 and settings.target == "memory":
        variances = squares / settings.variance
        memories = memories - memories.mean(axis=0) / variances.mean(axis=0) * (variances - 1.0)
    return np.stack([speeds, memories], axis=1)


def arguments_of(settings: Settings) -> dict[str, Any]:
    """Arguments of the environment, as it takes them."""
    return {each.name: getattr(settings, each.name) for each in fields(settings)}


def runs_of(
    act: Act, count: int, settings: Settings, *, seeds: tuple[int, ...], holds: int, threads: int | None = None
) -> Runs:
    """What n policies that act in the environment command, and what the valves do, on each of m seeds.

    Parameters
    ----------
    act : callable
        As in `roll_out_many`, of n m environments at once: those of a policy side by side, one for each seed.
    count : int
        The n.
    settings : Settings
    seeds : tuple of m int
    holds : int
    threads : int, optional

    Returns
    -------
    callable
        Takes a seed and gives commands and valves, each (n, holds), as `judge` wants them.
    """
    environment = StickSlipCrawlerVectorEnv(
        count * len(seeds), **arguments_of(settings), max_episode_steps=None, copy=False, threads=threads
    )
    commands, valves = np.empty((2, count, len(seeds), holds), np.int8)
    for k, command, _, infos in long_episode(environment, act, holds, seed=seeds * count):
        commands[..., k] = command.reshape(count, -1)
        valves[..., k] = infos["valve"].reshape(count, -1)
    place = {seed: i for i, seed in enumerate(seeds)}
    return lambda seed: (commands[:, place[seed]].astype(np.int64), valves[:, place[seed]].astype(np.int64))
