"""Timing in turns, the machine described, and results kept: what the benchmarks share."""

import json
import math
import os
import platform
import re
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from datetime import datetime, UTC
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.common.files import atomically
from stickslip.common.terminal import say_what_can_be_said

__all__ = ["keep", "machine", "quartiles", "refresh", "refreshed", "take_turns"]

say_what_can_be_said()  # all scripts import this module, and their tables hold signs that not every terminal knows

TURN = 0.01  # least seconds of work that one timing spans


def take_turns(
    works: Mapping[str, Callable[[], object]], rounds: int, budget: float = 60.0, elsewhere: Collection[str] = ()
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
    elsewhere : collection of str
        Works that other processes do: their times are the wall's.

    Returns
    -------
    dict
        By name and round.
    """
    repeats, every = {}, {}
    for name, work in works.items():
        once = _seconds(work, 1, name in elsewhere)
        repeats[name] = max(1, math.ceil(TURN / once))
        turns = max(min(3, rounds), min(rounds, int(budget / (once * repeats[name]))))
        every[name] = rounds // turns
    seconds: dict[str, dict[int, float]] = {name: {} for name in works}
    for turn in range(rounds):
        for name in list(works)[:: 1 if turn % 2 == 0 else -1]:
            if turn % every[name] == 0:
                seconds[name][turn] = _seconds(works[name], repeats[name], name in elsewhere)
    return seconds


def machine(*libraries: str) -> dict[str, Any]:
    """What the numbers were measured on and with; the version of a library that is not there is None."""
    versions: dict[str, str | None] = {}
    for library in ("stickslip", "numpy", "numba", *libraries):
        try:
            versions[library] = version(library)
        except PackageNotFoundError:
            versions[library] = None
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": versions,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.processor())


def keep(path: Path, results: Mapping[str, Any]) -> None:
    """Write results as JSON, whole or not at all."""
    atomically(path, lambda unfinished: unfinished.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8"))


def refreshed(page: str, made: Mapping[str, str]) -> str:
    """The page with every table between its marks, ``<!-- name -->`` and ``<!-- end -->``.

    Raises
    ------
    ValueError
        If a table has no place in the page.
    """
    for name, table in made.items():
        place = re.compile(rf"(<!-- {re.escape(name)} -->\n).*?(<!-- end -->)", re.DOTALL)
        page, found = place.subn(lambda match, table=table: f"{match[1]}{table}\n{match[2]}", page)
        if found != 1:
            raise ValueError(f"the page must have the marks of table {name!r} once, found them {found} times")
    return page


def refresh(page: Path, made: Mapping[str, str]) -> None:
    """Write tables into a page of the docs, between their marks."""
    text = refreshed(page.read_text(encoding="utf-8"), made)
    atomically(page, lambda unfinished: unfinished.write_text(text, encoding="utf-8"))


def quartiles(values: Sequence[float]) -> list[float]:
    """Lower quartile, median and upper quartile."""
    return [float(value) for value in np.quantile(values, [0.25, 0.5, 0.75])]


def _seconds(work: Callable[[], object], repeats: int, elsewhere: bool) -> float:
    wall, process = time.perf_counter(), time.process_time()
    for _ in range(repeats):
        work()
    wall, process = time.perf_counter() - wall, time.process_time() - process
    return (wall if elsewhere else min(wall, process)) / repeats
