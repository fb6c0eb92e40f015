"""How every kernel is compiled."""

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from typing import Any, cast, TypeVar

from numba.core import config
from numba.core.registry import CPUDispatcher
from numba.extending import register_jitable

from .kernel_cache import KernelCache

__all__ = [
    "INLINED",
    "OPTIONS",
    "Kernel",
    "NotCompiledError",
    "allocating",
    "compiled",
    "formula",
    "inlined",
    "kept_kernels_alone",
    "merged",
]

if vars(config)["DISABLE_JIT"]:
    raise ImportError("stickslip's kernels run compiled only, got NUMBA_DISABLE_JIT=1: unset it")

# Without numba's memory management: counting who refers to a row of an array costs as much as the work on it, and no
# kernel outlives its arrays.
OPTIONS: Any = {"nogil": True, "error_model": "numpy", "_nrt": False}
INLINED: Any = OPTIONS | {"forceinline": True}
Function = TypeVar("Function", bound=Callable[..., Any])

_REFUSING = ContextVar("_REFUSING", default=False)


class NotCompiledError(RuntimeError):
    """A kernel is not kept in the form that is needed, and may not be compiled now."""


@contextmanager
def kept_kernels_alone() -> Iterator[None]:
    """Within, and in this thread, a kernel that would have to be compiled is refused at once.

    Raises
    ------
    NotCompiledError
        Within, by whatever calls the kernel.
    """
    token = _REFUSING.set(True)
    try:
        yield
    finally:
        _REFUSING.reset(token)


def compiled(kernel: Function) -> Function:
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


def allocating(kernel: Function) -> Function:
    """Compile a kernel that makes arrays of its own: others are refused them.

    Parameters
    ----------
    kernel : callable

    Returns
    -------
    callable
    """
    return _compiled(kernel, {"_nrt": True})


def merged(kernel: Function) -> Function:
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


def formula(expression: Function) -> Function:
    """Let compiled code call an ordinary function, which stays one.

    Parameters
    ----------
    expression : callable
        Without branches it can be traced too (`stickslip.compiling.tracing`), over anything that adds and multiplies.

    Returns
    -------
    callable
    """
    return register_jitable(**OPTIONS)(expression)


def inlined(function: Function) -> Function:
    """Let compiled code call a function that becomes a part of the machine code of each that calls it.

    The numbers of its arguments, and there are many in a tuple of tuples, then stay in their registers.

    Parameters
    ----------
    function : callable

    Returns
    -------
    callable
        The same, an ordinary function.
    """
    return register_jitable(**INLINED)(function)


class Kernel(CPUDispatcher):
    """A function that is compiled at its first call, or loaded."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        super().__init__(function, targetoptions={"nopython": True, "boundscheck": None, **options})
        self._cache = KernelCache(function, partial(_missed, function.__qualname__))

    @property
    def unkept(self) -> str:
        """Why a form would be kept nowhere on disk; empty if it would be kept."""
        return self._cache.unkept

    def compile(self, sig: Any) -> Any:
        """Compile or load the form for a signature, unless it is there already."""
        with _interrupts_kept():
            return super().compile(sig)


def _compiled(kernel: Function, options: dict[str, Any]) -> Function:
    return cast("Function", Kernel(kernel, OPTIONS | options))


@contextmanager
def _interrupts_kept() -> Iterator[None]:
    """Raise at the end an interrupt that comes while LLVM calls Python, where nobody would hear of it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    lost = False
    usual = sys.unraisablehook

    def hear(unraisable: Any) -> None:
        nonlocal lost
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            lost = True
        else:
            usual(unraisable)

    sys.unraisablehook = hear
    try:
        yield
    finally:
        sys.unraisablehook = usual
        if lost:
            raise KeyboardInterrupt


def _missed(name: str, folder: str | None, unkept: str) -> None:
    """Before a form is compiled."""
    if _REFUSING.get():
        raise NotCompiledError(f"{name} is not compiled yet")
    _announce(folder, unkept)


_announced = False


def _announce(folder: str | None, unkept: str) -> None:
    """Say once a process that it compiles, how long that takes, and whether it will again."""
    global _announced
    if not _announced:
        _announced = True
        kept = unkept or f"once; kept in {folder}; `stickslip compile` does all of it ahead"
        print(f"stickslip: compiling kernels, up to a minute, {kept}", file=sys.stderr, flush=True)
