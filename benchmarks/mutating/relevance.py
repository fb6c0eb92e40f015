"""Which tests come first: those that reach the changed line, then those that name the module, the quick ones first."""

import ast
import re
from collections.abc import Collection, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from .operators import Mutant
from .watch import AT_IMPORT

__all__ = ["INSTALLING", "TEXTUAL", "able", "ordered", "reached", "tests_of"]


TEXTUAL = {"tests/crawler/test_loops.py"}
"""Tests that compare the text of sources with a table: they notice every change, right or wrong, and prove nothing."""
PROCESSES = re.compile(
    r"\b(subprocess|multiprocessing|Popen|fork|processes|workers?|helpers|joblib|dask|distributed)\b"
)
"""What is said where a test has other processes work for it."""
INSTALLING = {"tests/package/test_typing.py"}
"""Tests of how the package is installed: a copy with a fault is found by its path, before what is installed."""


def tests_of(tree: Path, folder: str) -> list[str]:
    """Test files of a folder, relative to the checkout, without those that compare texts or installations."""
    found = {path.relative_to(tree).as_posix() for path in (tree / "tests" / folder).rglob("test_*.py")}
    return sorted(found - TEXTUAL - INSTALLING)


def reached(baseline: Mapping[str, Any], file: str, mutant: Mutant) -> bool | None:
    """Whether a test ran the line without a fault; None where nobody knows.

    In compiled functions that cannot be seen, and a module may be newer than what is kept of a test.
    """
    if mutant.compiled or file in baseline["stale"]:
        return None
    return any(mutant.line in lines.get(_module_file(file), ()) for lines in baseline["reached"].values())


def able(tree: Path, baseline: Mapping[str, Any], file: str, mutant: Mutant, tests: Iterable[str]) -> list[str]:
    """The test files that can notice a fault: those that run its line, or start processes, which nobody watches.

    Where nobody knows who runs the line, in compiled functions and while modules are imported, that is all of them, and
    where none was seen to, since default arguments have lines that nobody runs.
    """
    runs = {test for test, lines in baseline["reached"].items() if mutant.line in lines.get(_module_file(file), ())}
    if not reached(baseline, file, mutant) or AT_IMPORT in runs:
        return list(tests)
    return [test for test in tests if test in runs or _starts_processes(tree / test)]


def ordered(
    tree: Path,
    baseline: Mapping[str, Any],
    file: str,
    mutant: Mutant,
    tests: Iterable[str],
    helped: Collection[str] = (),
) -> list[str]:
    """The test files in the order in which they are most likely to notice a fault soon.

    Parameters
    ----------
    tree : Path
        The checkout.
    baseline : mapping
        What the tests did without a fault.
    file : str
        The module.
    mutant : Mutant
    tests : iterable of str
    helped : collection of str
        Test files that noticed another fault of the module.
    """

    def rank(test: str) -> tuple[bool, bool, float]:
        runs = mutant.line in baseline["reached"].get(test, {}).get(_module_file(file), ())
        mirrors = Path(test).stem.removeprefix("test_").startswith(Path(file).stem)
        beside = Path(test).parent == Path("tests", file).parent and len(Path(file).parts) > 2
        first = runs or mirrors or test in helped
        return not first, not (beside or _names(tree / test, tree / file)), baseline["seconds"].get(test, 0.0)

    return sorted(tests, key=rank)


def _module_file(file: str) -> str:
    """As the package sees it: ``package/`` is the package itself."""
    return file.removeprefix("package/")


@cache
def _starts_processes(test: Path) -> bool:
    return bool(PROCESSES.search(test.read_text(encoding="utf-8")))


@cache
def _names(test: Path, file: Path) -> bool:
    """Whether a test file imports a module, or from a package what the module defines."""
    defined = {
        node.name
        for node in ast.parse(file.read_bytes()).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
    } | {file.stem}
    for node in ast.walk(ast.parse(test.read_bytes())):
        module = (node.module or "") if isinstance(node, ast.ImportFrom) else ""
        if isinstance(node, ast.ImportFrom) and module.startswith("stickslip"):
            names = {alias.name for alias in node.names}
            if file.stem in module.split(".") or defined & names:
                return True
    return False
