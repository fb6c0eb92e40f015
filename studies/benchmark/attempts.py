"""The benchmark: every task on every reservoir, over seeds."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import product
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...common.threads import one_thread
from ...common.validation import whole_number
from ...tasks.catalogue import TASKS
from ...tasks.reservoirs import Reservoir, RESERVOIRS
from ...tasks.task import Solution, Task

STANDARD_TASKS = ("memory capacity", "NARMA-2 NRMSE", "NARMA-10 NRMSE", "parity-2 capacity", "parity-3 capacity")
"""What is run unless said otherwise."""

STANDARD_RESERVOIRS = ("crawler", "delay line", "echo-state network")
"""Likewise."""

Entry = TypeVar("Entry")


class Score(NamedTuple):
    """What one reservoir scored on one task with one seed."""

    task: str
    reservoir: str
    seed: int
    value: float


class Attempt(NamedTuple):
    """What one reservoir made of one task with one seed."""

    task: str
    reservoir: str
    seed: int
    solution: Solution


class Summary(NamedTuple):
    """Mean and sample standard deviation over seeds (NaN for a single one)."""

    mean: float
    std: float
    seeds: int


def run_benchmark(
    *,
    tasks: Mapping[str, Task] | Iterable[str] = STANDARD_TASKS,
    reservoirs: Mapping[str, Reservoir] | Iterable[str] = STANDARD_RESERVOIRS,
    seeds: Iterable[int] = range(5),
    length: int = 4000,
    washout: int = 200,
) -> list[Score]:
    """Run every task on every reservoir, each driven by the same inputs.

    Parameters
    ----------
    tasks : mapping of str to Task, or iterable of str
        Tasks by name, or names from `TASKS`.
    reservoirs : mapping of str to Reservoir, or iterable of str
        Reservoirs by name, or names from `RESERVOIRS`. One with `candidates` is tuned for each task and seed.
    seeds : iterable of int
        One repetition each; a seed fixes the inputs and the random weights.
    length : int, at least 1
        Samples in a repetition.
    washout : int, at least 0
        Samples at the start that are not scored.

    Returns
    -------
    list of Score
        In the order of seeds, reservoirs, tasks.

    Raises
    ------
    TypeError, ValueError
        If a name is unknown or an argument is invalid.
    """
    with one_thread():
        return [
            Score(task, reservoir, seed, solution.score)
            for task, reservoir, seed, solution in attempts(
                chosen("tasks", tasks, TASKS),
                chosen("reservoirs", reservoirs, RESERVOIRS),
                seeds,
                length=whole_number("length", length, 1),
                washout=whole_number("washout", washout, 0),
            )
        ]


def attempts(
    tasks: Mapping[str, Task],
    reservoirs: Mapping[str, Reservoir],
    seeds: Iterable[int],
    *,
    length: int,
    washout: int,
    done: Collection[tuple[str, str, int]] = (),
) -> Iterator[Attempt]:
    """Try every task on every reservoir, one after the other as they are asked for.

    Parameters
    ----------
    tasks, reservoirs, seeds, length, washout
        As in `run_benchmark`, but for the names.
    done : collection of (task, reservoir, seed)
        Left out.

    Yields
    ------
    Attempt
        In the order of seeds, reservoirs, tasks.
    """
    for seed, (name, reservoir) in product(seeds, reservoirs.items()):
        remembering = _Remembering(reservoir)
        for title, task in tasks.items():
            if (title, name, seed) not in done:
                solution = task.attempt(remembering, length=length, seed=seed, washout=washout)
                yield Attempt(title, name, seed, solution)


class _Remembering:
    """A reservoir that is driven once by each series, however many tasks share it."""

    def __init__(self, reservoir: Reservoir) -> None:
        self._reservoir = reservoir
        self._states: dict[tuple[bytes, int], NDArray[np.float64]] = {}
        self.candidates = [_Remembering(candidate) for candidate in getattr(reservoir, "candidates", ())]

    def __call__(self, series: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
        key = series.tobytes(), seed
        if key not in self._states:
            self._states[key] = self._reservoir(series, seed)
        return self._states[key]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._reservoir, name)


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


def chosen(
    argument: str, wanted: Mapping[str, Entry] | Iterable[str], registry: Mapping[str, Entry]
) -> Mapping[str, Entry]:
    """Entries by name: those given, or those of a registry whose names are given."""
    if isinstance(wanted, Mapping):
        return wanted
    names = [wanted] if isinstance(wanted, str) else list(wanted)
    for name in names:
        if name not in registry:
            raise ValueError(f"{argument} must be among {list(registry)}, got {name!r}")
    return {name: registry[name] for name in names}
