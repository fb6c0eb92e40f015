"""Work that threads share, and that an interrupt stops."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from threading import Event
from typing import TypeVar

__all__ = ["processors", "share"]

Job = TypeVar("Job")
Result = TypeVar("Result")


def processors() -> int:
    """Processors that this process may run on; all, where the system does not tell."""
    affinity = getattr(os, "sched_getaffinity", None)
    return (os.cpu_count() or 1) if affinity is None else len(affinity(0))


def share(work: Callable[[Job, Event], Result], jobs: Sequence[Job], threads: int) -> list[Result]:
    """Do jobs on several threads, this one among them, each taking the next when it has done one.

    Parameters
    ----------
    work : callable
        Takes a job, and an event: once that is set nobody waits for the result any more, and it should return.
    jobs : sequence
    threads : int

    Returns
    -------
    list
        What came of each job.

    Raises
    ------
    BaseException
        What a job raised, or an interrupt of this thread, after all others have stopped.
    """
    results: dict[int, Result] = {}
    following, over = count(), Event()

    def take() -> None:
        try:
            while not over.is_set() and (k := next(following)) < len(jobs):
                results[k] = work(jobs[k], over)
        except BaseException:
            over.set()
            raise

    helpers = min(threads, len(jobs)) - 1
    if helpers < 1:
        take()
    else:
        with ThreadPoolExecutor(helpers, "stickslip") as pool:
            try:
                # An interrupt that comes here has to stop those who have begun; the pool waits for them.
                others = [pool.submit(take) for _ in range(helpers)]
                take()
                for other in others:
                    other.result()
            except BaseException:
                over.set()
                raise
    return [results[k] for k in range(len(jobs))]
