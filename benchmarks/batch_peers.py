"""A thousand crawlers through the peers' word: a batch in `simulate` beside other people's loops and batches.

Run ``python benchmarks/batch_peers.py`` (``--rounds N`` for more turns; ``make peers`` installs heyoka). The trajectory
is that of `benchmarks/peers.py`, 200 holds of 1, and every solver has the loosest of its tolerances at which the foot's
error is below 1e-6 at the end, as it is at all tighter ones. In the first case all crawlers have the word itself, in
the second each begins it at another of its eight bits, so that they do not slip in step; feet are then judged by
`simulate` at 1e-14, whose error on the word itself is known. A loop's cost is that of one crawler. All works take turns
in one process; those on two cores are two processes, each with half of the crawlers, or two threads of `simulate`, and
their times are the wall's: on a machine that others use too, ``--cores 1`` leaves them out.
"""

import os

# One thread unless more are asked for: idle ones would take the processor from the next work. This must come before the
# libraries are imported.
os.environ["OMP_NUM_THREADS"] = "1"
os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ["MKL_NUM_THREADS"] = "1"

import argparse
import importlib
import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns
from numpy.typing import NDArray
from peer_solvers.comparison import ROUNDING
from peer_solvers.own import LIBRARY
from peer_solvers.problem import FOOT, GROUPS, HOLD, WORD

from stickslip.common.extras import MissingExtra
from stickslip.crawler import simulate

RESULTS = Path(__file__).parent / "results" / "batch_peers.json"
PAGE = Path(__file__).parents[1] / "docs" / "vector.md"
GOAL = 1e-6
CROWD, SOME = 1000, 40  # crawlers of a batch of ours, and of others' loops and batches
BITS = 8
CASES = ("in step", "out of step")
SETTINGS = {
    "scipy": [10.0**-n for n in range(6, 11)],
    "heyoka": [1e-3, 1e-6, 1e-9, 1e-12],
    "heyoka batch": [1e-3, 1e-6, 1e-9, 1e-12],
    LIBRARY: [10.0**-n for n in range(4, 11)],
}
OURS = f"{LIBRARY} batch"

Words = NDArray[np.int8]
Crowd = Callable[[Words], NDArray[np.float64]]


class Work(NamedTuple):
    """One way to move a crowd; `cores` that it may use."""

    name: str
    solver: str
    cores: int
    count: int  # crawlers


WORKS = (
    Work("SciPy RK45, a loop", "scipy", 1, 1),
    Work("heyoka, a loop", "heyoka", 1, SOME),
    Work("heyoka, a loop in each of two processes", "heyoka", 2, 2 * SOME),
    Work("heyoka, its batch mode", "heyoka batch", 1, SOME),
    Work("heyoka, its batch mode in each of two processes", "heyoka batch", 2, 2 * SOME),
    Work("`simulate`, a batch on one thread", LIBRARY, 1, CROWD),
    Work("`simulate`, a batch on two threads", LIBRARY, 2, CROWD),
)


def words(case: str, count: int) -> Words:
    """Schedules of a case, (count, holds)."""
    shifts = [0 if case == "in step" else i % BITS for i in range(count)]
    return np.array([np.roll(WORD, -shift) for shift in shifts])


@cache
def solver(name: str, tolerance: float) -> Crowd:
    """Feet that a solver gives for schedules, one core used."""
    if name == LIBRARY:
        return partial(_ours, tolerance=tolerance, threads=1)
    module = importlib.import_module(f"peer_solvers.with_{name.split()[0]}")
    if name == "heyoka batch":
        return module.batch_solver(tolerance)
    alone = next(
        each for each in module.contenders() if each.method in ("RK45", "Taylor") and each.tolerance == tolerance
    )
    return lambda crowd: np.array([alone.run(word).foot for word in crowd])


def _ours(crowd: Words, tolerance: float, threads: int) -> NDArray[np.float64]:
    return simulate(GROUPS, crowd, HOLD, tolerance=tolerance, threads=threads).foot[:, -1]


def error(name: str, tolerance: float) -> float:
    """Largest error of a foot after any of the words."""
    each = words("out of step", BITS)
    truths = simulate(GROUPS, each, HOLD, tolerance=1e-14).foot[:, -1]
    assert abs(truths[0] - FOOT) < ROUNDING
    return float(np.abs(solver(name, tolerance)(each) - truths).max())


def settings() -> Iterator[tuple[str, float, float]]:
    """Name, tolerance and error of every solver that is installed."""
    for name, tolerances in SETTINGS.items():
        best = None
        try:
            for tolerance in sorted(tolerances):
                if (found := error(name, tolerance)) > GOAL:
                    break
                best = tolerance, found
        except MissingExtra as missing:
            print(f"{name} is left out: {missing}")
            continue
        if best is None:
            raise ValueError(f"{name} must have a setting with an error below {GOAL:g}, has none")
        yield name, *best


def _half(name: str, tolerance: float, crowd: Words) -> float:
    return float(solver(name, tolerance)(crowd).sum())


def made(work: Work, tolerance: float, case: str, pool: ProcessPoolExecutor) -> Callable[[], object]:
    """The work as a call."""
    crowd = words(case, work.count)
    if work.solver == LIBRARY:
        return partial(_ours, crowd, tolerance, work.cores)
    if work.cores == 1:
        return partial(solver(work.solver, tolerance), crowd)
    halves = np.split(crowd, work.cores)
    return lambda: list(pool.map(partial(_half, work.solver, tolerance), halves))


def tables(results: dict[str, Any]) -> dict[str, str]:
    """Table of the page, by name."""
    threads = [row["cores"] for row in results["works"] if row["solver"] == LIBRARY]
    heads = [f"over the batch, {count} thread{'s' if count > 1 else ''}" for count in threads]
    lines = [
        f"| crawlers | solver | cores | error | us a crawler | {' | '.join(heads)} |",
        "|---|---|---:|---:|---:|" + "---:|" * len(heads),
    ]
    for case in CASES:
        for row in results["works"]:
            numbers = " | ".join(_cell(each) for each in (row[case]["us"], *row[case]["over ours"]))
            lines.append(f"| {case} | {row['name']} | {row['cores']} | {row['error']:.0e} | {numbers} |")
    return {"batch peers": "\n".join(lines)}


def _cell(quartile: list[float]) -> str:
    low, middle, high = (np.format_float_positional(each, 3, fractional=False, trim="-") for each in quartile)
    return f"{middle} [{low}, {high}]"


def main() -> None:
    """Measure, print and keep, and write the page's table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=11)
    parser.add_argument("--cores", type=int, default=2, choices=(1, 2), help="1 where others use the machine too")
    arguments = parser.parse_args()
    rounds = arguments.rounds
    chosen = {name: (tolerance, found) for name, tolerance, found in settings()}
    present = [work for work in WORKS if work.solver in chosen and work.cores <= arguments.cores]
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        works = {
            f"{work.name}, {case}": made(work, chosen[work.solver][0], case, pool) for case in CASES for work in present
        }
        for _ in range(3):  # either process has then made its solvers
            for work in works.values():
                work()
        elsewhere = [f"{work.name}, {case}" for case in CASES for work in present if work.cores > 1]
        seconds = take_turns(works, rounds, 15.0, elsewhere)
    ours = [work for work in present if work.solver == LIBRARY]
    rows = []
    for work in present:
        tolerance, found = chosen[work.solver]
        row: dict[str, Any] = {**work._asdict(), "tolerance": tolerance, "error": found}
        for case in CASES:
            times, *others = (
                {turn: 1e6 * second / each.count for turn, second in seconds[f"{each.name}, {case}"].items()}
                for each in (work, *ours)
            )
            ratios = [[times[turn] / other[turn] for turn in times if turn in other] for other in others]
            row[case] = {"us": quartiles(list(times.values())), "over ours": [quartiles(each) for each in ratios]}
        rows.append(row)
    results = {"machine": machine("scipy", "heyoka"), "rounds": rounds, "crawlers": CROWD, "works": rows}
    print(tables(results)["batch peers"])
    keep(RESULTS, results)
    refresh(PAGE, tables(results))


if __name__ == "__main__":
    main()
