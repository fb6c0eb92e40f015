"""The benchmark: every task on every reservoir, over seeds."""

from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..reservoir import memory_capacity, nrmse, predict_held_out
from ..validation import whole_number
from .narma import AMPLITUDE, narma2, narma10
from .parity import parity
from .reservoirs import Reservoir, RESERVOIRS
from .streams import random_bits

DELAYS = 40
"""Delays over which capacities are summed."""

Entry = TypeVar("Entry")

Task = Callable[[NDArray[np.float64], NDArray[np.int64], int], float]
"""Takes states (length, features), the bits (length,) that drove them and the washout; gives a score."""


def _capacity(order: int) -> Task:
    # The parity of bits a delay ago is the parity stream delayed, so its capacity is a memory capacity.
    return lambda states, bits, washout: memory_capacity(states, parity(bits, order), DELAYS, washout=washout).corrected


def _narma(target: Callable[[ArrayLike], NDArray[np.float64]]) -> Task:
    return lambda states, bits, washout: nrmse(*predict_held_out(states[washout:], target(AMPLITUDE * bits)[washout:]))


TASKS: dict[str, Task] = {
    "memory capacity": _capacity(1),
    "NARMA-2 NRMSE": _narma(narma2),
    "NARMA-10 NRMSE": _narma(narma10),
    "parity-2 capacity": _capacity(2),
    "parity-3 capacity": _capacity(3),
}
"""The tasks known by name, each named with its score. Add your own.

A capacity is the corrected total of `memory_capacity` over delays 0 to ``DELAYS - 1``, the message being the
parity of as many consecutive bits as the name says (memory: of one). More is better. These targets are
uncorrelated, so the capacities of a reservoir sum to its number of features at most. Of an NRMSE less is better,
and 1 is what the mean scores. All are scored on the second half of what the washout leaves, by a readout fitted
on the first.
"""


class Score(NamedTuple):
    """What one reservoir scored on one task with one seed."""

    task: str
    reservoir: str
    seed: int
    value: float


class Summary(NamedTuple):
    """Mean and sample standard deviation over seeds (NaN for a single one)."""

    mean: float
    std: float
    seeds: int


def run_benchmark(
    *,
    tasks: Mapping[str, Task] | Iterable[str] = TASKS,
    reservoirs: Mapping[str, Reservoir] | Iterable[str] = RESERVOIRS,
    seeds: Iterable[int] = range(5),
    length: int = 4000,
    washout: int = 200,
) -> list[Score]:
    """Run every task on every reservoir, all driven by the same random bits.

    Parameters
    ----------
    tasks : mapping of str to Task, or iterable of str
        Functions by name, or names from `TASKS`.
    reservoirs : mapping of str to Reservoir, or iterable of str
        Functions by name, or names from `RESERVOIRS`.
    seeds : iterable of int
        One repetition each; a seed fixes the bits and the random weights.
    length : int, at least 1
        Bits in a repetition.
    washout : int, at least 0
        Bits at the start that are not scored.

    Returns
    -------
    list of Score
        In the order of seeds, reservoirs, tasks.

    Raises
    ------
    TypeError, ValueError
        If a name is unknown or an argument is invalid.
    """
    washout = whole_number("washout", washout, 0)
    chosen_tasks = _chosen("tasks", tasks, TASKS)
    chosen_reservoirs = _chosen("reservoirs", reservoirs, RESERVOIRS)
    scores = []
    for seed, (reservoir, drive) in product(seeds, chosen_reservoirs.items()):
        bits = random_bits(length, seed)
        states = drive(bits, seed)
        scores += [Score(task, reservoir, seed, score(states, bits, washout)) for task, score in chosen_tasks.items()]
    return scores


def summarize(scores: Iterable[Score]) -> dict[tuple[str, str], Summary]:
    """Average scores over seeds.

    Parameters
    ----------
    scores : iterable of Score

    Returns
    -------
    dict of (task, reservoir) to Summary
        In order of first appearance.
    """
    values: dict[tuple[str, str], list[float]] = {}
    for score in scores:
        values.setdefault((score.task, score.reservoir), []).append(score.value)
    return {
        key: Summary(float(np.mean(v)), float(np.std(v, ddof=1)) if len(v) > 1 else float("nan"), len(v))
        for key, v in values.items()
    }


def table(scores: Iterable[Score]) -> list[list[str]]:
    """Lay scores out as text, a row a task and a column a reservoir, under a row of headings.

    Parameters
    ----------
    scores : iterable of Score
        Every task on every reservoir, as from `run_benchmark`.

    Returns
    -------
    list of list of str
        Cells read "mean ± standard deviation", or "mean" for a single seed.
    """
    summaries = summarize(scores)
    tasks = dict.fromkeys(task for task, _ in summaries)
    reservoirs = list(dict.fromkeys(reservoir for _, reservoir in summaries))
    rows = [[task, *(_cell(summaries[task, reservoir]) for reservoir in reservoirs)] for task in tasks]
    return [["task", *reservoirs], *rows]


def _cell(summary: Summary) -> str:
    return f"{summary.mean:.2f}" + (f" ± {summary.std:.2f}" if summary.seeds > 1 else "")


def _chosen(
    argument: str, wanted: Mapping[str, Entry] | Iterable[str], registry: Mapping[str, Entry]
) -> Mapping[str, Entry]:
    if isinstance(wanted, Mapping):
        return wanted
    names = [wanted] if isinstance(wanted, str) else list(wanted)
    for name in names:
        if name not in registry:
            raise ValueError(f"{argument} must be among {list(registry)}, got {name!r}")
    return {name: registry[name] for name in names}
