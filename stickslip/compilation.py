"""How every kernel is compiled."""

from collections.abc import Callable
from typing import Any, cast, TypeVar

from numba import njit
from numba.extending import register_jitable

__all__ = ["OPTIONS", "allocating", "compiled", "formula", "merged"]

# Without numba's memory management: counting who refers to a row of an array costs as much as the work on it, and no
# kernel outlives its arrays.
OPTIONS: Any = {"nogil": True, "error_model": "numpy", "_nrt": False}
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


def allocating(kernel: Kernel) -> Kernel:
    """Compile a kernel that makes arrays of its own: others are refused them.

    Parameters
    ----------
    kernel : callable

    Returns
    -------
    callable
    """
    return _compiled(kernel, {"_nrt": True})


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


def formula(expression: Kernel) -> Kernel:
    """Let compiled code call an expression that can be traced too (`stickslip.unrolling`).

    Parameters
    ----------
    expression : callable
        Arithmetic without branches: it stays an ordinary function, over anything that adds and multiplies.

    Returns
    -------
    callable
    """
    return register_jitable(**OPTIONS)(expression)


def _compiled(kernel: Kernel, options: dict[str, Any]) -> Kernel:
    try:
        return cast("Kernel", njit(cache=True, **OPTIONS | options)(kernel))
    except RuntimeError:
        # A read-only installation without a home, as in a container, is compiled anew in every process.
        return cast("Kernel", njit(**OPTIONS | options)(kernel))
