"""Independent jobs done on all processors by joblib, or on a Dask cluster, each result given as soon as it is there."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TYPE_CHECKING, TypeVar
from uuid import uuid4

import joblib

from .extras import optional_import
from .workers import leave_to_parent

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["as_done"]

Job = TypeVar("Job")
Result = TypeVar("Result")


def as_done(
    work: Callable[[Job], Result], jobs: Sequence[Job], *, processes: int = 1, dask: "str | Client | None" = None
) -> Iterator[tuple[int, Result]]:
    """Do jobs, the first of them first, and give each result as soon as it is there.

    Parameters
    ----------
    work : callable
        Of a module, so that other processes find it. It may be called twice for a job where a worker of a cluster was
        lost; one result is given.
    jobs : sequence
    processes : int, at least 1
        Of this computer, by joblib; with 1 the work is done in this process. Within a block of
        `joblib.parallel_config` that block's backend does the work, whichever it is.
    dask : str or distributed.Client, optional
        The cluster that does the work instead, or the address of its scheduler. A job whose worker is lost is done by
        another; one that takes several workers with it is an error.

    Yields
    ------
    index : int
        Which job.
    result : object

    Raises
    ------
    BaseException
        What a job raised, or an interrupt, once the others are stopped.
    ConnectionError, OSError
        If the cluster is not there or goes away.
    MissingExtra
        If Dask is asked for and not installed.
    """
    if not jobs:
        return
    if dask is None:
        yield from _by_joblib(work, jobs, processes)
    else:
        yield from _by_dask(work, jobs, dask)


def _by_joblib(work: Callable[[Job], Result], jobs: Sequence[Job], processes: int) -> Iterator[tuple[int, Result]]:
    parallel = joblib.Parallel(
        processes,
        return_as="generator_unordered",
        batch_size=1,
        pre_dispatch="all",
        initializer=leave_to_parent,
    )
    yield from parallel(joblib.delayed(_numbered)(work, k, job) for k, job in enumerate(jobs))


def _numbered(work: Callable[[Job], Result], index: int, job: Job) -> tuple[int, Result]:
    return index, work(job)


def _by_dask(work: Callable[[Job], Result], jobs: Sequence[Job], dask: "str | Client") -> Iterator[tuple[int, Result]]:
    with optional_import():
        import distributed

    # Not joblib's own backend for Dask: it waits for ever for a job that the cluster has given up.
    client = distributed.Client(dask, set_as_default=False) if isinstance(dask, str) else dask
    futures: dict[Any, int] = {}
    try:
        futures = {
            client.submit(work, job, key=f"stickslip-{uuid4().hex}", priority=-k): k for k, job in enumerate(jobs)
        }
        for future, result in distributed.as_completed(futures, loop=client.loop, with_results=True):
            if future.cancelled():  # the exception is in the result's place
                raise ConnectionError(f"the cluster went away: {result}")
            yield futures[future], result
            future.release()
    finally:
        client.cancel(list(futures))
        if client is not dask:
            client.close()
