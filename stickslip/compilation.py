"""How every kernel is compiled."""

from collections.abc import Callable
from typing import Any, cast, TypeVar

from numba import njit

__all__ = ["OPTIONS", "compiled", "merged"]

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
    return _compiled(kernel, {})


def merged(kernel: Kernel) -> Kernel:
    """Compile a kernel as a part of each that calls it.

    As one of its own, a large kernel is optimised once by itself and again in every kernel above it.

    Parameters
    ----------
    kernel : callable

    Returns
    -------
    callable
    """
    return _compiled(kernel, {"inline": "always"})


def _compiled(kernel: Kernel, options: dict[str, Any]) -> Kernel:
    try:
        return cast("Kernel", njit(cache=True, **OPTIONS, **options)(kernel))
    except RuntimeError:
        # A read-only installation without a home, as in a container, is compiled anew in every process.
        return cast("Kernel", njit(**OPTIONS, **options)(kernel))
