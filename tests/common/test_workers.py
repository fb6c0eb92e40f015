"""Processes that share work: begun with what they are given, deaf to interrupts, and ended with their block."""

import os
import signal
import time

import pytest

from stickslip.common.workers import worker_processes

GIVEN = []


def begin(*arguments):
    GIVEN.extend(arguments)


def tell(seconds):
    time.sleep(seconds)
    blocked = signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    return os.getpid(), GIVEN, blocked and signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def look_and_fail(processes):
    usual = signal.getsignal(signal.SIGINT)
    with worker_processes(2, begin, ("one", 2)) as pool:
        found = list(pool.map(tell, [0.3, 0.3, 0.0]))
        processes.extend(pool._processes.values())
        assert len(processes) == 2
        for pid, given, deaf in found:
            assert pid in {process.pid for process in processes} - {os.getpid()}
            assert given == ["one", 2]
            assert deaf
        assert signal.pthread_sigmask(signal.SIG_BLOCK, []) == set()
        assert signal.getsignal(signal.SIGINT) is usual
        asleep = pool.submit(tell, 600.0)
        while not asleep.running():
            time.sleep(0.01)
        raise RuntimeError("no more")


def test_workers_begin_as_they_are_told_and_end_at_once_where_their_block_fails():
    processes = []
    with pytest.raises(RuntimeError, match="no more"):
        look_and_fail(processes)
    for process in processes:
        process.join(10)
        assert process.exitcode == -signal.SIGTERM


def test_work_that_was_begun_is_done_when_the_block_ends():
    with worker_processes(1) as pool:
        last = pool.submit(tell, 0.1)
    assert last.result()[1] == []
