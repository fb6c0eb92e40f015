"""What sensors tell: numbers with their units in their names, made SI and checked."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from ..common.validation import number_within
from ..crawler.model.channels import CHANNEL_UNITS

__all__ = ["SENSORS", "Limits", "Readings", "SensorError", "Sensors", "unit_of"]

SENSORS = CHANNEL_UNITS
"""What may be measured, and the units that follow its name, as in ``deformation_mm``, with how many are one of SI."""

Limits = Mapping[str, tuple[float, float]]
"""Least and greatest by the sensors' names with their units, such as ``{"pressure_kPa": (-2, 30)}``."""

# Two of the three positions tell the third.
_ENOUGH = "deformation, foot and payload (two of these), or deformation and foot_velocity"


class SensorError(RuntimeError):
    """A sensor is missing, tells no number, or one that cannot be."""


class Readings(NamedTuple):
    """One reading in SI: what was measured, or follows from two positions that were; None of what was not."""

    deformation: float
    velocity: float | None
    pressure: float | None
    foot: float | None
    foot_velocity: float | None


class Sensors:
    """Readings by name, checked.

    Parameters
    ----------
    limits : mapping, optional
        See :data:`Limits`. What lies outside ends the run.

    Raises
    ------
    ValueError, TypeError
        If the limits name no sensor, or one twice, or are no pairs in ascending order.
    """

    def __init__(self, limits: Limits | None = None) -> None:
        self._limits: dict[str, tuple[float, float]] = {}
        if limits is not None and not isinstance(limits, Mapping):
            raise TypeError(f"limits must be a mapping such as {{'pressure_kPa': (-2, 30)}}, got {limits!r}")
        for name, pair in (limits or {}).items():
            channel, parts = unit_of(name)
            if not isinstance(pair, tuple | list) or len(pair) != 2:
                raise TypeError(f"limits of {name} must be a pair (least, greatest), got {pair!r}")
            least = number_within(f"limits of {name}", pair[0], "(-inf, inf)")
            greatest = number_within(f"limits of {name}", pair[1], f"[{least!r}, inf)")
            if channel in self._limits:
                raise ValueError(f"limits of {channel} must be given once, got {list(limits or ())}")
            self._limits[channel] = least / parts, greatest / parts
        self._columns: tuple[tuple[str, str, float], ...] = ()

    @property
    def columns(self) -> tuple[tuple[str, str, float], ...]:
        """Key, sensor and units in one of SI of all that is measured; empty before the first reading."""
        return self._columns

    def measured(self, given: Any) -> dict[str, float]:
        """What sensors told, in SI, by the sensors of :data:`SENSORS`.

        Parameters
        ----------
        given : mapping of str to float
            Names with units. The first reading says which there are; every later one must have all of them.

        Raises
        ------
        SensorError
            If one is missing, is no finite number or lies outside the limits.
        """
        if not isinstance(given, Mapping):
            raise SensorError(f"read must return a mapping of names such as deformation_mm to numbers, got {given!r}")
        if not self._columns:
            self._columns = _columns(given, self._limits)
        found = {}
        for key, channel, parts in self._columns:
            value = given.get(key)
            try:
                number = float(value)  # type: ignore[arg-type]
            except (TypeError, ValueError, OverflowError):
                number = math.nan
            if not math.isfinite(number):
                raise SensorError(f"sensor {key} must tell a number, got {value!r}")
            found[channel] = number / parts
        for channel, (least, greatest) in self._limits.items():
            if not least <= found[channel] <= greatest:
                raise SensorError(
                    f"sensor {channel} must be within its limits [{least:.6g}, {greatest:.6g}], got "
                    f"{found[channel]:.6g} in SI units"
                )
        return found


def readings_of(measured: Mapping[str, float]) -> Readings:
    """What was measured, with the third of two positions."""
    get = measured.get
    deformation, foot, payload = get("deformation"), get("foot"), get("payload")
    if deformation is None:
        deformation = measured["payload"] - measured["foot"]
    if foot is None and payload is not None:
        foot = payload - deformation
    return Readings(deformation, get("velocity"), get("pressure"), foot, get("foot_velocity"))


def unit_of(name: str) -> tuple[str, float]:
    """A sensor and how many of its unit are one of SI, by its name with the unit.

    Raises
    ------
    ValueError
        If it is none.
    """
    # Of foot and foot_velocity the longer, if both fit.
    for channel in sorted(SENSORS, key=len, reverse=True):
        unit = str(name).removeprefix(f"{channel}_")
        if str(name) != unit and unit in SENSORS[channel]:
            return channel, SENSORS[channel][unit]
    raise ValueError(
        f"sensors must be of {list(SENSORS)}, each with a unit after it such as deformation_mm, velocity_mm_s and "
        f"pressure_kPa, got {name!r}"
    )


def _columns(given: Mapping[str, Any], limits: Mapping[str, Any]) -> tuple[tuple[str, str, float], ...]:
    try:
        columns = tuple((str(key), *unit_of(key)) for key in given)
    except ValueError as error:
        raise SensorError(str(error)) from None
    channels = [channel for _, channel, _ in columns]
    if twice := sorted({channel for channel in channels if channels.count(channel) > 1}):
        raise SensorError(f"sensor {twice[0]} must be told once, got {list(given)}")
    positions = {"deformation", "foot", "payload"}.intersection(channels)
    if len(positions) < 2 and not {"deformation", "foot_velocity"} <= set(channels):
        raise SensorError(f"sensors must tell {_ENOUGH}, got {list(given)}")
    if unknown := sorted(set(limits) - set(channels)):
        raise SensorError(f"limits must be of sensors that are read, {list(given)}, got some of {unknown[0]}")
    return columns
