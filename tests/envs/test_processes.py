"""Threads of a batch: as many as were asked for, ended when it is closed, and none of a parent's in a child."""

import multiprocessing
import os
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from stickslip.envs import StickSlipCrawlerVectorEnv

COUNT = 400  # enough for three threads


def begun(**arguments):
    envs = StickSlipCrawlerVectorEnv(COUNT, **arguments)
    envs.reset(seed=0)
    return envs


def own_threads():
    return sum(thread.name.startswith("stickslip") for thread in threading.enumerate())


@pytest.fixture
def helpers(monkeypatch):
    """Most threads of each pool that was made; a pool starts one only where the others are busy."""
    most = []

    class Pool(ThreadPoolExecutor):
        def __init__(self, threads, name):
            most.append(threads)
            super().__init__(threads, name)

    monkeypatch.setattr("stickslip.envs.batch_engine.ThreadPoolExecutor", Pool)
    return most


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_a_step_is_shared_by_the_threads_asked_for_and_a_closed_batch_has_none(threads, helpers):
    before = own_threads()
    envs = begun(threads=threads)
    envs.step(np.ones(COUNT, int))
    assert helpers == [threads - 1] * (threads > 1)
    assert (own_threads() > before) == (threads > 1)
    envs.close()
    assert own_threads() == before


def test_by_default_there_is_one_for_each_processor(monkeypatch, helpers):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 4, 7}, raising=False)
    envs = begun()
    envs.step(np.ones(COUNT, int))
    assert helpers == [2]
    envs.close()


def test_a_few_crawlers_need_no_second_thread():
    before = own_threads()
    envs = StickSlipCrawlerVectorEnv(255, threads=2)
    envs.reset(seed=0)
    envs.step(np.ones(255, int))
    assert own_threads() == before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system knows no fork")
@pytest.mark.parametrize("act", ["step", "close"])
def test_a_forked_process_starts_threads_of_its_own(act):
    envs, twin = begun(threads=2), begun(threads=2)
    for each in (envs, twin):
        each.step(np.ones(COUNT, int))
    fork = multiprocessing.get_context("fork")
    receiver, sender = fork.Pipe(duplex=False)

    def live():
        rewards = [envs.step(np.zeros(COUNT, int))[1] for _ in range(3)] if act == "step" else []
        envs.close()
        sender.send(rewards)

    child = fork.Process(target=live, daemon=True)
    child.start()
    try:
        assert receiver.poll(60), "the child hangs: it waits for threads that only its parent has"
        for rewards in receiver.recv():
            np.testing.assert_array_equal(rewards, twin.step(np.zeros(COUNT, int))[1])
        child.join(60)
        assert child.exitcode == 0
    finally:
        child.kill()
    envs.step(np.zeros(COUNT, int))  # the parent still has its own
    envs.close(), twin.close()
