"""Time as a runner sees it: real, or jumping from one deadline to the next."""

import time
from typing import Protocol

from ..common.validation import number_within

__all__ = ["Clock", "RealClock", "VirtualClock"]


class Clock(Protocol):
    """What a runner asks for the time."""

    def now(self) -> float:
        """Seconds since some instant; they never go back."""

    def sleep_until(self, instant: float) -> None:
        """Return at that instant, or at once if it is past."""


class RealClock:
    """The system's monotonic clock, which nobody sets.

    Parameters
    ----------
    pace : float, in (0, inf)
        Seconds told for one that passes: above 1 for a dry run that is faster than real.
    """

    def __init__(self, pace: float = 1.0) -> None:
        self._pace = number_within("pace", pace, "(0, inf)")
        self._began = time.monotonic()

    def now(self) -> float:
        """Seconds since it was made."""
        return (time.monotonic() - self._began) * self._pace

    def sleep_until(self, instant: float) -> None:
        """Return at that instant, or at once if it is past."""
        while (left := instant - self.now()) > 0.0:
            time.sleep(left / self._pace)


class VirtualClock:
    """A clock that stands still until somebody sleeps, and is then where he wants to wake.

    A dry run by it takes as long as its arithmetic, misses no deadline, and is the same every time.
    """

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        """Seconds since it was made."""
        return self._now

    def sleep_until(self, instant: float) -> None:
        """Be at that instant, unless it is past."""
        self._now = max(self._now, instant)
