"""Work that threads share."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from stickslip.common.sharing import processors, share


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("count", [0, 1, 7])
def test_results_come_in_order_of_the_jobs(threads, count):
    assert share(lambda job, _over: job * job, range(count), threads) == [k * k for k in range(count)]


def test_no_more_threads_than_asked_for_and_this_one_among_them():
    seen = set()

    def work(_job, _over):
        time.sleep(0.002)
        seen.add(threading.get_ident())

    share(work, range(40), 3)
    assert threading.get_ident() in seen
    assert len(seen) <= 3


@pytest.mark.parametrize("where", ["here", "there"])
def test_what_one_job_raises_stops_the_others_and_is_raised(where):
    here = threading.get_ident()
    stopped = []

    def work(_job, over):
        if (threading.get_ident() == here) == (where == "here"):
            raise KeyboardInterrupt
        stopped.append(over.wait(20.0))

    with pytest.raises(KeyboardInterrupt):
        share(work, range(4), 2)
    assert stopped == [True] * len(stopped)
    assert threading.active_count() == 1 or not any(
        thread.name.startswith("stickslip_") for thread in threading.enumerate()
    )


def test_an_interrupt_while_others_are_called_stops_those_who_have_begun(monkeypatch):
    stopped = []

    def submit(pool, work):
        submit_one(pool, work)
        assert begun.wait(20.0)
        raise KeyboardInterrupt

    def work(_job, over):
        begun.set()
        stopped.append(over.wait(5.0))

    begun, submit_one = threading.Event(), ThreadPoolExecutor.submit
    monkeypatch.setattr(ThreadPoolExecutor, "submit", submit)
    with pytest.raises(KeyboardInterrupt):
        share(work, range(4), 2)
    assert stopped == [True]


def test_processors_are_counted():
    assert processors() >= 1
