"""Measurements from a file of comma-separated columns, named in SI or in natural units.

A row is an instant: its time, the state of the valve, and what was measured then, an empty cell where nothing was. The
hold is found from when the valve turns where nobody says it.
"""

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import number_within
from .measurements import CHANNELS, Measurements

__all__ = ["UNITS", "Log", "read_log"]

_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
_VELOCITIES = {f"{name}_s": factor for name, factor in _LENGTHS.items()}
_PRESSURES = {"Pa": 1.0, "mbar": 1e2, "kPa": 1e3, "bar": 1e5, "MPa": 1e6}
UNITS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "valve": {},
    "deformation": _LENGTHS,
    "velocity": _VELOCITIES,
    "pressure": _PRESSURES,
    "foot": _LENGTHS,
    "foot_velocity": _VELOCITIES,
    "payload": _LENGTHS,
}
"""Columns of a log, and the units in SI that may follow their names, as in ``foot_mm``. Without one it is natural."""
_NEEDED = ("time", "valve")
_GAPS = {"", "nan"}
# The roundest number within so little of the middle of what the samples allow is taken for a hold.
_DIGITS = 15
_COARSE = 0.25  # of a hold, between rows: of wider gaps no hold is found
_SAME_TIME = 1e-6  # of a hold, or of the way between two samples


@dataclass(frozen=True)
class Log:
    """What a file holds.

    Attributes
    ----------
    run : Measurements
    si : bool
        Whether its units are SI, or else natural.
    ignored : tuple of str
        Columns that are no channel.
    """

    run: Measurements
    si: bool
    ignored: tuple[str, ...]


def read_log(file: Path, hold: float | None = None) -> Log:
    """Read one run, which began at rest at time 0, from a file of columns.

    Parameters
    ----------
    file : Path
        Of UTF-8 text: a line of names, and a line a sample, separated by commas, semicolons or tabs. There must be a
        column ``time``, ascending, one ``valve`` of 0 and 1, and one at least of `CHANNELS`: all in natural units,
        or each with a unit of `UNITS`, such as ``time_s`` and ``foot_mm``. An empty cell, or nan, is a gap. Positions
        count from where the body rested.
    hold : float, optional
        Length of a hold, in the unit of time (s in SI). By default the longest of which the valve turns at multiples,
        rounded as far as the samples allow.

    Returns
    -------
    Log

    Raises
    ------
    ValueError
        If the file is no such log; the message names the file, the line and the value. Also if the valve turns within
        a hold, or a hold has no row that tells its valve.
    OSError
        If there is no such file.
    """
    if hold is not None:
        hold = number_within("hold", hold, "(0, inf)")
    table = _Table(file)
    times = table.column("time")
    if gaps := np.flatnonzero(np.isnan(times)).tolist():
        raise ValueError(f"{table.place(gaps[0])}: {table.names['time']} must be a number, got an empty cell")
    for i in np.flatnonzero(np.diff(times, prepend=-math.inf) <= 0.0).tolist():
        raise ValueError(f"{table.place(i)}: {table.names['time']} must ascend, got {table.cell('time', i)}")
    if times[0] < 0.0:
        raise ValueError(f"{table.place(0)}: {table.names['time']} must count from the first hold, got {times[0]:g}")
    valve = table.column("valve")
    for i in np.flatnonzero(~np.isnan(valve) & (valve != 0.0) & (valve != 1.0)).tolist():
        raise ValueError(f"{table.place(i)}: valve must be 0 or 1, got {table.cell('valve', i)}")
    length = _found_hold(times, valve, file) if hold is None else hold
    channels = {name: table.column(name) for name in CHANNELS if name in table.names}
    schedule = _schedule(times, valve, length, table)
    return Log(_run(times, schedule, length, channels), table.si, table.ignored)


class _Table:
    """The cells of a file, and where each stands."""

    def __init__(self, file: Path) -> None:
        self._file = file
        lines = _lines(file)
        try:
            _, header = next(lines)
        except StopIteration:
            raise ValueError(f"{file} must have a line of column names, it is empty") from None
        self.names, self._factors, self.ignored = _columns(file, header)
        self._places = {name: header.index(title) for name, title in self.names.items()}
        self._numbers, self._rows = [], []
        for number, row in lines:
            if len(row) != len(header):
                raise ValueError(f"{file}, line {number}: {len(header)} cells are expected, got {len(row)}")
            self._numbers.append(number)
            self._rows.append(row)
        if not self._rows:
            raise ValueError(f"{file} must have a line a sample, it has none")

    @property
    def si(self) -> bool:
        """Whether the units are SI."""
        return self.names["time"] != "time"

    def place(self, row: int) -> str:
        """Where a row stands, in words."""
        return f"{self._file}, line {self._numbers[row]}"

    def cell(self, name: str, row: int) -> str:
        """What stands there."""
        return self._rows[row][self._places[name]]

    def column(self, name: str) -> NDArray[np.float64]:
        """Numbers of a column, NaN for its gaps."""
        values = np.empty(len(self._rows))
        for i in range(len(values)):
            cell = self.cell(name, i)
            try:
                values[i] = math.nan if cell.lower() in _GAPS else float(cell)
            except ValueError:
                values[i] = math.inf
            if math.isinf(values[i]):
                raise ValueError(f"{self.place(i)}: {self.names[name]} must be a number or empty, got {cell!r}")
        return values * self._factors[name]


def _lines(file: Path) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each line that is not blank."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{file} must be text in UTF-8, it is not") from None
    first = text.partition("\n")[0]
    separator = max(",;\t", key=first.count)
    reader = csv.reader(text.splitlines(), delimiter=separator)
    for row in reader:
        cells = [cell.strip() for cell in row]
        if any(cells):
            yield reader.line_num, cells


def _columns(file: Path, header: Sequence[str]) -> tuple[dict[str, str], dict[str, float], tuple[str, ...]]:
    """Title and factor of each channel among the columns, and the titles of the others."""
    names: dict[str, str] = {}
    factors: dict[str, float] = {}
    ignored = []
    for title in header:
        # Of foot and foot_velocity the longer, if both fit.
        name = max((name for name in UNITS if f"{title}_".startswith(f"{name}_")), key=len, default=None)
        if name is None:
            ignored.append(title)
            continue
        unit = title[len(name) + 1 :]
        if unit and unit not in UNITS[name]:
            allowed = f"one of {', '.join(UNITS[name])}, or none" if UNITS[name] else "none"
            raise ValueError(f"{file}: the unit of {title} must be {allowed}, got {unit!r}")
        if name in names:
            raise ValueError(f"{file} must have one column for the {name}, got {names[name]} and {title}")
        names[name], factors[name] = title, UNITS[name][unit] if unit else 1.0
    for name in _NEEDED:
        if name not in names:
            units = "".join(f", or {name}_{unit}" for unit in list(UNITS[name])[:1])
            raise ValueError(f"{file} must have a column {name}{units}, got {', '.join(header)}")
    measured = [name for name in names if name in CHANNELS]
    if not measured:
        raise ValueError(f"{file} must have a column of {', '.join(CHANNELS)}, got {', '.join(header)}")
    natural = [names[name] for name in ("time", *measured) if names[name] == name]
    if natural and len(natural) <= len(measured):
        other = next(names[name] for name in ("time", *measured) if names[name] != name)
        raise ValueError(f"{file} must be all in SI units or all in natural ones, got {other} and {natural[0]}")
    return names, factors, tuple(ignored)


def _found_hold(times: NDArray[np.float64], valve: NDArray[np.float64], file: Path) -> float:
    """The longest hold of which the valve turns at multiples, as round as the rows allow."""
    told = ~np.isnan(valve)
    t, states = np.append(0.0, times[told]), np.append(valve[told][:1], valve[told])
    turned = np.flatnonzero(np.diff(states))
    if turned.size == 0:
        raise ValueError(f"hold must be given for {file}, whose valve never turns")
    # The valve turns between two rows, one of which may be of the very instant.
    earliest, latest = t[turned], t[turned + 1]
    widest = float(np.max(latest - earliest))
    for parts in range(1, 1 + int(_COARSE * latest[0] / widest)):
        low, high, before = earliest[0] / parts, latest[0] / parts, parts
        for i in range(1, len(turned)):
            count = round((earliest[i] + latest[i]) / (low + high))
            if count <= before:
                break
            low, high, before = max(low, earliest[i] / count), min(high, latest[i] / count), count
            if low > high * (1.0 + _SAME_TIME):
                break
        else:
            return _roundest(low, high)
    raise ValueError(f"hold must be given for {file}: its valve turns at multiples of no one time that its rows tell")


def _roundest(low: float, high: float) -> float:
    """The number of fewest digits in an interval, its ends included but for rounding."""
    low, high = min(low, high), max(low, high)
    for digits in range(1, _DIGITS):
        middle = float(f"{0.5 * (low + high):.{digits}g}")
        if low * (1.0 - 1e-12) <= middle <= high * (1.0 + 1e-12):
            return middle
    return 0.5 * (low + high)


def _schedule(
    times: NDArray[np.float64], valve: NDArray[np.float64], hold: float, table: _Table
) -> NDArray[np.float64]:
    """Valve of each hold, by the rows within it; a row at an edge may tell of either side."""
    holds = math.ceil(times[-1] / hold - _SAME_TIME)
    into = times / hold
    inside = np.abs(into - np.round(into)) > _SAME_TIME
    schedule = np.full(holds, math.nan)
    last: dict[int, int] = {}
    for edge in (False, True):
        for i in np.flatnonzero((inside != edge) & ~np.isnan(valve)).tolist():
            # The row at an edge is taken to tell of the hold that it ends, where nothing else does.
            k = max(math.ceil(into[i] - _SAME_TIME) - 1, 0)
            if math.isnan(schedule[k]):
                schedule[k], last[k] = valve[i], i
            elif not edge and schedule[k] != valve[i]:
                raise ValueError(
                    f"{table.place(i)}: the valve must stay as it is within a hold of {hold:g}, which began at "
                    f"{k * hold:g}, got {valve[i]:g} after {schedule[k]:g}"
                )
    for k in np.flatnonzero(np.isnan(schedule)).tolist():
        raise ValueError(
            f"{table.place(0)} and on: a row must tell the valve of each hold of {hold:g}, none tells that of "
            f"{k * hold:g} to {(k + 1) * hold:g}"
        )
    return schedule


def _run(
    times: NDArray[np.float64], schedule: NDArray[np.float64], hold: float, channels: dict[str, Any]
) -> Measurements:
    """The run, by equally spaced samples where they are."""
    first = int(times[0] < _SAME_TIME * hold)  # at rest, which is known
    each, left = divmod(len(times) - first, len(schedule))
    if each and not left:
        spaced = np.arange(1, len(times) - first + 1) * (hold / each)
        if np.max(np.abs(times[first:] - spaced)) <= _SAME_TIME * hold / each:
            kept = {name: values[first:] for name, values in channels.items()}
            if not any(np.isnan(values).all() for values in kept.values()):
                return Measurements(schedule, hold, each, **kept)
    end = len(schedule) * hold
    return Measurements(schedule, hold, times=np.minimum(times, end), **channels)
