"""Timing in turns: round after round in one process, so that the machine's drift falls on all alike."""

import math
import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

__all__ = ["quartiles", "take_turns"]

TURN = 0.01  # least seconds of work that one timing spans


def take_turns(
    works: Mapping[str, Callable[[], object]], rounds: int, budget: float = 60.0
) -> dict[str, dict[int, float]]:
    """Seconds that each work took, by round.

    A time is the lesser of the wall's and the process's: on a machine that others use too a wait for the processor
    would count, and with more than one thread so would what is done at once. Every other round runs backward.

    Parameters
    ----------
    works : mapping
        By name; each has been called before, so that it is compiled and its caches are full.
    rounds : int
        Of the works that take least.
    budget : float
        Seconds after which a work sits rounds out; it has three at least.

    Returns
    -------
    dict
        By name and round.
    """
    repeats, every = {}, {}
    for name, work in works.items():
        once = _seconds(work, 1)
        repeats[name] = max(1, math.ceil(TURN / once))
        turns = max(min(3, rounds), min(rounds, int(budget / (once * repeats[name]))))
        every[name] = rounds // turns
    seconds: dict[str, dict[int, float]] = {name: {} for name in works}
    for turn in range(rounds):
        for name in list(works)[:: 1 if turn % 2 == 0 else -1]:
            if turn % every[name] == 0:
                seconds[name][turn] = _seconds(works[name], repeats[name])
    return seconds


def quartiles(values: Sequence[float]) -> list[float]:
    """Lower quartile, median and upper quartile."""
    return [float(value) for value in np.quantile(values, [0.25, 0.5, 0.75])]


def _seconds(work: Callable[[], object], repeats: int) -> float:
    wall, process = time.perf_counter(), time.process_time()
    for _ in range(repeats):
        work()
    return min(time.perf_counter() - wall, time.process_time() - process) / repeats
