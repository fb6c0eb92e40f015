"""``stickslip bench``: tasks and measures on reservoirs over seeds, kept as they finish."""

import json
from collections.abc import Collection, Iterator, Mapping
from concurrent.futures import as_completed
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, cast

from ...common.figures import save_figure
from ...common.files import write_text
from ...common.threads import library_threads
from ...common.validation import known_names, whole_number
from ...common.workers import worker_processes
from ...envs.specification import plain_arguments
from ...reservoir import Estimate
from ...tasks import BodyReservoir, known_reservoirs, Reservoir, SeriesTask, Task
from . import STANDARD_TASKS
from .attempts import attempts, chosen
from .figures import plot_information, plot_predictions, plot_profiles, plot_scores, plot_sweep
from .probe import probes
from .records import Record, Records
from .report import as_json, as_markdown, as_rows, estimates, KNOWN, paired_differences
from .sweep import parse_sweep, with_value

__all__ = ["Bench"]

_FINISHED = "finished"


@dataclass(frozen=True)
class _Unit:
    """What one process does at a stretch: all tasks on some reservoirs with one seed."""

    folder: Path
    made_for: dict[str, Any]
    tasks: Mapping[str, Task]
    reservoirs: Mapping[str, Reservoir]
    seed: int
    length: int
    washout: int
    done: Collection[tuple[str, str, int]]

    @property
    def left(self) -> int:
        """Attempts that are not done."""
        return sum((title, name, self.seed) not in self.done for title, name in product(self.tasks, self.reservoirs))

    def finish(self) -> Iterator[Record]:
        """Make every attempt that is left, and keep it."""
        records = Records(self.folder / _FINISHED, self.made_for, resume=True)
        with library_threads(1):
            for record in attempts(
                self.tasks,
                self.reservoirs,
                [self.seed],
                length=self.length,
                washout=self.washout,
                done=self.done,
            ):
                records.keep(record)
                yield record


class Bench:
    """A benchmark in a folder.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    tasks, reservoirs : str or None
        Names with commas between them, or "all". None takes all of them; of a sweep, the tasks of the standard
        benchmark.
    sweep : str or None
        A number of the crawler and its values, such as ``hold=0.25,0.5,1``, instead of reservoirs by name.
    seeds : int, at least 1
        Seeds 0 to ``seeds - 1``.
    features : int
        Of every reservoir; at least 3 and a multiple of it.
    length, washout : int
        Samples of a repetition, and those at its start that are not scored.
    body : mapping
        Arguments of `BodyReservoir` for all bodies.
    against : str or None
        The reservoir (or swept value, such as ``hold = 0.5``) that the others are compared with, draw by draw; the
        first one by default.
    resume : bool
        Whether to go on with what the folder holds. It must have been made with the same settings, tasks, measures
        and reservoirs; tasks, reservoirs, seeds and swept values may be added.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, or the folder holds what does not fit.
    """

    def __init__(
        self,
        folder: Path,
        *,
        tasks: str | None = None,
        reservoirs: str | None = None,
        sweep: str | None = None,
        seeds: int = 15,
        features: int = 12,
        length: int = 4000,
        washout: int = 200,
        body: Mapping[str, Any] | None = None,
        against: str | None = None,
        resume: bool = False,
    ) -> None:
        self.folder = folder
        given = body or {}
        body = plain_arguments(given)
        self._seeds = range(whole_number("--seeds", seeds, 1))
        self._length = whole_number("--length", length, 1)
        self._washout = whole_number("--washout", washout, 0)
        wanted = ",".join(STANDARD_TASKS) if tasks is None and sweep is not None else tasks
        self._tasks = chosen("--tasks", _names(wanted, KNOWN), KNOWN)
        known = known_reservoirs(whole_number("--features", features, 3), **body)
        self._swept: tuple[str, list[float]] | None = None
        if sweep is None:
            self._reservoirs = chosen("--reservoirs", _names(reservoirs, known), known)
        elif reservoirs is not None:
            raise ValueError(f"--reservoirs must be left out where --sweep is given, got {reservoirs!r}")
        else:
            name, values = parse_sweep(sweep)
            _refuse_given_twice(name, given)
            self._swept = name, list(values)
            crawler = cast(BodyReservoir, known["crawler"])
            self._reservoirs = {f"{name} = {value:.12g}": with_value(crawler, name, value) for value in values}
        self._settings = {
            "features": features,
            "length": length,
            "washout": washout,
            "sweep": None if self._swept is None else self._swept[0],
            "hold": cast(BodyReservoir, known["crawler"]).hold,
            **body,
        }
        self.against = next(iter(self._reservoirs)) if against is None else against
        known_names("--against", [self.against], tuple(self._reservoirs))
        self._made_for = {**self._settings, **probes(self._tasks, self._reservoirs)}
        self._records = Records(folder / _FINISHED, self._made_for, resume=resume)

    @property
    def total(self) -> int:
        """Attempts that the benchmark asks for."""
        return len(self._tasks) * len(self._reservoirs) * len(self._seeds)

    def run(self, processes: int = 1) -> Iterator[int]:
        """Make what is not finished yet.

        Parameters
        ----------
        processes : int, at least 1
            To share the work among; each takes a reservoir and a seed at a time. One takes all reservoirs of a seed,
            whose bodies it moves as one batch.

        Yields
        ------
        int
            Attempts that are finished so far: at first those that were before.
        """
        processes = whole_number("--processes", processes, 1)
        done = self._records.load().keys() & set(product(self._tasks, self._reservoirs, self._seeds))
        shares = [self._reservoirs] if processes == 1 else [{name: each} for name, each in self._reservoirs.items()]
        units = [
            _Unit(self.folder, self._made_for, self._tasks, some, seed, self._length, self._washout, done)
            for seed, some in product(self._seeds, shares)
        ]
        finished = len(done)
        yield finished
        if processes == 1:
            for unit in units:
                for _ in unit.finish():
                    finished += 1
                    yield finished
            return
        with worker_processes(processes) as pool:
            futures = [pool.submit(_finish, unit) for unit in units if unit.left]
            for future in as_completed(futures):
                finished += future.result()
                yield finished

    def report(self) -> tuple[list[list[str]], list[list[str]]]:
        """Write JSON, the tables and the figures.

        Returns
        -------
        scores, differences : list of list of str
            Two tables, each under a row of headings; the second without any where there is one reservoir alone.
        """
        kept = self._records.load()
        records = [kept[key] for key in product(self._tasks, self._reservoirs, self._seeds)]
        found = estimates(records, self._tasks, self._reservoirs)
        paired = paired_differences(records, self.against)
        rows, compared = as_rows(found, self._tasks), as_rows(paired, self._tasks, signed=True) if paired else []
        inputs = {
            **self._settings,
            "tasks": list(self._tasks),
            "reservoirs": {name: repr(reservoir) for name, reservoir in self._reservoirs.items()},
            "seeds": list(self._seeds),
            "against": self.against,
        }
        told = {
            **as_json(records, found, paired, inputs),
            "made for": {name: self._made_for[name] for name in ("tasks", "reservoirs")},
        }
        text = json.dumps(told, indent=1) + "\n"
        write_text(self.folder / "benchmark.json", text)
        page = as_markdown(rows) + "\n"
        if compared:
            page += f"\nDifferences from {self.against} on the same draws:\n\n{as_markdown(compared)}\n"
        write_text(self.folder / "table.md", page)
        for name, figure in self._figures(records, found, paired):
            save_figure(figure, self.folder / f"{name}.png")
        return rows, compared

    def _figures(
        self,
        records: list[Record],
        found: Mapping[tuple[str, str], Estimate],
        paired: Mapping[tuple[str, str], Estimate],
    ) -> Iterator[tuple[str, Any]]:
        if self._swept is not None:
            name, values = self._swept
            by_task = {title: [found[title, reservoir] for reservoir in self._reservoirs] for title in self._tasks}
            yield "sweep", plot_sweep(name, values, by_task, self._tasks)
            return
        yield "scores", plot_scores(found, self._tasks)
        if paired:
            yield "differences", plot_scores(paired, self._tasks, against=self.against)
        series = [title for title, task in self._tasks.items() if isinstance(task, SeriesTask)]
        for name, wanted, plot in (
            ("profiles", [record for record in records if "profile" in record.details], plot_profiles),
            ("information", [record for record in records if "by degree" in record.details], plot_information),
            ("predictions", [r for r in records if r.task in series and "prediction" in r.details], plot_predictions),
        ):
            if wanted:
                yield name, plot(wanted)


def _refuse_given_twice(swept: str, body: Mapping[str, Any]) -> None:
    """Refuse a number that is given as well as swept."""
    parts = (body.get(part) for part in ("groups", "scene"))
    given = {name: value for part in parts if isinstance(part, Mapping) for name, value in part.items()} | dict(body)
    if swept in given:
        raise ValueError(f"{swept} must be left out where --sweep sets it, got {given[swept]!r}")


def _finish(unit: _Unit) -> int:
    return sum(1 for _ in unit.finish())


def _names(text: str | None, known: Mapping[str, object]) -> list[str]:
    """Names from a list with commas, which no name has."""
    if text is None or text.strip() == "all":
        return list(known)
    names = list(dict.fromkeys(name.strip() for name in text.split(",")))
    return [name for name in names if name] or [text]
