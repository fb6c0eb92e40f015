"""What a valve can do that does not look: the front of all open-loop schedules.

Thousands of schedules are scored, each by one noisy run, and the best of them are partly lucky. So the front is chosen
in rounds on seeds of its own, each of fewer schedules over longer runs, and judged on others. A round leaves out only
what another schedule beats in both objectives by more than `_MARGIN` standard errors of the differences, so that what
belongs to the front is lost once in tens of thousands.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import whole_number
from ...envs.settings import Settings
from ...reservoir.bootstrap import Estimate
from ...tasks import dithered
from ...train.schedules import necklaces, pareto_front
from .conditions import conditions
from .judgement import held_out_seeds, judge, Judgement
from .rollouts import roll_out_many, Rollouts, WASHOUT

__all__ = ["OpenLoop", "commands_of", "open_loop_front", "undominated"]

RATES = tuple(f"random {percent}%" for percent in range(5, 100, 5))
"""Bernoulli schedules, by how often they open the valve."""

_MARGIN = 4.0
# Each round has as many times the holds of the one before.
_LONGER = 4
_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class OpenLoop:
    """Open-loop schedules under one set of conditions.

    Attributes
    ----------
    settings : Settings
        The conditions.
    names : tuple of n str
        All schedules that were tried: words to be repeated for ever, and `RATES`.
    speeds, memories : (n,) arrays
        What each came to in the longest run that it was tried in: noisy, and the best of them lucky.
    front : Judgement
        Of those chosen, on held-out seeds, by falling speed.
    hypervolume : Estimate
        Of `front`, from (0, 0).
    """

    settings: Settings
    names: tuple[str, ...]
    speeds: NDArray[np.float64]
    memories: NDArray[np.float64]
    front: Judgement
    hypervolume: Estimate

    @property
    def fastest(self) -> str:
        """Which of the front is fastest on the held-out seeds."""
        return self.front.names[int(np.argmax(self.front.points[:, 0]))]


def open_loop_front(
    *,
    longest: int = 16,
    seeds: int = 10,
    holds: int = 10_000,
    screening_holds: int = 1000,
    seed: int = 0,
    threads: int | None = None,
    **env_kwargs: Any,
) -> OpenLoop:
    """Score every binary word, and Bernoulli schedules, for speed and memory; choose the front, and judge it afresh.

    Parameters
    ----------
    longest : int, >= 1
        Bits of the longest words; there are 8,800 up to 16.
    seeds : int, >= 1
        Held-out seeds that judge.
    holds : int
        Of the runs that judge.
    screening_holds : int, >= 200
        Of the first runs that choose; the last are 16 times as long.
    seed : int, in [0, 1000)
        Of those.
    threads : int, optional
        All processors by default.
    **env_kwargs
        As for `conditions`.

    Returns
    -------
    OpenLoop

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.
    """
    settings = conditions(**env_kwargs)
    names = (*necklaces(longest), *RATES)
    held_out = held_out_seeds(seeds)
    whole_number("screening_holds", screening_holds, 200)
    whole_number("holds", holds, 1000)
    first_seed = whole_number("seed", seed, 0, 999)
    latest = np.zeros((2, len(names)))
    left, length = np.arange(len(names)), screening_holds
    for turn in range(_ROUNDS):
        commands = commands_of([names[i] for i in left], WASHOUT + length, first_seed)
        scores = _screened(commands, length, settings, 1000 * first_seed + 100_000 * turn, threads)
        latest[:, left] = scores.speeds, scores.memories
        if turn < _ROUNDS - 1:
            left, length = left[undominated(scores)], length * _LONGER
    chosen = [names[i] for i in left[pareto_front(np.stack([scores.speeds, scores.memories], axis=1))]]

    def runs(held_out: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        asked = commands_of(chosen, holds, held_out)
        return asked, np.array([dithered(each, settings.dither, held_out) for each in asked])

    front = judge(chosen, runs, settings, seeds=held_out)
    return OpenLoop(settings, names, latest[0], latest[1], front, front.hypervolume())


def commands_of(names: Sequence[str], holds: int, seed: int) -> NDArray[np.int64]:
    """Commands of schedules by name.

    Parameters
    ----------
    names : sequence of n str
        Words of 0 and 1, or such as "random 30%".
    holds : int
    seed : int
        Of what is random.

    Returns
    -------
    (n, holds) array of 0 and 1
    """
    commands = np.empty((len(names), holds), np.int64)
    for row, name in zip(commands, names, strict=True):
        if name.startswith("random "):
            rate = float(name.removeprefix("random ").removesuffix("%")) / 100
            row[:] = np.random.default_rng([seed, round(1000 * rate)]).random(holds) < rate
        else:
            row[:] = np.resize(np.frombuffer(name.encode(), np.uint8) - ord("0"), holds)
    return commands


def undominated(scores: Rollouts, margin: float = _MARGIN) -> NDArray[np.int64]:
    """Which of n are not surely beaten in both objectives.

    Parameters
    ----------
    scores : Rollouts
    margin : float
        Standard errors of a difference that make it sure.

    Returns
    -------
    (m,) array of int
        Ascending.
    """
    objectives = [(scores.speeds, scores.speed_errors)]
    if scores.memories.any():
        objectives.append((scores.memories, scores.memory_errors))
    kept = []
    for i in range(len(scores.speeds)):
        beaten = np.ones(len(scores.speeds), np.bool_)
        for values, errors in objectives:
            beaten &= values - values[i] > margin * np.hypot(errors, errors[i])
        if not beaten.any():
            kept.append(i)
    return np.array(kept, np.int64)


def _screened(commands: NDArray[np.int64], holds: int, settings: Settings, seed: int, threads: int | None) -> Rollouts:
    def controllers(part: slice) -> Any:
        rows = np.ascontiguousarray(commands[part].T)
        return lambda k, _: rows[k]

    return roll_out_many(controllers, len(commands), holds, settings, seed=seed, threads=threads)
