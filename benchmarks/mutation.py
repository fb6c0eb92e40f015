"""Faults put into the code one at a time, and how many of them the tests notice.

Run ``python benchmarks/mutation.py --folder tasks --count 40 --seed 1``. Each fault is something that somebody could
have written: a comparison, sign or number that is off, an argument forgotten or in the wrong place, a label swapped, a
copy, refusal or store left out (`benchmarks/mutating/operators.py`). Lines are drawn alike, and a fault of each. It is
tried in a throw-away copy of the checkout, by the tests of its folder, those that reach its line first; with
``--thorough`` by those of the folders above too where nothing noticed. Results go to ``runs/mutation/trials.jsonl`` as
they come, and what was tried with the same module and tests is not tried again. ``--list`` only prints the faults;
``--changed main`` takes those of the lines changed since a revision. Without ``--folder`` or ``--only`` all folders are
tried, ``--minutes`` bounds each.

Why not a tool that is there: mutmut 3 calls every function through a trampoline that chooses the variant at run time,
which numba cannot compile, and copies the folders it is told without the links by which this package is put together.
cosmic-ray edits the checkout in place, where others work, and its operators know no forgotten argument, swapped label,
missing copy or missing refusal. Neither knows that kernels have to be kept apart by what they were compiled from.
"""

import argparse
import os
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

from mutating.operators import Mutant
from mutating.records import added, Equivalents, key, known
from mutating.relevance import tests_of
from mutating.sampling import changed_lines, drawn, files_of
from mutating.trials import digest, Laboratory, Outcome

ROOT = Path(__file__).parents[1]
TRIALS = ROOT / "runs" / "mutation" / "trials.jsonl"
EQUIVALENTS = Path(__file__).parent / "mutating" / "equivalent.toml"
FOLDERS = ("common", "compiling", "reservoir", "crawler", "tasks", "envs", "train", "studies", "package")
"""From the ground up."""
COUNT = 40
SUPPORT = ("tests/conftest.py", "tests/judges")


def main() -> None:
    """Try or list the faults that are asked for."""
    asked = arguments()
    equivalents = Equivalents.read(EQUIVALENTS)
    lines = changed_lines(ROOT, asked.changed) if asked.changed else None
    for folder, files in places(asked):
        faults = islice(drawn(ROOT, files, asked.seed, lines), asked.count)
        if asked.list:
            for file, mutant in faults:
                print(shown(file, mutant))
        else:
            try_all(folder, list(faults), asked, equivalents)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Put faults into the code and see whether the tests notice.")
    parser.add_argument("--folder", choices=FOLDERS, help="faults in this folder; all folders if left out")
    parser.add_argument("--only", metavar="FILE", action="append", help="faults in this file; may be repeated")
    parser.add_argument("--changed", metavar="REV", help="faults in lines changed since this revision")
    parser.add_argument("--count", type=int, help=f"faults by folder ({COUNT}, or no bound with --minutes)")
    parser.add_argument("--minutes", type=float, help="begin no trial in a folder after so many minutes of trials")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tests", metavar="FILE", nargs="+", help="run these test files instead of the folder's")
    parser.add_argument("--thorough", action="store_true", help="then run the tests of the folders above, too")
    parser.add_argument("--jobs", type=int, default=1, help="trials at once")
    parser.add_argument("--list", action="store_true", help="print the faults and try none")
    asked = parser.parse_args()
    if asked.count is None and asked.minutes is None and not asked.list:
        asked.count = COUNT
    return asked


def places(asked: argparse.Namespace) -> Iterator[tuple[str, list[str]]]:
    """The folders that are asked for, and their modules."""
    if asked.only:
        only = [Path(os.path.relpath(Path(file).resolve(), ROOT.resolve())).as_posix() for file in asked.only]
    for folder in [asked.folder] if asked.folder else FOLDERS:
        files = files_of(ROOT, folder)
        if asked.only:
            files = [file for file in files if file in only]
        if files:
            yield folder, files


def shown(file: str, mutant: Mutant) -> str:
    """A fault in the words of a reader: the place, the lines without it and with it."""
    before, after = (text.replace("\n", "\n        ") for text in (mutant.before, mutant.after))
    return f"{file}:{mutant.line} {mutant.kind}\n      - {before}\n      + {after}"


def try_all(
    folder: str, faults: Sequence[tuple[str, Mutant]], asked: argparse.Namespace, equivalents: Equivalents
) -> None:
    """Try faults of one folder, and keep and say what came of each."""
    with Laboratory(ROOT, TRIALS.parent, asked.jobs) as laboratory:
        tests = asked.tests or tests_of(laboratory.tree, folder)
        support = [
            path.relative_to(laboratory.tree).as_posix()
            for place in SUPPORT
            for path in ([laboratory.tree / place] if place.endswith(".py") else (laboratory.tree / place).glob("*"))
            if path.is_file()
        ]
        stamp = digest(laboratory.tree, [*tests, *support], repr(asked.thorough))
        done = known(TRIALS)
        results = []
        waiting = []
        for file, mutant in faults:
            name = key(file, mutant, digest(laboratory.tree, [file]), stamp)
            reason = equivalents.reason(file, mutant.before, mutant.after)
            if reason:
                results.append("equivalent")
            elif name in done:
                results.append(done[name]["status"])
                if done[name]["status"] == "survived":
                    print(f"survived (known) {shown(file, mutant)}")
            else:
                waiting.append((name, file, mutant))
        if waiting:
            print(f"{folder}: {len(waiting)} faults to try, {len(results)} known; first the tests without a fault")
            baseline = laboratory.baseline(tests)
            above = [test for each in FOLDERS[FOLDERS.index(folder) + 1 :] for test in tests_of(laboratory.tree, each)]

            def tried(file: str, mutant: Mutant) -> tuple[Outcome, bool | None]:
                outcome, was_reached = laboratory.tried(file, mutant, tests, baseline)
                if outcome.status == "survived" and asked.thorough and above:
                    outcome, _ = laboratory.tried(file, mutant, above, baseline)
                return outcome, was_reached

            for name, file, mutant, outcome, was_reached in in_turn(waiting, tried, asked.jobs, asked.minutes):
                added(TRIALS, record(name, folder, file, mutant, outcome, was_reached, asked, tests))
                results.append(outcome.status)
                unreached = " (no test reaches the line)" if was_reached is False else ""
                if outcome.status == "survived":
                    print(f"SURVIVED{unreached} {shown(file, mutant)}", flush=True)
                else:
                    print(f"{outcome.status} by {outcome.by}: {file}:{mutant.line} {mutant.kind}", flush=True)
        noticed = sum(status in ("noticed", "hung") for status in results)
        counted = sum(status != "equivalent" for status in results)
        print(f"{folder}: {noticed} of {counted} noticed, {len(results) - counted} equivalent", flush=True)


def record(
    name: str,
    folder: str,
    file: str,
    mutant: Mutant,
    outcome: Outcome,
    was_reached: bool | None,
    asked: argparse.Namespace,
    tests: Sequence[str],
) -> dict[str, Any]:
    """What is kept of a trial."""
    fault = {"kind": mutant.kind, "line": mutant.line, "before": mutant.before, "after": mutant.after}
    run = {"seed": asked.seed, "thorough": asked.thorough, "own tests": asked.tests is None, "tests": len(tests)}
    return {"key": name, "folder": folder, "file": file, **fault, **asdict(outcome), "reached": was_reached, **run}


def in_turn(
    waiting: Sequence[tuple[str, str, Mutant]], tried: Any, jobs: int, minutes: float | None
) -> Iterator[tuple[str, str, Mutant, Outcome, bool | None]]:
    """Trials as they end, with the time that is left said on standard error."""
    begin = time.monotonic()
    ended = 0
    upcoming = iter(waiting)
    running: dict[Future[tuple[Outcome, bool | None]], tuple[str, str, Mutant]] = {}
    with ThreadPoolExecutor(jobs) as pool:
        while True:
            while len(running) < jobs and (minutes is None or time.monotonic() - begin < 60 * minutes):
                following = next(upcoming, None)
                if following is None:
                    break
                _, file, mutant = following
                running[pool.submit(tried, file, mutant)] = following
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                ended += 1
                spent = time.monotonic() - begin
                left = spent / ended * (len(waiting) - ended)
                if minutes is not None:
                    left = min(left, max(0.0, 60 * minutes - spent))
                print(f"[{ended}/{len(waiting)}, {left / 60:.0f} min left]", end=" ", file=sys.stderr, flush=True)
                yield *running.pop(future), *future.result()


if __name__ == "__main__":
    main()
