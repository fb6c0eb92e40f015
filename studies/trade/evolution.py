"""Registers that also look at the body, evolved: what feedback reaches beyond the last few valve states.

The command is a table of the last valve states and of whether the body is stretched beyond a threshold, and stretches
faster than another. There are too many tables to try them all. Linear weights of speed and memory find only what lies
on the convex hull of what is possible; so the search asks for the most memory at each of many floors on speed. Each
generation keeps for every floor the few that are best by the lower end of what is known of them, and runs those again:
of thousands scored once the best are lucky.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import whole_number
from ...envs.settings import Settings
from ...reservoir.bootstrap import Estimate
from ...train.episodes import Act
from ...train.schedules import pareto_front
from .conditions import conditions, refuse_silence
from .judgement import held_out_seeds, judge, Judgement
from .registers import best_registers
from .rollouts import roll_out_many, runs_of

__all__ = ["Evolved", "Feedback", "embedded", "evolved_feedback"]

Array = NDArray[np.float64]
Bits = NDArray[np.int64]

_FLOORS = 16
_KEPT = 14  # for each floor
_CHILDREN = 1200
_AGAIN, _ENOUGH = 2, 20  # times as many holds in a run of those kept, and in all of theirs, as in a child's first
_TURNS = 3  # times that those kept run again in a generation
_CROSSED = 0.3  # share of children of two parents
_FLIPPED = 0.005, 0.1  # least and largest share of a table's entries that change
_MOVED = 0.01, 0.5  # least and largest standard deviation of a threshold's change
_FAR = 30.0  # what a unit of speed below the floor costs in memory
# Standard errors of speed and memory at one hold, about.
_ERRORS = np.array([1.0, 6.0])
_FIRST_SEED, _SEEDS = 20_000_000, 10_000  # of the flips, and as many for each generation


@dataclass(frozen=True, eq=False)
class Feedback:
    """Tables of n policies, and their thresholds.

    Attributes
    ----------
    tables : (n, 2^(bits + 2)) array of 0 and 1
        The command after each past, the newest valve state its lowest bit, the two bits above the oldest telling
        whether the deformation and its rate are above their thresholds.
    thresholds : (n, 2) array
        Of the deformation and its rate.
    """

    tables: Bits
    thresholds: Array

    def __len__(self) -> int:
        return len(self.tables)

    def __getitem__(self, some: Any) -> "Feedback":
        return Feedback(self.tables[some], self.thresholds[some])

    def acting(self) -> Act:
        """Joint action in a batch of environments, one each; all past valve states are 0 at first."""
        count, entries = self.tables.shape
        pasts = entries // 4
        flat, offset = np.ascontiguousarray(self.tables).ravel(), np.arange(count) * entries
        stretch, rate = np.ascontiguousarray(self.thresholds.T)
        past = np.zeros(count, np.int64)

        def act(k: int, observations: NDArray[np.float32]) -> Bits:
            if k > 0:
                past[:] = (2 * past + observations[:, 4].astype(np.int64)) % pasts
            seen = (observations[:, 0] > stretch) + 2 * (observations[:, 1] > rate)
            return flat[offset + past + pasts * seen]

        return act


@dataclass(frozen=True, eq=False)
class Evolved:
    """What came of the evolution.

    Attributes
    ----------
    settings : Settings
        The conditions.
    feedback : Feedback
        Those chosen.
    front : Judgement
        Of them, on held-out seeds, by falling speed; named by their numbers in `feedback`.
    hypervolume : Estimate
        Of `front`, from (0, 0).
    """

    settings: Settings
    feedback: Feedback
    front: Judgement
    hypervolume: Estimate


def evolved_feedback(
    *,
    bits: int = 5,
    generations: int = 60,
    children: int = _CHILDREN,
    begin: Sequence[str] | None = None,
    seeds: int = 10,
    holds: int = 10_000,
    screening_holds: int = 600,
    seed: int = 0,
    threads: int | None = None,
    **env_kwargs: Any,
) -> Evolved:
    """Evolve registers with thresholds for the most memory at floors on speed, and judge them afresh.

    Parameters
    ----------
    bits : int, 1 to 10
        Past valve states that they see.
    generations, children : int, >= 1
        And of each as many children.
    begin : sequence of str, optional
        Tables of registers, of at most so many bits, to begin from, as `best_registers` names them; the front of all
        those of three bits by default.
    seeds, holds, threads
        As in `open_loop_front`.
    screening_holds : int, >= 200
        Of the first run of a child; the best have twenty times as many in all.
    seed : int, >= 0
        Of the evolution.
    **env_kwargs
        As for `conditions`, with dither.

    Returns
    -------
    Evolved

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.
    """
    settings = conditions(**env_kwargs)
    refuse_silence(settings)
    whole_number("bits", bits, 1, 10)
    whole_number("generations", generations, 1)
    whole_number("children", children, 1)
    whole_number("holds", holds, 1000)
    whole_number("screening_holds", screening_holds, 200)
    held_out = held_out_seeds(seeds)
    random = np.random.default_rng(whole_number("seed", seed, 0))
    if begin is None:
        begin = best_registers(min(bits, 3), seeds=1, holds=1000, threads=threads, **env_kwargs).front.names
    population = _begun(begin, bits, random)
    scores = np.zeros((len(population), 3))  # speed, memory, holds
    flips = _FIRST_SEED

    def run(some: Feedback, length: int, seed: int) -> Array:
        found = roll_out_many(lambda part: some[part].acting(), len(some), length, settings, seed=seed, threads=threads)
        return np.stack([found.speeds, found.memories, np.full(len(some), float(length))], axis=1)

    for generation in range(generations + 1):
        if generation > 0:
            born = _children(population, children, random)
            population = Feedback(
                np.concatenate([population.tables, born.tables]),
                np.concatenate([population.thresholds, born.thresholds]),
            )
            scores = np.concatenate([scores, run(born, screening_holds, flips)])
        for turn in range(_TURNS):
            if generation > 0:
                kept = _best(scores)
                population, scores = population[kept], scores[kept]
            again = np.flatnonzero(scores[:, 2] < _ENOUGH * screening_holds)
            if len(again):
                found = run(population[again], _AGAIN * screening_holds, flips + _SEEDS // 2 + turn * _SEEDS // 8)
                scores[again] = _pooled(scores[again], found)
        flips += _SEEDS
    chosen = population[pareto_front(scores[:, :2])]
    runs = runs_of(
        chosen[np.repeat(np.arange(len(chosen)), seeds)].acting(),
        len(chosen),
        settings,
        seeds=held_out,
        holds=holds,
        threads=threads,
    )
    front = judge(list(map(str, range(len(chosen)))), runs, settings, seeds=held_out)
    return Evolved(settings, chosen, front, front.hypervolume())


def embedded(table: str, bits: int) -> Bits:
    """Table of a register as one of more bits, and of whatever the body does; shape (2^(bits + 2),)."""
    return np.resize(np.array([int(letter) for letter in table]), 2 ** (bits + 2))


def _begun(begin: Sequence[str], bits: int, random: np.random.Generator) -> Feedback:
    tables = np.array([embedded(table, bits) for table in (*begin, "0", "1")])
    return Feedback(tables, random.normal(size=(len(tables), 2)))


def _children(parents: Feedback, count: int, random: np.random.Generator) -> Feedback:
    """Parents, some of them crossed with another, with entries flipped and thresholds moved."""
    first, second = random.integers(0, len(parents), (2, count))
    tables, thresholds = parents.tables[first], parents.thresholds[first]
    entries = tables.shape[1]
    mixed = (random.random((count, 1)) < _CROSSED) & (random.random((count, entries)) < 0.5)
    tables = np.where(mixed, parents.tables[second], tables)
    flipped = random.random((count, entries)) < _log_uniform(_FLIPPED, count, random)
    moved = random.normal(size=(count, 2)) * _log_uniform(_MOVED, count, random)
    return Feedback(tables ^ flipped, thresholds + moved)


def _log_uniform(ends: tuple[float, float], count: int, random: np.random.Generator) -> Array:
    low, high = ends
    return low * (high / low) ** random.random((count, 1))


def _best(scores: Array) -> NDArray[np.int64]:
    """Who is best for any of the floors, by the lower ends of what is known of speed and memory; ascending."""
    low = scores[:, :2] - _ERRORS / np.sqrt(scores[:, 2:])
    kept: set[int] = set()
    # Closer to each other at the fast end, where memory falls steeply.
    for floor in low[:, 0].max() * (1.0 - np.linspace(1.0, 0.0, _FLOORS) ** 2):
        worth = low[:, 1] - _FAR * np.maximum(0.0, floor - low[:, 0])
        kept |= set(np.argsort(-worth)[:_KEPT].tolist())
    return np.array(sorted(kept))


def _pooled(before: Array, found: Array) -> Array:
    """Scores of two runs as of one."""
    holds = before[:, 2:] + found[:, 2:]
    means = (before[:, :2] * before[:, 2:] + found[:, :2] * found[:, 2:]) / holds
    return np.concatenate([means, holds], axis=1)
