"""Runs of the tests in throw-away copies of the checkout, without a fault and with one."""

import hashlib
import json
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from .checkout import copied, kept_kernels, twin
from .operators import Mutant
from .relevance import able, ordered, reached
from .watch import AT_IMPORT

__all__ = ["Laboratory", "Outcome", "digest"]

MEMORY = 6 << 30  # bytes
MORE = 20.0  # seconds of processor time that a test may take beyond ten times what it does
COMPILING = 150.0  # likewise where kernels may have to be compiled anew
AHEAD = 3  # test files that run before the others are collected
WALL = 3600.0  # seconds, without a fault
LONGEST = 600.0  # seconds beyond ten times the usual, for what waits without working


@dataclass(frozen=True)
class Outcome:
    """What one run of the tests gave.

    Parameters
    ----------
    status : str
        "noticed", "hung" (which is noticed too) or "survived".
    by : str
        The test that failed first, or how the process ended; empty if all passed.
    seconds : float
        Wall time.
    """

    status: str
    by: str
    seconds: float


class Laboratory:
    """A copy of the checkout, and what the tests do there without faults.

    Parameters
    ----------
    root : Path
        The checkout.
    kept : Path
        Folder for what the tests did without faults, good as long as no source changes.
    jobs : int
        Runs at once.
    patience : float, optional
        Seconds of processor time that a test may take beyond ten times what it takes without a fault; if left out
        20, or 150 where kernels may have to be compiled anew.

    Use it as a context: the copies are gone afterwards.
    """

    def __init__(self, root: Path, kept: Path, jobs: int = 1, patience: float | None = None) -> None:
        self.root = root
        self.kept = kept
        self.jobs = jobs
        self.patience = patience
        self._nurseries: queue.Queue[Nursery] = queue.Queue()
        self._all: list[Nursery] = []
        self._sound: set[str] = set()
        self._environment = {
            **os.environ,
            "PYTHONWARNDEFAULTENCODING": "1",
            "CI": "1",
            "HYPOTHESIS_PROFILE": "ci",
            "OMP_NUM_THREADS": "1",
        }
        self._environment.pop("NUMBA_CACHE_DIR", None)

    def __enter__(self) -> "Laboratory":
        self._folder = Path(tempfile.mkdtemp(prefix="stickslip-mutation-"))
        self.tree = self._folder / "checkout"
        copied(self.root, self.tree)
        # Alone: in its folder lie scripts that would hide modules of Python.
        self._plugins = self._folder / "plugins"
        self._plugins.mkdir()
        shutil.copy(Path(__file__).with_name("watch.py"), self._plugins / "mutation_watch.py")
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        shutil.rmtree(self._folder, ignore_errors=True)

    def baseline(self, tests: Sequence[str], modules: Sequence[str]) -> Path:
        """What tests do without faults, as a file of JSON; what a test file does is kept as long as it stays as it is.

        Parameters
        ----------
        tests, modules : sequence of str
            Files, relative to the checkout: those that judge, and those that the faults are in.

        Raises
        ------
        RuntimeError
            If a test fails.
        """
        stands = {test: digest(self.tree, [test, *support(self.tree, [test])]) for test in tests}
        parts = {test: self.kept / "baselines" / f"{stamp}.json" for test, stamp in stands.items()}
        missing = [test for test, part in parts.items() if not part.exists()]
        sources = {file: digest(self.tree, [file]) for file in modules}
        self._prepare(tests)
        if missing:
            whole = self._folder / "traced.json"
            code, words = self._pytest(self.tree, missing, whole, traced=True)
            report = (
                json.loads(whole.read_text(encoding="utf-8")) if whole.exists() else {"failed": [], "package": None}
            )
            if report["package"] not in (None, f"{self.tree}/src/stickslip/__init__.py"):
                raise RuntimeError(f"the tests import another stickslip: {report['package']}")
            kept_kernels(self.tree, self.root)
            failed = {name.partition("::")[0] for name in report["failed"]}
            for test in missing if code in (0, 1) else ():
                if test in failed:
                    continue
                parts[test].parent.mkdir(parents=True, exist_ok=True)
                parts[test].write_text(json.dumps(part_of(report, test) | {"sources": sources}), encoding="utf-8")
            if code != 0:
                failing = ", ".join(report["failed"]) or code
                raise RuntimeError(f"the tests fail without any fault: {failing}\n{words}")
        path = self._folder / f"baseline-{digest(self.tree, tests)}.json"
        known = [json.loads(part.read_text(encoding="utf-8")) for part in parts.values()]
        stale = [file for file in modules if any(part["sources"].get(file) != sources[file] for part in known)]
        path.write_text(json.dumps(joined(known) | {"stale": stale}), encoding="utf-8")
        return path

    def _prepare(self, tests: Sequence[str]) -> None:
        """Have processes ready that have imported what collecting the tests imports of others."""
        self._have(1, ["pytest"])
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            report = Path(folder) / "report.json"
            code, words = self._pytest(self.tree, tests, report, "--collect-only")
            if code != 0:
                raise RuntimeError(f"the tests cannot be collected:\n{words}")
            modules = json.loads(report.read_text(encoding="utf-8"))["modules"]
        self._have(self.jobs, modules)

    def _have(self, count: int, modules: Sequence[str]) -> None:
        self.stop()
        self._nurseries = queue.Queue()
        self._all = [Nursery(modules, self._environment) for _ in range(count)]
        for nursery in self._all:
            self._nurseries.put(nursery)

    def stop(self) -> None:
        """End the processes, and the runs that go on in them."""
        for nursery in self._all:
            nursery.close()

    def tried(
        self, file: str, mutant: Mutant, tests: Sequence[str], baseline: Path, helped: Collection[str] = ()
    ) -> tuple[Outcome, bool | None]:
        """Run what tests can notice a fault: what came of it, and whether one runs the line (None: nobody knows)."""
        usual = json.loads(baseline.read_text(encoding="utf-8"))
        order = ordered(self.tree, usual, file, mutant, able(self.tree, usual, file, mutant, tests), helped)
        begin = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="trial-", dir=self._folder, ignore_cleanup_errors=True) as folder:
            tree = Path(folder) / "checkout"
            twin(self.tree, tree)
            text = (tree / file).read_bytes()
            (tree / file).unlink()
            (tree / file).write_bytes(mutant.applied(text))
            report = Path(folder) / "report.json"
            more = _patience(file, text) if self.patience is None else self.patience
            wall = LONGEST + 10.0 * sum(usual["seconds"].values())
            code, failed = 0, []
            # To collect the tests takes longer than most of them: those that are likely to notice go ahead.
            for part in filter(None, (order[:AHEAD], order[AHEAD:])):
                report.unlink(missing_ok=True)
                code, _ = self._pytest(tree, part, report, "-x", usual=baseline, more=more, wall=wall)
                code = 0 if code == pytest.ExitCode.NO_TESTS_COLLECTED else code  # all of them are slow ones
                failed = json.loads(report.read_text(encoding="utf-8"))["failed"] if report.exists() else []
                if code != 0:
                    break
        seconds = time.monotonic() - begin
        if failed:
            self._refuse_unless_sound(failed[0], baseline)
        if code == 0:
            return Outcome("survived", "", seconds), reached(usual, file, mutant)
        if code in (-signal.SIGPROF, -signal.SIGKILL):
            return Outcome("hung", signal.Signals(-code).name, seconds), reached(usual, file, mutant)
        return Outcome("noticed", failed[0] if failed else f"exit {code}", seconds), reached(usual, file, mutant)

    def _refuse_unless_sound(self, test: str, baseline: Path) -> None:
        """A test is believed that passes without a fault, too: what was kept of it may be older than other modules."""
        if test in self._sound:
            return
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            report = Path(folder) / "report.json"
            options = [] if "::" in test else ["--collect-only"]
            code, words = self._pytest(self.tree, [test], report, *options, usual=baseline)
        # A test that only the fault made is not there without it, and of a file of slow tests none is collected.
        if code not in (0, pytest.ExitCode.USAGE_ERROR, pytest.ExitCode.NO_TESTS_COLLECTED):
            raise RuntimeError(f"the tests fail without any fault: {test}\n{words}")
        self._sound.add(test)

    def _pytest(
        self,
        tree: Path,
        tests: Sequence[str],
        report: Path,
        *options: str,
        traced: bool = False,
        usual: Path | None = None,
        more: float = 0.0,
        wall: float = WALL,
    ) -> tuple[int, str]:
        """Exit code and last words of a run of the tests."""
        report.parent.mkdir(parents=True, exist_ok=True)
        asked = {
            "report": str(report),
            "tree": str(tree),
            "traced": traced,
            "usual": str(usual) if usual else "",
            "more": more,
            "memory": MEMORY,
        }
        environment = {
            **self._environment,
            "STICKSLIP_MUTATION": json.dumps(asked),
            "PYTHONPATH": f"{tree / 'src'}{os.pathsep}{self._plugins}",
        }
        nursery = self._nurseries.get()
        with tempfile.TemporaryDirectory(prefix="scratch-", dir=self._folder, ignore_cleanup_errors=True) as scratch:
            words = Path(scratch) / "words"
            arguments = ["-q", "-p", "no:cacheprovider", "-p", "mutation_watch", f"--basetemp={scratch}/tests"]
            run = {
                "arguments": [*arguments, *options, *tests],
                "tree": str(tree),
                "path": [str(tree), str(tree / "src"), str(self._plugins)],
                "environment": environment,
                "words": str(words),
                "wall": wall,
            }
            try:
                code = nursery.run(run)
            finally:
                self._nurseries.put(nursery)
            last = "\n".join(words.read_text(encoding="utf-8", errors="replace").splitlines()[-15:])
        return code, last


class Nursery:
    """The process of `nursery.py`.

    Parameters
    ----------
    modules : sequence of str
        It imports them.
    environment : mapping
    """

    def __init__(self, modules: Sequence[str], environment: Mapping[str, str]) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("nursery.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=dict(environment),
            text=True,
            encoding="utf-8",
        )
        self._say(modules)

    def run(self, asked: Mapping[str, Any]) -> int:
        """Exit code of one run."""
        self._say(asked)
        assert self._process.stdout is not None
        return int(self._process.stdout.readline())

    def close(self) -> None:
        """End the process, and the run that may be going on."""
        assert self._process.stdin is not None
        self._process.terminate()
        # A signal that comes just before the process waits for words is not heard until the words end.
        self._process.stdin.close()
        self._process.wait()

    def _say(self, words: Any) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(words) + "\n")
        self._process.stdin.flush()


def support(root: Path, tests: Iterable[str]) -> list[str]:
    """What tests stand on, relative to the checkout: what sets up all, and the judges that they and these name."""
    judges = [path for path in (root / "tests" / "judges").glob("*") if path.is_file()]
    found = {"tests/conftest.py"}
    unread = [root / file for file in (*found, *tests)]
    while unread:
        words = set(re.findall(r"\w+", unread.pop().read_text(encoding="utf-8")))
        for path in judges:
            file = path.relative_to(root).as_posix()
            if path.stem in words and file not in found:
                found.add(file)
                unread.append(path)
    return sorted(found)


def part_of(report: Mapping[str, Any], test: str) -> dict[str, Any]:
    """What a report says of one test file, and of what was imported."""
    return {
        "seconds": {test: report["seconds"].get(test, 0.0)},
        "each": {name: seconds for name, seconds in report["each"].items() if name.partition("::")[0] == test},
        "reached": {name: report["reached"].get(name, {}) for name in (test, AT_IMPORT)},
    }


def joined(parts: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """A report from those of its test files."""
    report: dict[str, Any] = {"seconds": {}, "each": {}, "reached": {}}
    imported: dict[str, set[int]] = defaultdict(set)
    for part in parts:
        for name, content in report.items():
            content.update(part[name])
        for file, lines in part["reached"][AT_IMPORT].items():
            imported[file].update(lines)
    report["reached"][AT_IMPORT] = {file: sorted(lines) for file, lines in imported.items()}
    return report


def digest(root: Path, files: Sequence[str], also: str = "") -> str:
    """Of the contents of files and their names."""
    whole = hashlib.sha256(also.encode())
    for file in sorted(set(files)):
        if not (root / file).is_symlink():
            whole.update(f"\0{file}\0".encode() + hashlib.sha256((root / file).read_bytes()).digest())
    return whole.hexdigest()[:16]


def _patience(file: str, text: bytes) -> float:
    is_of_kernels = file.startswith(("common/", "compiling/", "crawler/")) or b"compilation import" in text
    return COMPILING if is_of_kernels else MORE
