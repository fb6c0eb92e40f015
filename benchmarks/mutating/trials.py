"""Runs of the tests in throw-away copies of the checkout, without a fault and with one."""

import contextlib
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .checkout import copied, files_in, kept_kernels, twin
from .operators import Mutant
from .relevance import ordered, reached

__all__ = ["Laboratory", "Outcome", "digest"]

MEMORY = 6 << 30  # bytes
MORE = 20.0  # seconds of processor time that a test may take beyond ten times what it does
COMPILING = 150.0  # likewise where kernels may have to be compiled anew
WALL = 1800.0  # seconds, for what waits without working


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

    Use it as a context: the copies are gone afterwards.
    """

    def __init__(self, root: Path, kept: Path) -> None:
        self.root = root
        self.kept = kept

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
        shutil.rmtree(self._folder, ignore_errors=True)

    def baseline(self, tests: Sequence[str]) -> Path:
        """What the tests do without faults, as a file of JSON.

        Raises
        ------
        RuntimeError
            If a test fails.
        """
        sources = [file for file in files_in(self.tree) if file.endswith((".py", ".json", ".md", ".toml"))]
        path = self.kept / f"baseline-{digest(self.tree, [*sources, *tests], repr(list(tests)))}.json"
        if not path.exists():
            code, words = self._pytest(self.tree, tests, path, traced=True)
            report = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"failed": [], "package": None}
            wrong = ""
            if code != 0:
                wrong = f"the tests fail without any fault: {', '.join(report['failed']) or code}\n{words}"
            elif report["package"] not in (None, f"{self.tree}/src/stickslip/__init__.py"):
                wrong = f"the tests import another stickslip: {report['package']}"
            if wrong:
                path.unlink(missing_ok=True)
                raise RuntimeError(wrong)
            kept_kernels(self.tree, self.root)
        return path

    def tried(self, file: str, mutant: Mutant, tests: Sequence[str], baseline: Path) -> tuple[Outcome, bool | None]:
        """Run the tests with a fault: what came of it, and whether a test runs the line (None: nobody knows)."""
        usual = json.loads(baseline.read_text(encoding="utf-8"))
        order = ordered(self.tree, usual, file, mutant, list(tests))
        begin = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="trial-", dir=self._folder, ignore_cleanup_errors=True) as folder:
            tree = Path(folder) / "checkout"
            twin(self.tree, tree)
            text = (tree / file).read_bytes()
            (tree / file).unlink()
            (tree / file).write_bytes(mutant.applied(text))
            report = Path(folder) / "report.json"
            code, _ = self._pytest(tree, order, report, usual=baseline, more=_more(file, text), first=True)
            failed = json.loads(report.read_text(encoding="utf-8"))["failed"] if report.exists() else []
        seconds = time.monotonic() - begin
        if code == 0:
            return Outcome("survived", "", seconds), reached(usual, file, mutant)
        if code in (-signal.SIGPROF, -signal.SIGKILL):
            return Outcome("hung", signal.Signals(-code).name, seconds), reached(usual, file, mutant)
        return Outcome("noticed", failed[0] if failed else f"exit {code}", seconds), reached(usual, file, mutant)

    def _pytest(
        self,
        tree: Path,
        tests: Sequence[str],
        report: Path,
        *,
        traced: bool = False,
        usual: Path | None = None,
        more: float = 0.0,
        first: bool = False,
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
        environment = os.environ | {
            "STICKSLIP_MUTATION": json.dumps(asked),
            "PYTHONPATH": f"{tree / 'src'}{os.pathsep}{self._plugins}",
            "PYTHONWARNDEFAULTENCODING": "1",
            "CI": "1",
            "HYPOTHESIS_PROFILE": "ci",
            "OMP_NUM_THREADS": "1",
        }
        environment.pop("NUMBA_CACHE_DIR", None)
        scratch = tempfile.mkdtemp(prefix="scratch-", dir=self._folder)
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "mutation_watch"]
        command += [f"--basetemp={scratch}/tests", *(["-x"] if first else []), *tests]
        with (Path(scratch) / "words").open("w+b") as words:
            process = subprocess.Popen(
                command, cwd=tree, env=environment, stdout=words, stderr=words, start_new_session=True
            )
            try:
                code = process.wait(WALL)
            except subprocess.TimeoutExpired:
                code = -signal.SIGKILL
            finally:
                _end_all_of(process)
            words.seek(0)
            last = "\n".join(words.read().decode(errors="replace").splitlines()[-15:])
        shutil.rmtree(scratch, ignore_errors=True)
        return code, last


def digest(root: Path, files: Sequence[str], also: str = "") -> str:
    """Of the contents of files and their names."""
    whole = hashlib.sha256(also.encode())
    for file in sorted(set(files)):
        if not (root / file).is_symlink():
            whole.update(f"\0{file}\0".encode() + hashlib.sha256((root / file).read_bytes()).digest())
    return whole.hexdigest()[:16]


def _more(file: str, text: bytes) -> float:
    is_of_kernels = file.startswith(("common/", "compiling/", "crawler/")) or b"compilation import" in text
    return COMPILING if is_of_kernels else MORE


def _end_all_of(process: subprocess.Popen[bytes]) -> None:
    """End the processes that a run began and did not end."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
