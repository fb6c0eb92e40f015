"""What the chosen are worth: long runs on seeds that nothing was chosen by."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.validation import whole_number
from ...envs.settings import Settings
from ...reservoir.bootstrap import Estimate, mean_over_runs
from ...train.schedules import measured_under, performances
from ...train.scores import HELD_OUT
from .hypervolume import hypervolume

__all__ = ["Judgement", "held_out_seeds", "jackknifed", "joined", "judge"]

Bits = NDArray[np.int64]
Runs = Callable[[int], tuple[Bits, Bits]]

# Holds times runs whose motions are in memory at once, a quarter of a kilobyte each.
_HOLDS_AT_ONCE = 500_000


@dataclass(frozen=True, eq=False)
class Judgement:
    """Speed and memory of n schedules or policies on each of m seeds.

    Attributes
    ----------
    names : tuple of str
        Of the n.
    speeds, memories : (n, m) arrays
        Mean speed of the foot, z_c / t_c; held-out memory capacity, its corrected total, 0 without dither.
    seeds : tuple of int
        Of the m.
    holds : int
        Of each run.
    """

    names: tuple[str, ...]
    speeds: NDArray[np.float64]
    memories: NDArray[np.float64]
    seeds: tuple[int, ...]
    holds: int

    @property
    def points(self) -> NDArray[np.float64]:
        """Mean speed and memory of each, shape (n, 2)."""
        return np.stack([self.speeds.mean(axis=1), self.memories.mean(axis=1)], axis=1)

    def speed(self, name: str, confidence: float = 0.95) -> Estimate:
        """Mean speed of one, and its interval over the seeds."""
        return mean_over_runs(self.speeds[self.names.index(name)], confidence)

    def memory(self, name: str, confidence: float = 0.95) -> Estimate:
        """Mean memory of one, and its interval over the seeds."""
        return mean_over_runs(self.memories[self.names.index(name)], confidence)

    def hypervolume(self, reference: tuple[float, float] = (0.0, 0.0), confidence: float = 0.95) -> Estimate:
        """Hypervolume of the mean points, and its interval.

        The mean over seeds of each seed's own hypervolume would be too large: of noisy points the luckiest make the
        front. The interval is Student's over the jackknife's pseudovalues [1]_, each of all seeds but one.

        Parameters
        ----------
        reference : (float, float)
        confidence : float, in (0, 1)

        Returns
        -------
        Estimate
            Its mean is the hypervolume of `points`.

        References
        ----------
        .. [1] B. Efron and C. Stein, "The jackknife estimate of variance", Annals of Statistics 9, 586, 1981.
        """
        return jackknifed(lambda points: hypervolume(points, reference), self, confidence)


def jackknifed(
    statistic: Callable[[NDArray[np.float64]], float], judgement: Judgement, confidence: float = 0.95
) -> Estimate:
    """A number of the mean points, and its interval by the jackknife over seeds.

    Parameters
    ----------
    statistic : callable
        Of points, shape (n, 2).
    judgement : Judgement
    confidence : float, in (0, 1)

    Returns
    -------
    Estimate
        Its ends are NaN where there is one seed.
    """
    runs = len(judgement.seeds)
    whole = statistic(judgement.points)
    if runs == 1:
        return Estimate(whole, np.nan, np.nan, 1)
    both = np.stack([judgement.speeds, judgement.memories], axis=1)
    without = [statistic(np.delete(both, m, axis=2).mean(axis=2)) for m in range(runs)]
    over_seeds = mean_over_runs(runs * whole - (runs - 1) * np.array(without), confidence)
    low, high = over_seeds.low - over_seeds.mean, over_seeds.high - over_seeds.mean
    return Estimate(whole, whole + low, whole + high, runs)


def joined(first: Judgement, second: Judgement) -> Judgement:
    """Two judgements of the same seeds and holds as one.

    Raises
    ------
    ValueError
        If their seeds or holds differ.
    """
    if (first.seeds, first.holds) != (second.seeds, second.holds):
        raise ValueError(
            f"judgements must have the same seeds and holds, got {first.seeds} and {second.seeds}, "
            f"{first.holds} and {second.holds}"
        )
    return Judgement(
        first.names + second.names,
        np.concatenate([first.speeds, second.speeds]),
        np.concatenate([first.memories, second.memories]),
        first.seeds,
        first.holds,
    )


def held_out_seeds(count: int) -> tuple[int, ...]:
    """Seeds that judge.

    Raises
    ------
    ValueError, TypeError
        If `count` is not a whole number from 1 to a million.
    """
    return tuple(range(HELD_OUT, HELD_OUT + whole_number("seeds", count, 1, 1_000_000)))


def judge(names: Sequence[str], runs: Runs, settings: Settings, *, seeds: Sequence[int]) -> Judgement:
    """Measure schedules, or what policies did, as `train.schedules.performances` measures any.

    Parameters
    ----------
    names : sequence of n str
    runs : callable
        Takes a seed and gives commands and valves, each (n, holds) of 0 and 1: what was asked for, and what came of it.
    settings : Settings
        See `conditions`.
    seeds : sequence of m int
        Of the flips, and whatever else is drawn.

    Returns
    -------
    Judgement
    """
    scores, holds = [], 0
    for seed in seeds:
        commands, valves = runs(seed)
        holds = commands.shape[1]
        some = max(1, _HOLDS_AT_ONCE // holds)
        found = [
            each
            for begin in range(0, len(commands), some)
            for each in performances(
                commands[begin : begin + some],
                valves[begin : begin + some],
                **measured_under(settings),
            )
        ]
        scores.append([(each.speed, 0.0 if each.memory is None else each.memory.corrected) for each in found])
    speeds, memories = np.transpose(scores, (2, 1, 0))
    return Judgement(tuple(names), speeds, memories, tuple(seeds), holds)
