"""The valve, which is left shut whatever happens."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ..common.validation import number_within

__all__ = ["shut_at_the_end", "turning"]

_TRIES = 3
# Of a request to terminate, of a terminal or a connection that is gone, and of Ctrl-\; not every system has all.
_ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGQUIT") if hasattr(signal, name)]


def turning(write: Callable[[Any], Any], volts: tuple[float, float] | None) -> Callable[[int], Any]:
    """A function of the valve's state: 0 shut, 1 open.

    Parameters
    ----------
    write : callable
        Takes the state, or the volts.
    volts : (float, float) or None
        Of the shut and of the open valve; None where `write` takes the state.

    Raises
    ------
    TypeError, ValueError
        If `write` is no callable, or the volts are no two different finite numbers.
    """
    if not callable(write):
        raise TypeError(f"write must be callable, got {write!r}")
    if volts is None:
        return write
    if not isinstance(volts, tuple | list) or len(volts) != 2:
        raise TypeError(f"volts must be those of the shut and of the open valve, such as (0, 24), got {volts!r}")
    shut, opened = (number_within("volts", each, "(-inf, inf)") for each in volts)
    if shut == opened:
        raise ValueError(f"volts must differ for the shut and the open valve, got {volts!r}")
    return lambda valve: write(opened if valve else shut)


@contextmanager
def shut_at_the_end(turn: Callable[[int], Any]) -> Iterator[None]:
    """Shut the valve when the block ends, by an exception, an interrupt, a request to terminate or a lost terminal too.

    Raises
    ------
    RuntimeError
        If it cannot be shut, after three tries.
    """
    with _termination_raised():
        try:
            yield
        finally:
            _shut(turn)


def _shut(turn: Callable[[int], Any]) -> None:
    for tried in range(1, _TRIES + 1):
        try:
            turn(0)
        except BaseException as error:  # an impatient second interrupt among them
            if tried == _TRIES:
                raise RuntimeError(f"the valve could not be shut: {type(error).__name__}: {error}") from error
        else:
            return


@contextmanager
def _termination_raised() -> Iterator[None]:
    """Let the signals that would end the process, with the valve as it is, raise as an interrupt does."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread is told of signals
        return

    def end(number: int, _: Any) -> None:
        raise SystemExit(128 + number)

    # Those that are ignored, as nohup has it, stay so.
    handlers = {number: signal.getsignal(number) for number in _ENDING}
    before = {number: handler for number, handler in handlers.items() if handler not in (signal.SIG_IGN, None)}
    for number in before:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
