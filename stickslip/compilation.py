"""How every kernel is compiled."""

from collections.abc import Callable
from typing import Any, cast, TypeVar

from numba import njit

__all__ = ["OPTIONS", "compiled"]

OPTIONS: Any = {"nogil": True, "error_model": "numpy"}
Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def compiled(kernel: Kernel) -> Kernel:
    """Compile a kernel at its first call, and keep the result on disk where there is a place for it.

    It runs without Python's global lock, and divides by zero as NumPy does.

    Parameters
    ----------
    kernel : callable

    Returns
    -------
    callable
    """
    try:
        return cast("Kernel", njit(cache=True, **OPTIONS)(kernel))
    except RuntimeError:
        # A read-only installation without a home, as in a container, is compiled anew in every process.
        return cast("Kernel", njit(**OPTIONS)(kernel))
