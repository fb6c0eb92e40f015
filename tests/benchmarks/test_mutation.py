"""Faults are put exactly where they are said to be, and a fault that a test notices is told from one that none does."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import mutation
import pytest
from mutating import relevance
from mutating.campaign import Campaign
from mutating.operators import mutants, OPERATORS
from mutating.page import page, wilson
from mutating.records import Equivalents
from mutating.sampling import changed_lines, drawn
from mutating.source import same_code
from mutating.trials import joined, Nursery, part_of, support
from scipy.stats import binomtest

ROOT = Path(__file__).parents[2]
CASES = {
    "comparison": ("x = a  <  b is c", {"x = a  <=  b is c", "x = a  >  b is c", "x = a  <  b is not c"}),
    "arithmetic": ("x = (a) + -b  # a - b", {"x = (a) - -b  # a - b", "x = (a) + b  # a - b"}),
    "logic": ("x = a and not (b or c)", {"x = a or not (b or c)", "x = a and (b or c)", "x = a and not (b and c)"}),
    "condition negated": ("x = a if ready(b) else c", {"x = a if not (ready(b)) else c"}),
    "number": ("x = 0, 1, 7, 0.5", {"x = 1, 1, 7, 0.5", "x = 0, 0, 7, 0.5", "x = 0, 1, 8, 0.5", "x = 0, 1, 7, 1.0"}),
    "truth value": ("x = True", {"x = False"}),
    "keyword dropped": ("f(a, key=(b), other=c,)", {"f(a, other=c,)", "f(a, key=(b),)"}),
    "arguments swapped": ("f(a, (b), 'text', mass=c, width=d)", {"f(b, (a), 'text', mass=c, width=d)"}
                          | {"f(a, (b), 'text', mass=d, width=c)"}),
    "label swapped": ("x = {'é': 1, 'b': 2}, a in ('c', 'd')", {"x = {'b': 1, 'é': 2}, a in ('c', 'd')"}),
    "field swapped": ("import m\nx = é.lo, é.hi, é.f(1), b.lo, m.lo", {"import m\nx = é.hi, é.hi, é.f(1), b.lo, m.lo"}
                      | {"import m\nx = é.lo, é.lo, é.f(1), b.lo, m.lo"}),
    "copy removed": ("x = (a).copy(), np.array(c)", {"x = (a), np.array(c)", "x = (a).copy(), np.asarray(c)"}),
    "function changed": ("x = np.mean(a)", {"x = np.sum(a)"}),
    "order reversed": ("x = sorted(a)", {"x = sorted(a, reverse=True)"}),
    "refusal removed": ("if a:\n    raise ValueError(f'{b + 1}')", {"if a:\n    pass"}),
    "guard removed": ("while a:\n    if b: continue", {"while a:\n    if b: pass"}),
    "store removed": ("if a:\n    self.b = 'é'\n", {"if a:\n    pass\n"}),
    "call removed": ("a.append(b)", {"pass"}),
}  # fmt: skip


@pytest.mark.parametrize("kind", OPERATORS)
def test_every_kind_changes_its_places_and_nothing_else(kind):
    text, expected = CASES[kind]
    # What comes before is in bytes longer than in letters.
    text, expected = f"é = 'ä'\n{text}", {f"é = 'ä'\n{each}" for each in expected}
    made = [mutant for mutant in mutants(text.encode()) if mutant.kind == kind]
    assert sorted(mutant.applied(text.encode()).decode() for mutant in made) == sorted(expected)
    assert all(mutant.line >= 2 for mutant in made)


def test_text_for_readers_types_and_imports_are_left_alone():
    text = b'''"""Module of 3 - 2."""
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    size = 3
__all__ = ["a", "b"]
Kind = Literal["c", "d"]
def f(x: Literal["e", "f"] = None, y: tuple[1, 2] | None = None) -> tuple[3, 4]:
    """More than 1 < 2."""
    warnings.warn("text", stacklevel=2)
    message = f"{x + 1:3}"
    assert isinstance(x, A | B), x + 1
    z = g(x, strict=True, flush=2)
if __name__ == "__main__":
    f(1)
'''
    assert [mutant.before for mutant in mutants(text)] == []


def test_what_only_orders_names_or_factors_is_no_fault():
    text = b"names = {'a': 1, 'b': 1}\nx = fma(a, b, c)\ny = and_(a, b)\n"
    assert [mutant.after for mutant in mutants(text) if mutant.kind in ("label swapped", "arguments swapped")] == [
        "x = fma(a, c, b)"
    ]


def test_a_change_elsewhere_leaves_the_order_of_the_faults(tmp_path):
    texts = {"a.py": "x = a < b\ny = a + f(b, 3)\nx = a < b\n", "b.py": "z = a - 1\nu = a and b\n"}
    for file, text in texts.items():
        (tmp_path / file).write_text(text, encoding="utf-8")

    def order(*files):
        return [(file, mutant.after) for file, mutant in drawn(tmp_path, files, 5) if mutant.before != "new = a > 1"]

    before = order("a.py", "b.py")
    assert order("b.py") == [each for each in before if each[0] == "b.py"]
    (tmp_path / "b.py").write_text("new = a > 1\n" + texts["b.py"], encoding="utf-8")
    assert order("a.py", "b.py") == before


def test_faults_of_the_package_compile():
    for file in ("crawler/loop.py", "tasks/narma.py", "crawler/drawing/side_view.py"):
        text = (ROOT / file).read_bytes()
        for mutant in mutants(text)[::20]:
            compile(mutant.applied(text), file, "exec")


def test_a_fault_that_compiles_to_the_same_is_told():
    assert same_code(b"x = 1 + 1", b"x = 2\n")
    assert not same_code(b"x = 1", b"x = True")
    assert not same_code(b"def f(): return 1", b"def f(): return 2")


def test_what_is_declared_equivalent_is_a_fault_of_the_code_of_today():
    assert Equivalents.read(mutation.EQUIVALENTS).gone(ROOT) == []


def test_a_declaration_without_its_text_or_reason_is_told(tmp_path):
    (tmp_path / "module.py").write_text("x = a < b\n", encoding="utf-8")
    entry = {"file": "module.py", "before": "x = a < b", "after": "x = a <= b", "reason": "They differ."}
    wrong = [{**entry, "after": "x = a + b"}, {**entry, "file": "gone.py"}, {**entry, "reason": ""}]
    assert Equivalents([entry]).gone(tmp_path) == []
    assert len(Equivalents(wrong).gone(tmp_path)) == 3
    assert Equivalents([entry]).reason("module.py", "x = a < b", "x = a <= b") == "They differ."
    assert not Equivalents([entry]).reason("module.py", "x = a < b", "x = a > b")


@pytest.mark.parametrize(("noticed", "tried"), [(0, 5), (5, 5), (37, 40), (1, 3)])
def test_the_interval_is_wilsons(noticed, tried):
    other = binomtest(noticed, tried).proportion_ci(method="wilson")
    assert wilson(noticed, tried) == pytest.approx((other.low, other.high), abs=1e-12)


TOY = {
    "common/scale.py": "def doubled(x, least=0.0):\n    return max(2.0 * x, least)\n\n\n"
    "def spent(n):\n    while n > 0:\n        n -= 1\n",
    "common/__init__.py": "",
    "package/__init__.py": "",
    "tests/conftest.py": "",
    "tests/judges/judge.py": "",
    "tests/common/test_scale.py": "from stickslip.common.scale import doubled, spent\n\n\n"
    "def test_it_doubles():\n    assert doubled(3.0) == 6.0\n\n\n"
    "def test_it_ends():\n    assert spent(3) is None\n",
    "pyproject.toml": "[tool.pytest.ini_options]\ntestpaths = ['tests']\n",
}


@pytest.fixture
def toy(tmp_path):
    """A checkout of a small package, with the script in it."""
    for file, text in TOY.items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text(text, encoding="utf-8")
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "stickslip").symlink_to("../package")
    (tmp_path / "package" / "common").symlink_to("../common")
    shutil.copytree(ROOT / "benchmarks" / "mutating", tmp_path / "benchmarks" / "mutating")
    shutil.copy(ROOT / "benchmarks" / "mutation.py", tmp_path / "benchmarks")
    (tmp_path / "benchmarks" / "mutating" / "equivalent.toml").write_text(
        "[[equivalent]]\nfile = 'common/scale.py'\nbefore = 'while n > 0:'\nafter = 'while n >= 0:'\nreason = 'So.'\n",
        encoding="utf-8",
    )
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b"]
    for arguments in (["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "toy"]):
        subprocess.run([*git, *arguments], check=True, capture_output=True)
    return tmp_path


@pytest.mark.slow
def test_faults_are_tried_kept_and_not_tried_again(toy):
    command = [sys.executable, "benchmarks/mutation.py", "--folder", "common", "--patience", "0.5"]
    environment = {**os.environ, "PYTHONIOENCODING": "utf-8"}
    first = subprocess.run(command, cwd=toy, env=environment, capture_output=True, encoding="utf-8")
    assert first.returncode == 0, first.stderr
    lines = (toy / "runs" / "mutation" / "trials.jsonl").read_text(encoding="utf-8").splitlines()
    came = {(each["before"], each["after"]): each for each in map(json.loads, lines)}
    assert came["return max(2.0 * x, least)", "return max(2.0 / x, least)"]["status"] == "noticed"
    assert came["return max(2.0 * x, least)", "return max(2.0 / x, least)"]["by"].endswith("::test_it_doubles")
    assert came["def doubled(x, least=0.0):", "def doubled(x, least=1.0):"]["status"] == "survived"
    assert came["def doubled(x, least=0.0):", "def doubled(x, least=1.0):"]["reached"]
    assert came["n -= 1", "pass"]["status"] == "hung"
    assert ("while n > 0:", "while n >= 0:") not in came  # declared
    assert "SURVIVED common/scale.py:1 number" in first.stdout
    assert (toy / "common" / "scale.py").read_text(encoding="utf-8") == TOY["common/scale.py"]

    again = subprocess.run(command, cwd=toy, env=environment, capture_output=True, encoding="utf-8")
    assert again.stdout.splitlines()[-1] == first.stdout.splitlines()[-1]
    assert "to try" not in again.stdout

    def known(seed=1):
        campaign = Campaign(toy, toy / "runs" / "mutation" / "trials.jsonl", Equivalents([]), "common")
        found = campaign.known(drawn(toy, ["common/scale.py"], seed))
        return {mutant.after: result and result["status"] for (_, mutant), _, result in found}

    assert set(known().values()) == {"noticed", "hung", "survived", None}  # None: it was declared
    (toy / "tests" / "common" / "test_more.py").write_text("", encoding="utf-8")
    with_more = known()
    assert set(with_more.values()) == {"noticed", None}  # what noticed them is as it was
    assert with_more == known(seed=2)
    (toy / "tests" / "common" / "test_scale.py").write_text("", encoding="utf-8")
    assert set(known().values()) == {None}


def test_what_is_known_of_the_tests_is_put_together_file_by_file():
    report = {
        "seconds": {"tests/test_a.py": 1.0, "tests/test_ab.py": 2.0},
        "each": {"tests/test_a.py::test_b": 0.5, "tests/test_ab.py::test_b": 0.25},
        "reached": {
            "import": {"c.py": [1, 2]}, "tests/test_a.py": {"c.py": [3]}, "tests/test_ab.py": {"c.py": [4], "d.py": [5]}
        },
    }  # fmt: skip
    parts = [part_of(report, test) for test in report["seconds"]]
    assert parts[0]["each"] == {"tests/test_a.py::test_b": 0.5}
    assert joined(parts) == report
    other = {"seconds": {}, "each": {}, "reached": {"import": {"c.py": [2, 7]}}}
    assert joined([*parts, other])["reached"]["import"] == {"c.py": [1, 2, 7]}


def test_a_test_stands_on_the_judges_that_it_names_and_on_theirs(tmp_path):
    texts = {"conftest.py": "", "test_a.py": "from judge import x\n", "test_b.py": "judgement = 1\n"}
    judges = {"judge.py": "TABLE = 'table.json'\n", "table.json": "{}", "other.py": ""}
    for folder, files in (("tests", texts), ("tests/judges", judges)):
        (tmp_path / folder).mkdir()
        for file, text in files.items():
            (tmp_path / folder / file).write_text(text, encoding="utf-8")
    own = ["tests/conftest.py", "tests/judges/judge.py", "tests/judges/table.json"]
    assert support(tmp_path, ["tests/test_b.py"]) == own[:1]
    assert support(tmp_path, ["tests/test_a.py"]) == support(tmp_path, ["tests/test_b.py", "tests/test_a.py"]) == own


def test_a_process_that_does_not_hear_that_it_should_end_ends_with_its_words(monkeypatch):
    nursery = Nursery([], os.environ)
    monkeypatch.setattr(nursery._process, "terminate", lambda: None)
    closing = threading.Thread(target=nursery.close, daemon=True)
    closing.start()
    closing.join(60.0)
    assert not closing.is_alive()


@pytest.mark.slow
def test_a_run_that_is_ended_leaves_nothing(toy):
    scratch = toy / "scratch"
    scratch.mkdir()
    command = [sys.executable, "-u", "benchmarks/mutation.py", "--folder", "common", "--patience", "60"]
    with subprocess.Popen(command, cwd=toy, env={**os.environ, "TMPDIR": str(scratch)}, stdout=subprocess.PIPE) as run:
        assert b"to try" in run.stdout.readline()
        run.stdout.readline()  # the first fault is through
        run.send_signal(signal.SIGTERM)
    assert run.returncode == 1
    assert list(scratch.iterdir()) == []


def test_a_test_that_fails_without_a_fault_is_named(toy):
    (toy / "tests" / "common" / "test_wrong.py").write_text("def test_wrong():\n    assert False\n", encoding="utf-8")
    command = [sys.executable, "benchmarks/mutation.py", "--folder", "common", "--count", "1"]
    done = subprocess.run(command, cwd=toy, capture_output=True, encoding="utf-8")
    assert done.returncode == 1
    assert "the tests fail without any fault: tests/common/test_wrong.py::test_wrong" in done.stderr


def test_faults_of_changed_lines_and_of_a_seed(toy):
    (toy / "common" / "scale.py").write_text(TOY["common/scale.py"].replace("2.0", "3.0"), encoding="utf-8")
    lines = changed_lines(toy, "HEAD")
    assert lines == {"common/scale.py": {2}}
    assert {mutant.line for _, mutant in drawn(toy, ["common/scale.py"], 1, lines)} == {2}
    one, same, other = (
        [(mutant.begin, mutant.text) for _, mutant in drawn(toy, ["common/scale.py"], seed)] for seed in (1, 1, 2)
    )
    assert one == same != other
    assert sorted(one) == sorted(other)
    lines = [TOY["common/scale.py"][:begin].count("\n") for begin, _ in one]
    assert len(set(lines[: len(set(lines))])) == len(set(lines))  # no line twice before all were had once


def test_tests_that_compare_texts_are_left_out():
    assert relevance.TEXTUAL
    for test in relevance.TEXTUAL | relevance.INSTALLING:
        assert (ROOT / test).is_file()
        assert test not in relevance.tests_of(ROOT, test.split("/")[1])


def test_what_reaches_the_line_or_noticed_another_fault_comes_first(toy):
    text = "from stickslip.common.scale import doubled\n"
    for name, imports in {"reaches": "", "helped": "", "names": text, "quick": "", "other": ""}.items():
        (toy / "tests" / "common" / f"test_{name}.py").write_text(imports, encoding="utf-8")
    [mutant, *_] = mutants(TOY["common/scale.py"].encode())
    tests = [f"tests/common/test_{name}.py" for name in ("other", "names", "quick", "helped", "reaches")]
    seconds = dict(zip(tests, (1.0, 9.0, 0.5, 9.0, 5.0), strict=True))
    baseline = {"reached": {tests[-1]: {"common/scale.py": [mutant.line]}}, "seconds": seconds}
    order = relevance.ordered(toy, baseline, "common/scale.py", mutant, tests, {"tests/common/test_helped.py"})
    assert [Path(test).stem for test in order] == [
        f"test_{name}" for name in ["reaches", "helped", "names", "quick", "other"]
    ]


def test_only_files_that_run_the_line_can_notice_unless_nobody_knows_who_does(toy):
    texts = {"runs": "", "starts": "from subprocess import run\n", "neither": "# processed, not by processors\n"}
    for name, text in texts.items():
        (toy / "tests" / "common" / f"test_{name}.py").write_text(text, encoding="utf-8")
    mutant = next(each for each in mutants(TOY["common/scale.py"].encode()) if each.line == 2)
    tests = [f"tests/common/test_{name}.py" for name in texts]
    some = {"reached": {tests[0]: {"common/scale.py": [2]}, "import": {"common/scale.py": [1, 5]}}, "stale": []}
    assert relevance.able(toy, some, "common/scale.py", mutant, tests) == tests[:2]
    everywhere = some | {"reached": {"import": {"common/scale.py": [1, 2]}}}
    nowhere = some | {"reached": {}}
    for unknown in (everywhere, nowhere, some | {"stale": ["common/scale.py"]}):
        assert relevance.able(toy, unknown, "common/scale.py", mutant, tests) == tests
    compiled = replace(mutant, compiled=True)
    assert relevance.able(toy, some, "common/scale.py", compiled, tests) == tests


def test_the_page_says_what_was_noticed_and_what_was_not():
    fault = {"file": "tasks/a.py", "line": 3, "kind": "number", "before": "x = 1", "after": "x = 0", "reached": True}
    faults = [{**fault, "status": status, "first": status} for status in ("noticed", "hung", "survived")]
    faults += [{**fault, "status": "equivalent"}, {**faults[0], "line": 5, "first": "survived"}]
    faults.append({**faults[2], "reached": False, "line": 4, "above": "tests/envs/test_b.py::test_c"})
    results = {"command": "python it", "seed": 5, "folders": {"tasks": faults, "train": []}}
    same = {"file": "a.py", "before": "b", "after": "c", "reason": "Because."}
    results |= {"revisions": {"tasks": "0123456789", "train": "abcdef"}, "equivalent": [same]}
    text = page(results)
    assert "| `tasks/` | 6 | 3 | 1 | 2 | 1 | 1 | 60% [23%, 88%] | 40% [12%, 77%] | 90% | 0123456789 |" in text
    assert "| `train/` | 0 | 0 | 0 | 0 | 0 | 0 | - | - | 90% | abcdef |" in text
    assert "| number | 5 | 60% [23%, 88%] |" in text
    assert "- `tasks/a.py:3` (number): `x = 1` became `x = 0`" in text
    assert (
        "- `tasks/a.py:4` (number; no test of the folder reaches the line; noticed by `tests/envs/test_b.py::test_c`)"
        in text
    )
    assert "- `a.py`: `b` became `c`. Because." in text
    assert "`python it` tried them on" in text
    assert "with seed 5" in text


def test_the_page_is_that_of_its_results():
    assert mutation.PAGE.exists() == mutation.RESULTS.exists()
    if mutation.PAGE.exists():
        results = json.loads(mutation.RESULTS.read_text(encoding="utf-8"))
        assert mutation.PAGE.read_text(encoding="utf-8") == page(results)
