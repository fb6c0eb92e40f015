"""Kernels compile as they should, say so, and come back from disk only where they are what the sources say."""

import os
import subprocess
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from numba.core.errors import TypingError

from stickslip.compiling import compilation
from stickslip.compiling.compilation import allocating, compiled, formula, merged

OUTER = """
from stickslip.compiling import compilation
from stickslip.compiling.compilation import allocating, compiled, formula, merged
from .inner import shift

@compiled
def moved(x):
    return shift(x)
"""
INNER = """
from stickslip.compiling import compilation
from stickslip.compiling.compilation import allocating, compiled, formula, merged
from .constants import STEP

@compiled
def shift(x):
    return x + STEP
"""
ASK = """
from crawl.outer import moved
print(moved(1.0), *moved.stats.cache_hits.values(), sep=",")
"""


def halve(x):
    return x / 2.0


def invert(x):
    return 1.0 / x


@pytest.fixture
def package(tmp_path):
    """A package with one kernel that calls another, which takes a constant from a third module."""
    folder = tmp_path / "crawl"
    folder.mkdir()
    for name, text in (("__init__", ""), ("outer", OUTER), ("inner", INNER), ("constants", "STEP = 1.0\n")):
        (folder / f"{name}.py").write_text(text)
    return folder


def ask(package, code=ASK, **environment):
    """Run code in a process of its own; what it printed, and what it said on stderr."""
    variables = {
        "NUMBA_CACHE_DIR": str(package.parent / "kept"),
        "PYTHONPATH": str(package.parent),
    } | environment
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | variables, capture_output=True, text=True, timeout=300
    )
    return done.stdout.strip(), done.stderr.strip()


def begun(package, code=ASK):
    """Like `ask`, without waiting."""
    variables = {"NUMBA_CACHE_DIR": str(package.parent / "kept"), "PYTHONPATH": str(package.parent)}
    return subprocess.Popen([sys.executable, "-c", code], env=os.environ | variables, stdout=subprocess.PIPE)


def kept_in(package):
    return sorted((package.parent / "kept").rglob("*.nbc"))


def test_a_kernel_gives_what_the_function_gives():
    assert compiled(halve)(3.0) == 1.5


def test_division_by_zero_is_numpys():
    assert compiled(invert)(0.0) == float("inf")


@formula
def tripled(x):
    return x + x + x


@merged
def shifted(x):
    return tripled(x) + 0.5


def through_both(x):
    return shifted(x) + tripled(x)


def of_an_array(n):
    array = np.empty(n)
    array[0] = 10.0
    return array[0]


def of_another_array(n):
    array = np.empty(n)
    array[0] = 10.0
    return array[0]


def test_a_formula_stays_a_function_and_compiled_code_may_call_it():
    assert tripled("ab") == "ababab"
    assert compiled(through_both)(2.0) == 12.5
    assert shifted(2.0) == 6.5


def test_a_kernel_may_allocate_only_if_it_says_so():
    with pytest.raises(TypingError, match="empty"):
        compiled(of_an_array)(5)
    assert allocating(of_another_array)(5) == 10


def test_an_interrupt_that_nobody_would_hear_of_is_raised_at_the_end(monkeypatch):
    heard = []
    monkeypatch.setattr(sys, "unraisablehook", heard.append)
    usual, other = sys.unraisablehook, SimpleNamespace(exc_type=ValueError)

    def work(kind):
        with compilation._interrupts_kept():
            assert sys.unraisablehook is not usual
            sys.unraisablehook(other)
            sys.unraisablehook(SimpleNamespace(exc_type=kind))
            heard.append("went on")

    with pytest.raises(KeyboardInterrupt):
        work(KeyboardInterrupt)
    assert heard == [other, "went on"]
    assert sys.unraisablehook is usual
    work(OSError)
    assert len(heard) == 5
    # Only the main thread is interrupted.
    seen = []

    def aside():
        with compilation._interrupts_kept():
            seen.append(sys.unraisablehook is usual)

    thread = threading.Thread(target=aside)
    thread.start()
    thread.join()
    assert seen == [True]


def test_compiling_is_announced_once_a_process(monkeypatch, capsys):
    monkeypatch.setattr(compilation, "_announced", False)
    compilation._announce("folder", "")
    compilation._announce("other", "")
    begin = "stickslip: compiling kernels, up to a minute, "
    assert capsys.readouterr().err == f"{begin}once; kept in folder; `stickslip compile` does all of it ahead\n"
    monkeypatch.setattr(compilation, "_announced", False)
    compilation._announce(None, "in every process")
    assert capsys.readouterr().err == f"{begin}in every process\n"


def test_a_kernel_is_compiled_once_and_says_so(package):
    answer, said = ask(package)
    assert answer == "2.0"
    (line,) = said.splitlines()
    assert line.startswith(
        "stickslip: compiling kernels, up to a minute, once; kept in " + str(package.parent / "kept")
    )
    assert len(kept_in(package)) == 2
    assert ask(package) == ("2.0,1", "")


REFUSED = """
from contextlib import nullcontext
from stickslip.compiling.compilation import kept_kernels_alone, NotCompiledError
from crawl.outer import moved
def asked(within):
    try:
        with within:
            return moved(1.0)
    except NotCompiledError as error:
        return str(error)
print(asked(kept_kernels_alone()), asked(nullcontext()), asked(kept_kernels_alone()), sep=",")
"""


def test_what_is_not_kept_is_refused_where_asked_for_and_compiled_elsewhere(package):
    answer, said = ask(package, REFUSED)
    assert answer == "moved is not compiled yet,2.0,2.0"
    assert said.count("compiling kernels") == 1
    assert ask(package, REFUSED) == ("2.0,2.0,2.0", "")


def test_an_edited_callee_is_compiled_anew(package):
    at_once = [begun(package) for _ in range(2)]
    assert [process.communicate(timeout=300)[0].split(b",")[0].strip() for process in at_once] == [b"2.0", b"2.0"]
    assert ask(package) == ("2.0,1", "")
    constants, inner = package / "constants.py", package / "inner.py"
    as_it_was = constants.read_text()
    constants.write_text("STEP = 2.5\n")
    answer, said = ask(package)
    assert answer == "3.5"
    assert "compiling" in said
    inner.write_text(INNER.replace("x + STEP", "x + STEP + STEP"))
    assert ask(package)[0] == "6.0"
    # As it was, and though its time tells nothing.
    constants.write_text(as_it_was)
    os.utime(constants, (1, 1))
    assert ask(package)[0] == "3.0"
    assert len(kept_in(package)) == 2


def test_a_module_edited_since_it_was_imported_is_not_kept(package):
    edit = f"""
import crawl.outer, pathlib, time, os
file = pathlib.Path({str(package / "inner.py")!r})
file.write_text(file.read_text().replace("x + STEP", "x - STEP"))
"""
    answer, said = ask(package, edit + ASK)
    assert answer == "2.0"
    assert kept_in(package) == []
    assert "edited after they were imported" in said
    assert "can be written" not in said


LATE = "import time; now = time.time; time.time = lambda: now() - 1e6\n"
FUTURE = 4e9


@pytest.mark.parametrize("clock", ["", LATE])
def test_sources_dated_in_the_future_are_kept(package, clock):
    if not clock:
        for file in package.glob("*.py"):
            os.utime(file, (FUTURE, FUTURE))
    answer, said = ask(package, clock + ASK)
    assert answer == "2.0"
    assert "once; kept in" in said
    assert ask(package, clock + ASK) == ("2.0,1", "")


@pytest.mark.parametrize("date", [1.0, FUTURE])
def test_an_edit_that_is_dated_otherwise_is_not_kept(package, date):
    edit = f"""
import crawl.outer, pathlib, os
file = pathlib.Path({str(package / "constants.py")!r})
file.write_text("STEP = 7.0")
os.utime(file, ({date}, {date}))
"""
    assert ask(package, edit + ASK)[0] == "2.0"
    assert kept_in(package) == []


def test_where_nothing_can_be_kept_one_line_says_what_to_set(package):
    (package.parent / "file").write_text("in the way")
    answer, said = ask(package, NUMBA_CACHE_DIR=str(package.parent / "file" / "kept"))
    assert answer == "2.0"
    (line,) = said.splitlines()
    assert "in every process" in line
    assert "set NUMBA_CACHE_DIR" in line


def test_without_a_compiler_one_sentence_says_why_not(package):
    answer, said = ask(package, "from stickslip import simulate", NUMBA_DISABLE_JIT="1")
    assert answer == ""
    assert said.splitlines()[-1].startswith(
        "ImportError: stickslip's kernels run compiled only, got NUMBA_DISABLE_JIT=1"
    )
