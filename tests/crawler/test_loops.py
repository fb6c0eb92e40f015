"""Every loop of compiled code ends in a stated number of passes: none can hang a process that `max_steps` bounds."""

import ast
from pathlib import Path

import pytest

from stickslip.crawler.model.state import Body, FORWARD, STUCK
from stickslip.crawler.motion.sampling import end_of_step

ROOT = Path(__file__).parents[2]
PACKAGE = ("crawler", "envs", "reservoir", "compiling", "tasks", "train", "studies")
KERNELS = {"compiled", "allocating", "merged", "formula", "inlined", "overload", "njit"}
# What bounds the passes of each loop of kernels that is no walk through a range.
BOUNDS = {
    ("crawler/loop.py", "advance", "spent < allowed"): "max_steps: a pass spends one, and one for each look",
    ("crawler/loop.py", "advance", "done < count"): "samples of a hold",
    (
        "crawler/motion/sampling.py",
        "sampled_by",
        "begin > 0.0 and done < count and (moment_of(done, count, hold) <= begin)",
    ): "samples of a hold",
    ("crawler/closed_form/search.py", "first_fall", "spent < budget"): "max_steps less what is spent",
    ("crawler/batch/advance.py", "_in_closed_form", "first < some.end"): "crawlers of the batch",
    ("crawler/batch/advance.py", "_in_lanes", "active"): "max_steps for each crawler of the batch",
    ("crawler/batch/advance.py", "_in_lanes", "due"): "samples of a hold",
    (
        "crawler/batch/lane_runs.py",
        "go_on_in_lanes",
        "control[ACTIVE] != 0 and left > 0 and (control[LOGGED] + LANES <= len(log.times))",
    ): "steps of a call",
    ("crawler/batch/lane_runs.py", "go_on_in_lanes", "due"): "samples of a hold",
    ("crawler/batch/advance.py", "_next", "i < some.end and some.skip[i]"): "crawlers of the batch",
}
FILES = sorted(path for folder in PACKAGE for path in (ROOT / folder).rglob("*.py"))


def kernels(tree):
    """Functions that numba compiles."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            names = {name.id for mark in node.decorator_list for name in ast.walk(mark) if isinstance(name, ast.Name)}
            if names & KERNELS:
                yield node


def calls_of(kernel):
    return {call.func.id for call in ast.walk(kernel) if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)}


@pytest.fixture(scope="module")
def loops():
    """Place, function and condition of every loop without a count, and every other iteration of kernels."""
    conditions, walks = set(), []
    for path in FILES:
        place = path.relative_to(ROOT).as_posix()
        for kernel in kernels(ast.parse(path.read_text(encoding="utf-8"))):
            for node in ast.walk(kernel):
                if isinstance(node, ast.While):
                    conditions.add((place, kernel.name, ast.unparse(node.test)))
                elif isinstance(node, ast.For):
                    walks.append((place, kernel.name, node.iter))
    return conditions, walks


def test_every_loop_without_a_count_has_a_bound(loops):
    conditions, _ = loops
    assert conditions == set(BOUNDS)


def test_every_other_loop_walks_through_something_finite(loops):
    _, walks = loops
    assert len(walks) > 100, "the scan sees the kernels"
    for place, name, walked in walks:
        finite = isinstance(walked, ast.Tuple) or (isinstance(walked, ast.Call) and ast.unparse(walked.func) == "range")
        assert finite, f"{place}: {name} walks through {ast.unparse(walked)}"


def test_no_kernel_calls_itself():
    for path in FILES:
        for kernel in kernels(ast.parse(path.read_text(encoding="utf-8"))):
            assert kernel.name not in calls_of(kernel), f"{path}: {kernel.name}"


def test_no_step_ends_beyond_its_stretch():
    # 0.753 and the way from there to 1.78 add up to more than 1.78 in floats.
    close, elapsed = 1.78, 0.753
    assert elapsed + (close - elapsed) > close
    resting = Body(0.0, 0.0, 0.0, 0.0, 0.0, STUCK, 0)
    assert end_of_step(resting, close, elapsed, close - elapsed, STUCK) == (close, True)
    assert end_of_step(resting, close, elapsed, close - elapsed, FORWARD) == (close, False)
    assert end_of_step(resting, close, elapsed, 0.5, FORWARD) == (elapsed + 0.5, False)
