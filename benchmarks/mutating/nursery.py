"""A process that has imported what the tests import of others, and forks for every run: imports cost more than runs.

It is a script: it reads a line of JSON for each run, with the "arguments" of pytest, the "tree" that is its folder, the
"path" that comes first, the "environment", the file for its "words" and the seconds of "wall" time that it may last. It
answers with a line, the exit code; below zero stands the signal that ended the run.
"""

import contextlib
import gc
import importlib
import json
import os
import signal
import sys
import time
from typing import Any


def prepare(modules: list[str]) -> None:
    """Import modules; one that cannot be imported alone is none of those that help."""
    for name in modules:
        with contextlib.suppress(Exception):
            importlib.import_module(name)
    gc.collect()
    gc.freeze()


def born(asked: dict[str, Any]) -> int:
    """Fork a run: its process, which leads a group of its own."""
    process = os.fork()
    if process:
        return process
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell has what it starts behind ignore it
    os.setsid()
    os.chdir(asked["tree"])
    words = os.open(asked["words"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    nothing = os.open(os.devnull, os.O_RDONLY)
    for source, target in ((nothing, 0), (words, 1), (words, 2)):
        os.dup2(source, target)
    os.environ.clear()
    os.environ.update(asked["environment"])
    sys.path[:0] = asked["path"]
    sys.argv = ["pytest", *asked["arguments"]]
    import pytest

    code = 3
    try:
        code = int(pytest.main(asked["arguments"]))
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def ended(process: int, wall: float) -> int:
    """Wait for a run, end what is left of it, and give its exit code."""
    begin = time.monotonic()
    gone = 0
    try:
        while not gone and time.monotonic() - begin < wall:
            time.sleep(0.02)
            gone, status = os.waitpid(process, os.WNOHANG)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process, signal.SIGKILL)
        if not gone:
            _, status = os.waitpid(process, 0)
    return os.waitstatus_to_exitcode(status)


def main() -> None:
    """Serve until there is nothing more to read."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that a run is ended, too
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what an import prints is no answer
    del sys.path[0]  # in this folder lies nothing that a test imports
    prepare(json.loads(sys.stdin.readline()))
    for line in sys.stdin:
        asked = json.loads(line)
        answers.write(f"{ended(born(asked), asked['wall'])}\n")
        answers.flush()


if __name__ == "__main__":
    main()
