"""The front of many controllers, chosen in rounds of longer and longer runs.

Each of thousands is scored by one noisy run, and the best of them are partly lucky. So each round leaves out only what
is surely beaten, and runs those left four times as long; others judge the front, on seeds of their own.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...envs.settings import Settings
from ...train.episodes import Act
from ...train.schedules import pareto_front
from .rollouts import roll_out_many, Rollouts

__all__ = ["Selection", "select", "undominated"]

_MARGIN = 3.0
_LONGER = 4
_ROUNDS = 4
# Crawlers of a round, if there are holds enough: each controller has several then, which take shorter runs.
_CRAWLERS = 256
# Between the seeds of two rounds, more than the controllers that are ever tried at once; between those of two
# selections; and where they begin, beyond all that train or judge.
_APART, _NEXT, _FIRST = 200_000, 1_000_000, 10_000_000


class Selection(NamedTuple):
    """Which of n controllers make the front."""

    speeds: NDArray[np.float64]
    """(n,) What each came to in the longest run that it was tried in."""
    memories: NDArray[np.float64]
    """(n,)"""
    front: NDArray[np.int64]
    """Those chosen in the longest runs, by falling speed."""


def select(
    controllers: Callable[[NDArray[np.int64], int], Act],
    count: int,
    holds: int,
    settings: Settings,
    *,
    seed: int = 0,
    threads: int | None = None,
) -> Selection:
    """Choose the front of controllers of speed and memory.

    Parameters
    ----------
    controllers : callable
        Takes the numbers of some controllers and the holds they are going to act for, and gives their joint action, as
        in `roll_out_many`.
    count : int
        Of all.
    holds : int
        Scored in the first round; in the last 64 times as many, by several crawlers of each controller.
    settings : Settings
    seed : int, >= 0
        Each has flips of its own, in each round.
    threads : int, optional

    Returns
    -------
    Selection
    """
    latest = np.zeros((2, count))
    left = np.arange(count)
    for turn in range(_ROUNDS):
        copies = max(1, min(_LONGER**turn, _CRAWLERS // len(left)))
        every, length = np.tile(left, copies), holds * _LONGER**turn // copies

        def some(part: slice, every: NDArray[np.int64] = every, length: int = length) -> Act:
            return controllers(every[part], length)

        first = _FIRST + _NEXT * seed + _APART * turn
        scores = _of_all(roll_out_many(some, len(every), length, settings, seed=first, threads=threads), copies)
        latest[:, left] = scores.speeds, scores.memories
        if turn < _ROUNDS - 1:
            left = left[undominated(scores)]
    front = pareto_front(np.stack([scores.speeds, scores.memories], axis=1))
    return Selection(latest[0], latest[1], left[front])


def _of_all(scores: Rollouts, copies: int) -> Rollouts:
    """Scores of controllers, from those of several crawlers of each."""
    speeds, memories, speed_errors, memory_errors = (each.reshape(copies, -1) for each in scores)
    return Rollouts(
        speeds.mean(axis=0),
        memories.mean(axis=0),
        np.sqrt(np.mean(speed_errors**2, axis=0) / copies),
        np.sqrt(np.mean(memory_errors**2, axis=0) / copies),
    )


def undominated(scores: Rollouts, margin: float = _MARGIN) -> NDArray[np.int64]:
    """Which of n are not surely beaten in both objectives.

    Surely means that the interval of one lies above that of the other, each of `margin` standard errors to either side:
    where the errors are alike, a difference of 1.4 times as many of its own.

    Parameters
    ----------
    scores : Rollouts
    margin : float, >= 0

    Returns
    -------
    (m,) array of int
        Ascending.
    """
    values = np.stack([scores.speeds, scores.memories], axis=1)
    errors = np.stack([scores.speed_errors, scores.memory_errors], axis=1)
    if not scores.memories.any():  # without a message speed decides
        values[:, 1], errors[:, 1] = values[:, 0], errors[:, 0]
    low, high = values - margin * errors, values + margin * errors
    stairs = low[pareto_front(low)][::-1]  # by rising speed and falling memory
    faster = np.searchsorted(stairs[:, 0], high[:, 0], side="right")
    best = np.append(stairs[:, 1], -np.inf)[faster]  # memory of the best of those that are surely faster
    return np.flatnonzero(best <= high[:, 1])
