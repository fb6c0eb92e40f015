"""What a visitor looks at, what he can do to it, and what a page tells of it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..common.validation import whole_number
from .front import front_at
from .link import query_of
from .measures import LongRun
from .motion import MOST_LIVE, Shown
from .presets import preset
from .setup import changed, LONGEST_WORD, Setup, without_effect
from .snippet import program_of
from .units import in_si, units_of

__all__ = ["View", "acted", "told_of_exponents", "told_of_long_run", "told_of_motion", "told_of_setup"]

_AT_REST = (0,)


@dataclass(frozen=True)
class View:
    """What a visitor looks at.

    Attributes
    ----------
    setup : Setup
    bits : tuple of 0 and 1
        What the valve was told so far, if the setup is live; it begins with a hold at rest.
    """

    setup: Setup
    bits: tuple[int, ...] = _AT_REST


def acted(view: View, action: Mapping[str, Any]) -> View:
    """The view after an action of the visitor's.

    Parameters
    ----------
    view : View
    action : mapping
        With ``do``: "set" the field ``name`` to ``value``, take the "preset" ``name``, tell the valve the "bit"
        ``value`` for one more hold, "keep" the last bits as a word, or "restart".

    Returns
    -------
    View
        Whatever changes the crawler begins anew from rest.

    Raises
    ------
    ValueError, TypeError
        If the action is unknown or not allowed; the message says why.
    """
    doing = action.get("do")
    if doing == "bit":
        bit = whole_number("bit", action.get("value"), 0, 1)
        return replace(view, bits=_AT_REST if len(view.bits) >= MOST_LIVE else (*view.bits, bit))
    if doing == "set":
        return View(changed(view.setup, str(action.get("name")), action.get("value")))
    if doing == "preset":
        return View(replace(preset(str(action.get("name"))), units=view.setup.units))
    if doing == "keep":
        word = "".join(map(str, view.bits[-LONGEST_WORD:]))
        return View(replace(view.setup, drive="word", word=word))
    if doing == "restart":
        return View(view.setup)
    raise ValueError(f"action must be set, preset, bit, keep or restart, got {doing!r}")


def told_of_setup(view: View) -> dict[str, Any]:
    """What a page says of what was asked for, before the crawler has moved, ready for JSON."""
    setup = view.setup
    return {
        "setup": setup.to_dict(),
        "without_effect": without_effect(setup),
        "si": in_si(setup),
        "query": query_of(setup),
        "program": program_of(setup, view.bits),
    }


def told_of_motion(view: View, what: Shown) -> dict[str, Any]:
    """What a page says of the crawler beside the figures as soon as it has moved, ready for JSON.

    Parameters
    ----------
    view : View
    what : Shown

    Returns
    -------
    dict
    """
    setup, motion = view.setup, what.motion
    units = units_of(setup)
    return {
        "moved": setup.to_dict(),
        "units": {**units._asdict(), "speed_unit": units.speed_unit},
        "holds": len(motion.valve),
        "distance": units.length * float(motion.foot[-1]),
        "time": units.time * float(motion.time[-1]),
        "slips": int(motion.slips),
        "model": motion.model,
    }


def told_of_long_run(setup: Setup, run: LongRun) -> dict[str, Any]:
    """What a page says of speed and memory, ready for JSON: None where there is no memory to speak of."""
    units = units_of(setup)
    memory = run.memory
    return {
        "speed": run.speed * units.length / units.time,
        "memory": None if memory is None else memory.corrected,
        "bound": None if memory is None else memory.bound,
        "doubt": run.doubt,
        "holds": len(run.valve),
        "front": front_at(setup.dither)[0],
    }


def told_of_exponents(setup: Setup, spectrum: Any) -> dict[str, Any]:
    """What a page says of the exponents, ready for JSON."""
    time = units_of(setup).time
    return {
        "exponents": [float(each) / time for each in spectrum.exponents],
        "errors": [float(each) / time for each in spectrum.standard_error],
        "verdict": spectrum.verdict,
    }
