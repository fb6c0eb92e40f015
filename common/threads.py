"""How many threads the libraries may use, beside a batch of environments or while a task is scored."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from .extras import optional_import
from .validation import whole_number

__all__ = ["library_threads"]


@contextmanager
def library_threads(count: int) -> Iterator[None]:
    """Let BLAS, and torch where it is loaded, use at most so many threads each, and give them back what they had.

    Matrices are small in a task, and so are networks of two layers: the threads of a larger team wait for each other,
    awake, and keep the processors from other work, or from the batch of environments.

    Parameters
    ----------
    count : int, >= 1

    Raises
    ------
    ValueError, TypeError
        If `count` is not such a number.
    """
    count = whole_number("count", count, 1)
    # Only what is loaded is limited, and SciPy has a BLAS of its own.
    import scipy.linalg  # noqa: F401

    # It comes with scikit-learn, whatever the extras.
    with optional_import():
        from threadpoolctl import threadpool_limits

    torch = sys.modules.get("torch")
    before = None if torch is None else torch.get_num_threads()
    try:
        if torch is not None:
            torch.set_num_threads(count)
        with threadpool_limits(count):
            yield
    finally:
        if torch is not None:
            torch.set_num_threads(before)
