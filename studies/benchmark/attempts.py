"""The benchmark: every task on every reservoir, over seeds."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import TypeVar

from ...common.threads import library_threads
from ...common.validation import whole_number
from ...tasks.catalogue import TASKS
from ...tasks.reservoirs import Reservoir, RESERVOIRS
from ...tasks.reservoirs.together import drive_together, Remembering
from ...tasks.task import SeriesTask, Task
from .records import Record

__all__ = ["STANDARD_RESERVOIRS", "STANDARD_TASKS", "attempts", "chosen", "run_benchmark"]

STANDARD_TASKS = ("memory capacity", "NARMA-2 NRMSE", "NARMA-10 NRMSE", "parity-2 capacity", "parity-3 capacity")
"""What is run unless said otherwise."""

STANDARD_RESERVOIRS = ("crawler", "delay line", "echo-state network")
"""Likewise."""

Entry = TypeVar("Entry")


def run_benchmark(
    *,
    tasks: Mapping[str, Task] | Iterable[str] = STANDARD_TASKS,
    reservoirs: Mapping[str, Reservoir] | Iterable[str] = STANDARD_RESERVOIRS,
    seeds: Iterable[int] = range(5),
    length: int = 4000,
    washout: int = 200,
) -> list[Record]:
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
    list of Record
        In the order of seeds, reservoirs, tasks.

    Raises
    ------
    TypeError, ValueError
        If a name is unknown or an argument is invalid.
    """
    with library_threads(1):
        return list(
            attempts(
                chosen("tasks", tasks, TASKS),
                chosen("reservoirs", reservoirs, RESERVOIRS),
                seeds,
                length=whole_number("length", length, 1),
                washout=whole_number("washout", washout, 0),
            )
        )


def attempts(
    tasks: Mapping[str, Task],
    reservoirs: Mapping[str, Reservoir],
    seeds: Iterable[int],
    *,
    length: int,
    washout: int,
    done: Collection[tuple[str, str, int]] = (),
) -> Iterator[Record]:
    """Try every task on every reservoir, one after the other as they are asked for.

    Parameters
    ----------
    tasks, reservoirs, seeds, length, washout
        As in `run_benchmark`, but for the names.
    done : collection of (task, reservoir, seed)
        Left out.

    Yields
    ------
    Record
        In the order of seeds, reservoirs, tasks.
    """
    for seed in seeds:
        left = {
            name: {title: task for title, task in tasks.items() if (title, name, seed) not in done}
            for name in reservoirs
        }
        remembering = {name: Remembering(reservoir) for name, reservoir in reservoirs.items()}
        drive_together(
            (remembering[name], task.drive(length, seed), seed)
            for name, wanted in left.items()
            for task in wanted.values()
            if isinstance(task, SeriesTask)
        )
        for name, wanted in left.items():
            for title, task in wanted.items():
                solution = task.attempt(remembering[name], length=length, seed=seed, washout=washout)
                yield Record.of(title, name, seed, solution)
            del remembering[name]  # and its states


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
