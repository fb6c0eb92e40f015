"""How many threads BLAS may use while a task is scored."""

from collections.abc import Iterator
from contextlib import contextmanager

from .extras import optional_import

__all__ = ["one_thread"]


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep BLAS to the thread that calls it.

    Matrices are small in a task: where other work has the processors, further threads wait for one another and make a
    score several times slower.
    """
    # Only what is loaded is limited, and SciPy has a BLAS of its own.
    import scipy.linalg  # noqa: F401

    # It comes with scikit-learn, whatever the extras.
    with optional_import():
        from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield
