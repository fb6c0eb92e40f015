"""Scores are made with one thread of BLAS, and what the caller had is left as it was."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from stickslip.common.threads import library_threads
from stickslip.studies.benchmark import run_benchmark
from stickslip.studies.search import held_out_scores, Range, search, Space
from stickslip.tasks import Solution
from stickslip.tasks.task import NRMSE


class Watching:
    """A task that scores nothing and sees the threads that BLAS may use."""

    metric = NRMSE

    def __init__(self):
        self.seen = set()

    def attempt(self, reservoir, *, length, seed, washout):
        self.seen |= threads()
        return Solution(float(seed))


def threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def reservoir(series, seed):
    return np.zeros((len(series), 1))


@pytest.mark.parametrize(
    "work",
    [
        lambda task: run_benchmark(tasks={"watching": task}, reservoirs={"none": reservoir}, seeds=[0]),
        lambda task: held_out_scores(task, reservoir, [0, 1]),
        lambda task: search(task, Space({"x": Range(0, 1)}, lambda values: reservoir), evaluations=2, finalists=1),
    ],
    ids=["run_benchmark", "held_out_scores", "search"],
)
def test_blas_has_one_thread(work):
    import scipy.linalg  # noqa: F401

    task = Watching()
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        work(task)
        assert threads() == before
    assert task.seen == {1}
    assert before == {2}


@pytest.mark.parametrize("count", [1, 2])
def test_the_libraries_have_so_many_threads_inside_the_block_alone(count):
    import torch

    before = torch.get_num_threads()
    with threadpool_limits(3, user_api="blas"):
        torch.set_num_threads(3)
        with library_threads(count):
            assert (torch.get_num_threads(), threads()) == (count, {count})
        assert (torch.get_num_threads(), threads()) == (3, {3})
        with pytest.raises(RuntimeError, match="inside"), library_threads(count):
            raise RuntimeError("inside")
        assert (torch.get_num_threads(), threads()) == (3, {3})
    torch.set_num_threads(before)


def test_a_torch_whose_threads_are_not_those_of_openmp_is_limited_too(monkeypatch):
    asked = []
    torch = SimpleNamespace(get_num_threads=lambda: 7, set_num_threads=asked.append)
    monkeypatch.setitem(sys.modules, "torch", torch)
    with library_threads(2):
        assert asked == [2]
    assert asked == [2, 7]
    monkeypatch.delitem(sys.modules, "torch")
    with library_threads(2):
        assert threads() == {2}
    assert asked == [2, 7]


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), (1.0, TypeError)])
def test_no_library_has_fewer_threads_than_one(count, error):
    with pytest.raises(error, match=f"^count must be a whole number >= 1, got {count}$"), library_threads(count):
        pass
