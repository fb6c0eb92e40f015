"""The faults of one folder: which were tried already, the trials of the others, and what is kept of each."""

import math
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .operators import Mutant
from .records import added, Equivalents, fault_of, first_seen, key, known
from .relevance import tests_of
from .sampling import files_of
from .trials import digest, Laboratory, support

__all__ = ["FOLDERS", "Campaign", "shown"]

FOLDERS = (
    "common",
    "compiling",
    "reservoir",
    "crawler",
    "robot",
    "tasks",
    "envs",
    "train",
    "studies",
    "explore",
    "package",
)
"""From the ground up."""
_QUICKEST = 30  # trials a minute: none takes less than 2 seconds
Fault = tuple[str, Mutant]
Result = dict[str, Any]


@dataclass(frozen=True)
class Stamps:
    """Digests of the tests of now: a fault that a test file noticed is noticed as long as that file stays as it is.

    Parameters
    ----------
    each : mapping
        By test file.
    whole : str
        Of all.
    """

    each: Mapping[str, str]
    whole: str

    @classmethod
    def taken(cls, root: Path, tests: Sequence[str]) -> "Stamps":
        """Of test files, each with what it stands on."""
        each = {test: digest(root, [test, *support(root, [test])]) for test in tests}
        return cls(each, digest(root, [*tests, *support(root, tests)]))

    def of(self, result: Result) -> str:
        """The digest of the file that noticed the fault, or of all where none did."""
        return self.each.get(result["by"].partition("::")[0], self.whole)

    def good(self, result: Result) -> bool:
        """Whether a result was come to with the tests of now."""
        return bool(result["stamp"] == self.of(result))


@dataclass(frozen=True)
class Campaign:
    """Trials of the faults of a folder.

    Parameters
    ----------
    root : Path
        The checkout.
    trials : Path
        Where results are kept, a line each.
    equivalents : Equivalents
    folder : str
    tests : sequence of str, optional
        Test files; those of the folder if left out.
    thorough : bool
        Whether the tests of the folders above are run where those of the folder notice nothing.
    patience : float, optional
        As `Laboratory` takes it.
    """

    root: Path
    trials: Path
    equivalents: Equivalents
    folder: str
    tests: Sequence[str] | None = None
    thorough: bool = False
    patience: float | None = None

    def known(self, faults: Iterable[Fault]) -> Iterator[tuple[Fault, str, Result | None]]:
        """Faults, their keys, and what is known of each with the modules and tests of now."""
        done, first = known(self.trials), first_seen(self.trials)
        stamps = Stamps.taken(self.root, self._tests())
        sources: dict[str, str] = {}
        for file, mutant in faults:
            if file not in sources:
                sources[file] = digest(self.root, [file])
            name = key(file, mutant, sources[file])
            if self.equivalents.reason(file, mutant.before, mutant.after):
                yield (file, mutant), name, self._record(name, file, mutant, "equivalent")
            else:
                result = done.get(name)
                if result and stamps.good(result):
                    yield (file, mutant), name, result | {"first": first[fault_of(result)]}
                else:
                    yield (file, mutant), name, None

    def run(self, faults: Iterable[Fault], jobs: int = 1, minutes: float | None = None) -> list[Result]:
        """Try what is not known, say and keep what came of it, and give all results."""
        results, waiting = [], []
        stamps = Stamps.taken(self.root, self._tests())
        most = math.inf if minutes is None else 1 + _QUICKEST * minutes * jobs
        for (file, mutant), name, result in self.known(faults):
            if len(waiting) > most:
                break  # to draw a fault takes time, too
            if result is None or (self.thorough and result["status"] == "survived" and "above" not in result):
                waiting.append((name, file, mutant, result))
                continue
            results.append(result)
            if result["status"] == "survived":
                print(f"known: {_said(result, file, mutant)}")
        if not waiting:
            return results
        print(
            f"{self.folder}: {len(waiting)} to try, {len(results)} known; first the tests without a fault", flush=True
        )
        with Laboratory(self.root, self.trials.parent, jobs, self.patience) as laboratory:
            tests, modules = self._tests(), files_of(self.root, self.folder)
            untried = any(result is None for *_, result in waiting)
            baseline = laboratory.baseline(tests, modules) if untried else None
            above = [
                test for folder in FOLDERS[FOLDERS.index(self.folder) + 1 :] for test in tests_of(self.root, folder)
            ]
            baseline_above = laboratory.baseline(above, modules) if self.thorough and above else None

            helped: dict[str, set[str]] = defaultdict(set)
            for result in known(self.trials).values():
                helped[result["file"]].add(result.get("by", "").partition("::")[0])

            def tried(name: str, file: str, mutant: Mutant, result: Result | None) -> Result:
                if result is None:
                    assert baseline is not None
                    outcome, reached = laboratory.tried(file, mutant, tests, baseline, helped[file])
                    result = self._record(name, file, mutant, outcome.status)
                    result |= {"by": outcome.by, "seconds": round(outcome.seconds, 1), "reached": reached}
                    result["stamp"] = stamps.of(result)
                if result["status"] == "survived" and baseline_above is not None:
                    outcome, _ = laboratory.tried(file, mutant, above, baseline_above)
                    result = result | {"above": outcome.by}
                return result

            for result, file, mutant in _in_turn(waiting, tried, laboratory.stop, jobs, minutes):
                added(self.trials, result)
                results.append(result)
                helped[file].add(result.get("by", "").partition("::")[0])
                print(_said(result, file, mutant), flush=True)
        return results

    def _tests(self) -> Sequence[str]:
        return tests_of(self.root, self.folder) if self.tests is None else self.tests

    def _record(self, name: str, file: str, mutant: Mutant, status: str) -> Result:
        fault = {"kind": mutant.kind, "line": mutant.line, "before": mutant.before, "after": mutant.after}
        return {"key": name, "folder": self.folder, "file": file, **fault, "status": status, "reached": None}


def shown(file: str, mutant: Mutant) -> str:
    """A fault in the words of a reader: the place, the lines without it and with it."""
    before, after = (text.replace("\n", "\n        ") for text in (mutant.before, mutant.after))
    return f"{file}:{mutant.line} {mutant.kind}\n      - {before}\n      + {after}"


def _said(result: Result, file: str, mutant: Mutant) -> str:
    if result["status"] != "survived":
        return f"{result['status']} by {result['by']}: {file}:{mutant.line} {mutant.kind}"
    unreached = " (no test reaches the line)" if result["reached"] is False else ""
    above = f" (noticed by {result['above']})" if result.get("above") else ""
    return f"SURVIVED{unreached}{above} {shown(file, mutant)}"


def _in_turn(
    waiting: Sequence[tuple[str, str, Mutant, Result | None]],
    tried: Callable[[str, str, Mutant, Result | None], Result],
    stop: Callable[[], object],
    jobs: int,
    minutes: float | None,
) -> Iterator[tuple[Result, str, Mutant]]:
    """Trials as they end, with the time that is left said on standard error."""
    begin = time.monotonic()
    ended = 0
    upcoming = iter(waiting)
    running: dict[Future[Result], tuple[str, Mutant]] = {}
    with ThreadPoolExecutor(jobs) as pool:
        try:
            while True:
                while len(running) < jobs and (minutes is None or time.monotonic() - begin < 60 * minutes):
                    following = next(upcoming, None)
                    if following is None:
                        break
                    name, file, mutant, result = following
                    running[pool.submit(tried, name, file, mutant, result)] = file, mutant
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    ended += 1
                    spent = time.monotonic() - begin
                    left = spent / ended * (len(waiting) - ended)
                    if minutes is not None:
                        left = min(left, max(0.0, 60 * minutes - spent))
                    print(
                        f"[{ended} of {len(waiting)}, {left / 60:.0f} min left]", end=" ", file=sys.stderr, flush=True
                    )
                    file, mutant = running.pop(future)
                    yield future.result(), file, mutant
        except BaseException:
            stop()  # or the trials that go on would be waited for
            raise
