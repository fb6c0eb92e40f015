"""The motion that a page shows, and the data of the figures that show it."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..crawler import simulate, Trajectory
from .driving import driven
from .hearing import heard
from .setup import Setup
from .units import Units, units_of

__all__ = ["MOST_LIVE", "WHAT", "Shown", "events_of", "moved", "samples_of", "shown", "shown_holds", "trace_of"]

Array = NDArray[np.float64]

# Natural time that a page shows, and between two of its samples, where the hold allows.
_TIME, _STEP = 24.0, 0.03
_HOLDS, _SAMPLES = (12, 240), (6, 60)

WHAT = ("breaks loose", "comes to rest")
"""What the foot does at an event."""

MOST_LIVE = 600
"""Holds that somebody at the space bar is given before the crawler starts anew."""


class Shown(NamedTuple):
    """A motion, and what drove it."""

    motion: Trajectory
    """In natural units, from rest."""
    command: NDArray[np.int64]
    """(holds,) of 0 and 1: what `motion.valve` would be without flips."""
    doubt: str = ""
    """What the solver warned of, in a sentence."""


def shown_holds(hold: float) -> int:
    """How many holds a page shows."""
    return int(np.clip(round(_TIME / hold), *_HOLDS))


def samples_of(hold: float) -> int:
    """Samples a hold."""
    return int(np.clip(math.ceil(hold / _STEP), *_SAMPLES))


def moved(setup: Setup, valve: NDArray[np.int64], samples_per_hold: int) -> tuple[Trajectory, str]:
    """The motion of a setup's body under given valve states, (holds,), and what the solver warned of."""
    return heard(
        lambda: simulate(
            setup.groups,
            valve,
            setup.hold,
            scene=setup.scene,
            tolerance=setup.tolerance,
            samples_per_hold=samples_per_hold,
        )
    )


def shown(setup: Setup, bits: Sequence[int] = ()) -> Shown:
    """Simulate what a page shows of a setup.

    Parameters
    ----------
    setup : Setup
    bits : sequence of 0 and 1
        What the valve was told at the space bar, hold by hold, if the setup is live; at least one.

    Returns
    -------
    Shown

    Raises
    ------
    SolverError
        As `simulate`.
    """
    if setup.drive == "live":
        command = valve = np.array(bits, np.int64)
    else:
        command, valve = driven(setup, shown_holds(setup.hold))
    motion, doubt = moved(setup, valve, samples_of(setup.hold))
    return Shown(motion, command, doubt)


def trace_of(setup: Setup, what: Shown) -> dict[str, Array]:
    """Columns of what is drawn along time: the start at rest, and every sample.

    Of a long motion at the space bar only the last holds are kept.

    Parameters
    ----------
    setup : Setup
    what : Shown

    Returns
    -------
    dict of str to (samples + 1,) array
        ``time``, ``deformation``, ``velocity``, ``pressure``, ``foot``, ``payload``, in the units of the setup;
        ``sliding``, ``valve`` and ``flipped``, 0 or 1; and ``foot_sliding`` and ``velocity_sliding``, which are the
        foot and the velocity where the foot slides, and not a number elsewhere.
    """
    motion, units = what.motion, units_of(setup)
    per_hold = len(motion.time) // len(motion.valve)
    valve = np.repeat(motion.valve.astype(np.float64), per_hold)
    flipped = np.repeat((motion.valve != what.command).astype(np.float64), per_hold)
    columns = {
        "time": _from(0.0, units.time * motion.time),
        "deformation": _from(0.0, units.length * motion.deformation),
        "velocity": _from(0.0, _speed(units) * motion.velocity),
        "pressure": _from(0.0, units.pressure * motion.pressure),
        "foot": _from(0.0, units.length * motion.foot),
        "payload": _from(0.0, units.length * motion.payload),
        "sliding": _from(0.0, _sliding(motion)),
        "valve": _from(valve[0], valve),
        "flipped": _from(flipped[0], flipped),
    }
    slides = columns["sliding"] > 0.0
    # A line through the slides needs the sample at which each begins.
    begun = slides | np.append(slides[1:], False)
    for name in ("foot", "velocity"):
        columns[f"{name}_sliding"] = np.where(begun, columns[name], np.nan)
    first = max(0, len(motion.valve) - shown_holds(setup.hold)) * per_hold
    return {name: column[first:] for name, column in columns.items()}


def events_of(setup: Setup, what: Shown) -> dict[str, NDArray[Any]]:
    """Where the foot breaks loose and where it comes to rest, between two samples on a straight line.

    Parameters
    ----------
    setup : Setup
    what : Shown

    Returns
    -------
    dict of str to (events,) array
        ``time``, ``deformation``, ``velocity``, ``foot`` in the units of the setup, and ``what``, one of
        :data:`WHAT`; of the part of the motion that `trace_of` keeps.
    """
    trace, units = trace_of(setup, what), units_of(setup)
    time = units.time * what.motion.events["time"]
    kept = time >= trace["time"][0]
    time, mode = time[kept], what.motion.events["mode"][kept]
    along = {name: np.interp(time, trace["time"], trace[name]) for name in ("deformation", "velocity", "foot")}
    return {"time": time, **along, "what": np.where(mode != 0, *WHAT)}


def _from(start: float, values: Array) -> Array:
    return np.concatenate([[start], values])


def _speed(units: Units) -> float:
    return units.length / units.time


def _sliding(motion: Trajectory) -> Array:
    """Whether the foot slides at each sample: by the last event up to then."""
    times, modes = motion.events["time"], motion.events["mode"]
    last = np.searchsorted(times, motion.time, side="right") - 1
    return np.where(last >= 0, modes[last] != 0, False).astype(np.float64) if len(times) else np.zeros(len(motion.time))
