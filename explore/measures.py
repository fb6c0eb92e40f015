"""What takes a long run to tell: mean speed, memory, and the exponents."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..crawler import lyapunov_spectrum, LyapunovSpectrum
from ..reservoir import memory_capacity, MemoryCapacity
from ..tasks import body_states, innovation
from .driving import driven
from .hearing import heard
from .motion import moved
from .setup import Setup

__all__ = ["DELAYS", "LONG", "NODES", "WASHOUT", "LongRun", "exponents_of", "long_run", "profile_of"]

LONG = 4000
"""Holds of a long run, of which memory is held out on the last 1900."""
WASHOUT = 200
DELAYS = 20
NODES = 4


class LongRun(NamedTuple):
    """What a long run came to."""

    speed: float
    """Of the foot, z_c / t_c."""
    memory: MemoryCapacity | None
    """For the flips; None where there are none."""
    doubt: str
    """Why these numbers are not to be trusted, in a sentence; empty where they are."""
    valve: NDArray[np.int64]
    """(LONG,) of 0 and 1."""


def long_run(setup: Setup) -> LongRun:
    """Speed and memory of a setup.

    Parameters
    ----------
    setup : Setup
        That is not live.

    Returns
    -------
    LongRun

    Raises
    ------
    SolverError
        As `simulate`.
    """
    command, valve = driven(setup, LONG)
    motion, warning = moved(setup, valve, NODES)
    speed = float(motion.foot[-1] / (LONG * setup.hold))
    if setup.dither == 0.0:
        return LongRun(speed, None, warning, valve)
    flips = valve != command
    scored = (LONG + WASHOUT) // 2
    if not (flips[WASHOUT:scored].any() and flips[scored:].any()):
        # What then is left of the message is the word's own period, which anybody can foretell.
        rare = f"flips are so rare that {LONG} holds had none to learn from or to be judged on"
        return LongRun(speed, None, rare, valve)
    message = innovation(valve, command, setup.dither)
    found, doubt = heard(lambda: memory_capacity(body_states(motion), message, DELAYS, washout=WASHOUT))
    return LongRun(speed, found, warning or doubt, valve)


def exponents_of(setup: Setup, valve: NDArray[np.int64]) -> LyapunovSpectrum:
    """Exponents of a setup under what its valve did.

    Parameters
    ----------
    setup : Setup
    valve : (holds,) array of 0 and 1

    Returns
    -------
    LyapunovSpectrum
        In natural units.

    Raises
    ------
    SolverError
        As `simulate`.
    """
    return lyapunov_spectrum(
        setup.groups, valve, setup.hold, scene=setup.scene, tolerance=setup.tolerance, washout=WASHOUT
    )


def profile_of(memory: MemoryCapacity | None) -> dict[str, NDArray[np.float64]]:
    """Columns of the memory figure: ``delay``, ``capacity``, ``cutoff``, and ``found``, 1 above the cutoff."""
    if memory is None:
        return {name: np.empty(0) for name in ("delay", "capacity", "cutoff", "found")}
    cutoff = np.broadcast_to(memory.cutoff, memory.profile.shape).astype(np.float64)
    return {
        "delay": memory.delays.astype(np.float64),
        "capacity": memory.profile,
        "cutoff": cutoff,
        "found": (memory.profile > cutoff).astype(np.float64),
    }
