"""A plugin of pytest for the runs with faults: what failed, what took how long, and which lines each test file reached.

It bounds processor time and memory too: a fault can make a program run for ever or ask for everything. Wall time says
nothing on a machine that others use.
"""

import json
import os
import resource
import signal
import sys
import sysconfig
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

AT_IMPORT = "import"  # stands for a test file where lines were reached while tests were collected


class Watch:
    """Watches one run of the tests.

    Parameters
    ----------
    report : Path
        JSON is written there.
    tree : Path
        The checkout.
    traced : bool
        Whether to watch lines.
    usual : mapping
        Seconds of processor time by test, without faults.
    more : float
        Seconds that a test may take beyond ten times the usual; the process is ended by SIGPROF at the limit.
    """

    def __init__(self, report: Path, tree: Path, traced: bool, usual: Mapping[str, float], more: float) -> None:
        self.report = report
        self.traced = traced
        self.usual = usual
        self.more = more
        self.each: dict[str, float] = {}
        self.failed: list[str] = []
        self.seconds: dict[str, float] = defaultdict(float)
        self.reached: dict[str, dict[str, set[int]]] = defaultdict(lambda: defaultdict(set))
        self._now = self.reached[AT_IMPORT]
        self._package = f"{tree}/src/stickslip/"

    def start(self) -> None:
        """Watch lines from now on, if asked to."""
        if self.traced:
            threading.settrace(self._enter)
            sys.settrace(self._enter)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Bound a test, and take its time."""
        self._now = self.reached[item.nodeid.partition("::")[0]]
        self.start()  # a test may have taken it away
        if self.more:
            signal.setitimer(signal.ITIMER_PROF, 10 * self.usual.get(item.nodeid, 1.0) + self.more)
        begin = time.process_time()
        yield
        self.each[item.nodeid] = time.process_time() - begin
        signal.setitimer(signal.ITIMER_PROF, 0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note what failed, and the seconds."""
        self.seconds[report.nodeid.partition("::")[0]] += report.duration
        if report.failed:
            self.failed.append(report.nodeid)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note what could not be imported."""
        if report.failed:
            self.failed.append(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        """Write the report."""
        sys.settrace(None)
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        package = sys.modules.get("stickslip")
        content = {
            "package": getattr(package, "__file__", None),
            "processor": sum(each.ru_utime + each.ru_stime for each in used),
            "modules": _installed(),
            "failed": self.failed,
            "seconds": self.seconds,
            "each": self.each,
            "reached": {
                test: {file: sorted(lines) for file, lines in files.items()} for test, files in self.reached.items()
            },
        }
        self.report.write_text(json.dumps(content), encoding="utf-8")

    def _enter(self, frame: FrameType, event: str, argument: Any) -> Callable[..., Any] | None:
        name = frame.f_code.co_filename
        if not name.startswith(self._package):
            return None
        file = name.removeprefix(self._package)
        lines = self._now[file]
        lines.add(frame.f_lineno)

        def step(frame: FrameType, event: str, argument: Any) -> Callable[..., Any]:
            lines.add(frame.f_lineno)
            return step

        return step


def _installed() -> list[str]:
    """Modules that were imported and are neither ours nor the tests'."""
    library = sysconfig.get_path("stdlib")
    files = {name: getattr(module, "__file__", None) or "" for name, module in list(sys.modules.items())}
    return sorted(
        name
        for name, file in files.items()
        if ("site-packages" in file or file.startswith(library)) and name not in ("__main__", "mutation_watch")
    )


def pytest_configure(config: pytest.Config) -> None:
    """Bound the process, and watch."""
    asked = json.loads(os.environ.pop("STICKSLIP_MUTATION"))  # not for the processes that tests start
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_DATA, (asked["memory"], asked["memory"]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    usual = json.loads(Path(asked["usual"]).read_text(encoding="utf-8"))["each"] if asked["usual"] else {}
    watch = Watch(Path(asked["report"]), Path(asked["tree"]), asked["traced"], usual, asked["more"])
    config.pluginmanager.register(watch, "stickslip-mutation")
    watch.start()
