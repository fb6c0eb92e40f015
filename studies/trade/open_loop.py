"""What a valve can do that does not look: the front of all open-loop schedules.

Every binary word up to a length, repeated for ever, and Bernoulli schedules. `selection` chooses the front, and it is
judged on seeds that nothing was chosen by.
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
from ...train.episodes import Act
from ...train.schedules import necklaces
from .conditions import conditions
from .judgement import held_out_seeds, judge, Judgement, Runs
from .rollouts import WASHOUT
from .selection import select

__all__ = ["OpenLoop", "commands_of", "open_loop_front", "schedule_runs"]

RATES = tuple(f"random {percent}%" for percent in range(5, 100, 5))
"""Bernoulli schedules, by how often they open the valve."""


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
        Of the first runs that choose; in the last there are 64 times as many.
    seed : int, >= 0
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
    first_seed = whole_number("seed", seed, 0)

    def controllers(some: NDArray[np.int64], length: int) -> Act:
        rows = np.ascontiguousarray(commands_of([names[i] for i in some], WASHOUT + length, first_seed).T)
        return lambda k, _: rows[k]

    found = select(controllers, len(names), screening_holds, settings, seed=first_seed, threads=threads)
    chosen = [names[i] for i in found.front]

    front = judge(chosen, schedule_runs(chosen, settings.dither, holds), settings, seeds=held_out)
    return OpenLoop(settings, names, found.speeds, found.memories, front, front.hypervolume())


def schedule_runs(names: Sequence[str], dither: float, holds: int) -> Runs:
    """What schedules command, and what the valves do, all with the same flips.

    Parameters
    ----------
    names : sequence of str
        As for `commands_of`.
    dither : float
    holds : int

    Returns
    -------
    callable
        Takes the seed of the flips, and of what else is random, as `judge` wants it.
    """

    def runs(seed: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        commands = commands_of(names, holds, seed)
        return commands, np.array([dithered(each, dither, seed) for each in commands])

    return runs


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
