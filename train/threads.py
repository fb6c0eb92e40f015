"""Threads of the libraries beside a batch of environments."""

from collections.abc import Iterator
from contextlib import contextmanager

from ..common.extras import optional_import
from ..common.validation import whole_number

with optional_import():
    import torch
    from threadpoolctl import threadpool_limits

__all__ = ["library_threads"]


@contextmanager
def library_threads(count: int) -> Iterator[None]:
    """Let torch and BLAS use at most so many threads each, and give them back what they had.

    Networks of two small layers run fastest on one: the threads of a larger team wait for each other, awake, and keep
    the batch of environments from the processors meanwhile.

    Parameters
    ----------
    count : int, >= 1

    Raises
    ------
    ValueError, TypeError
        If `count` is not such a number.
    """
    count = whole_number("count", count, 1)
    before = torch.get_num_threads()
    torch.set_num_threads(count)
    try:
        with threadpool_limits(count):
            yield
    finally:
        torch.set_num_threads(before)
