"""Lengths of holds as they are given, in natural time or in seconds, and as they are told."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import finite_array, number_within
from .actuator import Actuator
from .variations import HOLDS

__all__ = ["hold_in_seconds", "measured_hold", "natural_hold", "natural_holds", "said_of_hold"]

_NATURAL = "t_c"
# Units as parts of a second: a division by these powers of ten rounds once, so that "31.25 ms" is 1/32 s to the bit.
_PARTS = {"s": 1.0, "ms": 1e3, "us": 1e6, "µs": 1e6}
_WRITTEN = re.compile(rf"\s*([0-9.+\-eE]+)\s*({'|'.join([*_PARTS, _NATURAL])})\s*")


def natural_hold(hold: Any, groups: Any, allowed: str = HOLDS) -> float:
    """Length of a hold in natural time t_c.

    Parameters
    ----------
    hold : float or str
        A number is natural time already. A text has a unit: seconds as "20 ms", "0.02 s" or "20000 us", which only an
        `Actuator` makes natural, by its t_c = sqrt(M / k_1), or "0.5 t_c".
    groups : Groups, str, mapping, Actuator or None
        Of the crawler.
    allowed : str
        Interval of natural time.

    Returns
    -------
    float

    Raises
    ------
    TypeError, ValueError
        If `hold` is neither, in seconds without an actuator, or out of range; the message has both units.
    """
    if not isinstance(hold, str):
        return number_within("hold", hold, allowed)
    value, parts = _written(hold, allowed)
    unit = _unit(groups)
    if parts is None:
        natural = value
    elif unit is None:
        raise ValueError(
            f"hold must be in units of t_c, such as 0.5, where groups is no Actuator, such as ecoflex, which alone "
            f"says how many seconds t_c has; got {hold!r}"
        )
    else:
        natural = value / parts / unit
    try:
        return number_within("hold", natural, allowed)
    except ValueError:
        raise ValueError(f"hold must be in {allowed} t_c{_in_seconds(allowed, unit)}, got {hold!r}") from None


def measured_hold(hold: Any, groups: Any) -> float:
    """Length of a hold in seconds, for what was measured in seconds.

    Parameters
    ----------
    hold : float or str
        A number is in seconds already. A text has a unit, as in `natural_hold`; that of "0.5 t_c" needs an `Actuator`.
    groups : Groups, str, mapping, Actuator or None
        Of the crawler.

    Returns
    -------
    float

    Raises
    ------
    TypeError, ValueError
        If `hold` is neither, in units of t_c without an actuator, or out of range.
    """
    if not isinstance(hold, str):
        return number_within("hold", hold, HOLDS)
    value, parts = _written(hold, HOLDS)
    unit = _unit(groups)
    if parts is not None:
        return number_within("hold", value / parts, HOLDS)
    if unit is None:
        raise ValueError(
            f"hold must be in seconds, such as '20 ms', where groups is no Actuator, such as ecoflex, which alone "
            f"says how many seconds t_c has; got {hold!r}"
        )
    return number_within("hold", value * unit, HOLDS)


def natural_holds(hold: Any, groups: Any, allowed: str = HOLDS) -> float | NDArray[np.float64]:
    """Lengths of the holds of one crawler, or of each of several, in natural time.

    Parameters
    ----------
    hold : float or str, or a sequence of them
        Each as in `natural_hold`: one for all or one for each.
    groups : Groups, str, mapping, Actuator or None, or an iterable of them
        One for all or one for each.
    allowed : str
        Interval of natural time.

    Returns
    -------
    float or (n,) array
        One number where all crawlers have the same, of actuators of the same t_c for example.

    Raises
    ------
    TypeError, ValueError
        As `natural_hold`; also if `hold` and `groups` are not as many.
    """
    several = isinstance(groups, Iterable) and not isinstance(groups, str | Mapping)
    if isinstance(hold, str):
        each = [natural_hold(hold, one, allowed) for one in (groups if several else [groups])]
        return each[0] if len(set(each)) == 1 else np.array(each)
    if not np.ndim(hold):
        return number_within("hold", hold, allowed)
    if np.asarray(hold).dtype.kind != "U":
        return finite_array("hold", hold, 1).copy()
    bodies = list(groups) if several else [groups] * len(hold)
    if len(bodies) != len(hold):
        raise ValueError(f"groups and hold must have as many rows, got {len(bodies)} and {len(hold)}")
    return np.array([natural_hold(one, body, allowed) for one, body in zip(hold, bodies, strict=True)])


def hold_in_seconds(hold: float, groups: Any) -> float | None:
    """Seconds of a hold of natural time; None where `groups` is no `Actuator`, or several that differ in t_c."""
    several = isinstance(groups, Iterable) and not isinstance(groups, str | Mapping)
    units = {_unit(one) for one in groups} if several else {_unit(groups)}
    unit = units.pop()
    return None if units or unit is None else hold * unit


def said_of_hold(hold: float, groups: Any) -> str:
    """A hold in words: "0.5 t_c", and of an actuator "0.5 t_c = 31.25 ms"."""
    seconds = hold_in_seconds(hold, groups)
    return f"{hold:.6g} t_c" + ("" if seconds is None else f" = {1e3 * seconds:.6g} ms")


def _written(hold: str, allowed: str) -> tuple[float, float | None]:
    """A number, and how many of its unit are a second; None of the natural unit."""
    found = _WRITTEN.fullmatch(hold)
    try:
        if found is not None:
            return float(found[1]), _PARTS.get(found[2])
    except ValueError:
        pass
    units = ", ".join([*_PARTS, _NATURAL])
    raise TypeError(f"hold must be a number in {allowed}, or a text of one and its unit ({units}), got {hold!r}")


def _unit(groups: Any) -> float | None:
    """Seconds of t_c, where that is known."""
    return groups.scales.time if isinstance(groups, Actuator) else None


def _in_seconds(allowed: str, unit: float | None) -> str:
    if unit is None:
        return ""
    low, high = (float(end) for end in allowed[1:-1].split(","))
    return f", which is {allowed[0]}{low * unit:.6g}, {high * unit:.6g}{allowed[-1]} s where t_c is {unit:.6g} s"
