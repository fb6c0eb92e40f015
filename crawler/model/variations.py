"""Numbers of a crawler that vary, in the words that randomized episodes, sweeps and searches share.

A mapping such as ``{"duffing": (0, 5), "slope": (-0.1, 0.1), "hold": Range(0.1, 10, log=True)}`` names what varies and
says between what. A share in [0, 1] of each way makes numbers of it, and :func:`varied` a crawler of numbers.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...common.validation import known_names, number_within, truth_value
from .groups import Groups, GroupsLike, RANGES
from .scene import Scene

__all__ = ["HOLDS", "VARIED", "Choice", "Range", "Variation", "variations", "varied", "with_amplitude"]

HOLDS = "(0, inf)"
"""Lengths that a hold may have."""

VARIED = {"hold": HOLDS, "amplitude": "(0, inf)", **RANGES, "slope": "(-inf, inf)"}
"""What can vary, and the values that it may take: the hold, the amplitude of the pressure, the groups and the slope."""


@dataclass(frozen=True)
class Range:
    """Numbers from `low` to `high`, evenly spread, or evenly in their logarithms.

    Attributes
    ----------
    low, high : float
        The first at most the second; both positive if `log`.
    log : bool
    """

    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        low = number_within("low", self.low, "(0, inf)" if self.log else "(-inf, inf)")
        number_within("high", self.high, f"[{low!r}, inf)")

    def at(self, share: float) -> float:
        """The number at a share in [0, 1] of the way."""
        if self.log:
            return self.low * (self.high / self.low) ** share
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class Choice:
    """One of some values that have no order.

    Attributes
    ----------
    values : sequence
    """

    values: Sequence[Any]

    def __post_init__(self) -> None:
        if not len(self.values):
            raise ValueError("values must hold one at least to choose from, got none")

    def at(self, share: float) -> Any:
        """The value that a share in [0, 1] falls on."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]


Variation = Range | Choice


def variations(argument: str, given: Mapping[str, Any] | None, allowed: Iterable[str] = VARIED) -> dict[str, Range]:
    """Check what varies, and between what.

    Parameters
    ----------
    argument : str
        What the caller calls the mapping.
    given : mapping of str to (low, high) or Range, or None
        A pair is evenly spread; what JSON has in place of a range is a mapping of its attributes. None varies nothing.
    allowed : iterable of str
        The names, among those of :data:`VARIED`, that may vary here.

    Returns
    -------
    dict of str to Range
        In the order of `allowed`.

    Raises
    ------
    TypeError
        If `given` is no mapping, or an end is no number.
    ValueError
        If a name is not allowed, or a value is no pair in ascending order within what its number may be.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise TypeError(f"{argument} must be a mapping of names to (low, high), got {given!r}")
    names = list(allowed)
    known_names(argument, given, names)
    return {name: _range(f"{argument} {name}", given[name], VARIED[name]) for name in names if name in given}


def _range(name: str, given: Any, interval: str) -> Range:
    if isinstance(given, Mapping):
        known_names(name, given, ("low", "high", "log"))
        pair: Any = [given[end] for end in ("low", "high") if end in given]
    else:
        pair = (given.low, given.high) if isinstance(given, Range) else given
    if isinstance(pair, str) or not isinstance(pair, Sequence | np.ndarray) or len(pair) != 2:
        raise ValueError(f"{name} must be a pair (low, high), got {given!r}")
    low, high = (number_within(name, end, interval) for end in pair)
    if low > high or high - low == np.inf:
        raise ValueError(f"{name} must be a pair with low <= high, got {given!r}")
    log = given.get("log", False) if isinstance(given, Mapping) else isinstance(given, Range) and given.log
    return Range(low, high, truth_value(f"{name} log", log))


def varied(groups: Groups, scene: Scene, hold: float, numbers: Mapping[str, float]) -> tuple[Groups, Scene, float]:
    """A crawler some of whose numbers are others.

    Parameters
    ----------
    groups : Groups
    scene : Scene
    hold : float, in (0, inf)
    numbers : mapping of str to float
        By names of :data:`VARIED`. An amplitude is that of :func:`with_amplitude`, on the body of the other numbers.

    Returns
    -------
    groups : Groups
    scene : Scene
    hold : float

    Raises
    ------
    ValueError
        If a name is unknown or a number out of range.
    """
    known_names("numbers", numbers, VARIED)
    of_groups = {name: value for name, value in numbers.items() if name in RANGES}
    if of_groups:
        groups = replace(groups, **of_groups)
    if "amplitude" in numbers:
        groups = with_amplitude(groups, numbers["amplitude"])
    if "slope" in numbers:
        scene = replace(scene, slope=numbers["slope"])
    return groups, scene, number_within("hold", numbers.get("hold", hold), HOLDS)


def with_amplitude(groups: GroupsLike, amplitude: float) -> Groups:
    """The same body under so many times the peak pressure, in the units that go with it.

    Length, and with it force, is measured by the peak pressure: ``z_c = P_max A_0 / k_1``. So Pi1 = k_3 z_c^2 / k_1
    grows with its square, Pi5 = alpha z_c in proportion, and friction over P_max A_0 shrinks.

    Parameters
    ----------
    groups : Groups, str, mapping or Actuator
    amplitude : float, in (0, inf)
        Peak pressure, relative to that of `groups`.

    Returns
    -------
    Groups

    Raises
    ------
    ValueError
        If `amplitude` is out of range.
    """
    amplitude = number_within("amplitude", amplitude, VARIED["amplitude"])
    groups = Groups.of(groups)
    return replace(
        groups,
        duffing=groups.duffing * amplitude**2,
        radial_coupling=groups.radial_coupling * amplitude,
        static_friction=groups.static_friction / amplitude,
        kinetic_friction=groups.kinetic_friction / amplitude,
    )
