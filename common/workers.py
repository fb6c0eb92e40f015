"""Processes to share work among, which leave interrupts to the process that began them, and end with it."""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

__all__ = ["leave_to_parent", "worker_processes"]

Result = TypeVar("Result")

_LOOK = 0.5  # seconds between two looks for a parent that nothing else tells the end of


@contextmanager
def worker_processes(
    count: int, initializer: Callable[..., None] | None = None, arguments: tuple[Any, ...] = ()
) -> Iterator[ProcessPoolExecutor]:
    """A pool of processes; where its block ends by an exception they are ended at once, and else when they are done.

    Parameters
    ----------
    count : int
    initializer : callable, optional
        Called in each of them first, with the `arguments`.
    arguments : tuple
    """
    context = multiprocessing.get_context("spawn")
    pool = _Pool(count, mp_context=context, initializer=_begin, initargs=(initializer, arguments))
    try:
        yield pool
    except BaseException:
        for process in list(pool._processes.values()):
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


class _Pool(ProcessPoolExecutor):
    """It starts a process whenever there is work and none is idle, and each inherits what is blocked then."""

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        with _interrupts_blocked():
            return super().submit(fn, *args, **kwargs)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    usual = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, usual)


def leave_to_parent() -> None:
    """Have this process, one of a pool, leave interrupts to its parent and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow, args=(os.getppid(),), daemon=True).start()


def _follow(parent: int) -> None:
    known = multiprocessing.parent_process()
    if known is not None and known.sentinel is not None:
        known.join()
    else:  # joblib's processes are not told
        while os.getppid() == parent:
            time.sleep(_LOOK)
    os._exit(1)


def _begin(initializer: Callable[..., None] | None, arguments: tuple[Any, ...]) -> None:
    leave_to_parent()
    if initializer is not None:
        initializer(*arguments)
