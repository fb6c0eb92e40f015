"""Measurements from a file of comma-separated columns, named in SI or in natural units.

A row is an instant: its time, the state of the valve, and what was measured then, an empty cell where nothing was. The
hold is found from when the valve turns where nobody says it.
"""

import csv
import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...crawler import GroupsLike
from ...crawler.model.channels import CHANNEL_UNITS, TIME_UNITS
from ...crawler.model.holds import measured_hold, natural_hold
from .measurements import CHANNELS, Measurements

__all__ = ["UNITS", "Log", "read_log"]

UNITS = {"time": TIME_UNITS, "valve": {}, **CHANNEL_UNITS}
"""Columns of a log, and the units that may follow their names, as in ``foot_mm``, with how many are one of SI. Without
one it is natural."""
_NEEDED = ("time", "valve")
_GAPS = {"", "nan"}
_DIGITS = 10  # that a round number may have
_CHANCE = 0.1  # that an interval has a round number in it which nobody set
_ROUNDING = 1e-12  # relative, of numbers
_ROUNDED = 0.75  # of the last digit of times: as far off are those that are rounded to it
_FINE = 0.2  # of the way between two rows, above which a missing row would look like rounding
_FEW = 10  # rows that do not tell whether they are equally spaced
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
    hold_bounds : (least, greatest) or None
        Between which the rows let the hold be, where it was found from the turns of the valve.
    """

    run: Measurements
    si: bool
    ignored: tuple[str, ...]
    hold_bounds: tuple[float, float] | None


def read_log(file: Path, hold: float | str | None = None, groups: GroupsLike | None = None) -> Log:
    """Read one run, which began at rest at time 0, from a file of columns.

    Parameters
    ----------
    file : Path
        Of UTF-8 text: a line of names, and a line a sample, separated by commas, semicolons or tabs. There must be a
        column ``time``, ascending, one ``valve`` of 0 and 1, and one at least of `CHANNELS`: all in natural units,
        or each with a unit of `UNITS`, such as ``time_s`` and ``foot_mm``. An empty cell, or nan, is a gap. Positions
        count from where the body rested.
    hold : float or str, optional
        Length of a hold: a number is in the file's unit of time (s in SI), and a text has its own, as in `simulate`. By
        default the longest of which the valve turns at multiples.
        The rows tell it within bounds. Of these the middle is taken, or what somebody may have set, where that is
        hardly there by chance: a whole number of equally spaced rows, a round time, a round rate.
    groups : Groups, str, mapping or Actuator, optional
        Of the crawler: an `Actuator` says how many seconds t_c has, where `hold` is in the other unit than the file.

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
    table = _Table(file)
    given = None if hold is None else measured_hold(hold, groups) if table.si else natural_hold(hold, groups)
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
    times = _evened(times, table.last_digit("time"))
    length, bounds = _found_hold(times, valve, file) if given is None else (given, None)
    channels = {name: table.column(name) for name in CHANNELS if name in table.names}
    schedule = _schedule(times, valve, length, table)
    return Log(_run(times, schedule, length, channels), table.si, table.ignored, bounds)


class _Table:
    """The cells of a file, and where each stands."""

    def __init__(self, file: Path) -> None:
        self.file = file
        lines = _lines(file)
        try:
            _, header = next(lines)
        except StopIteration:
            raise ValueError(f"{file} must have a line of column names, it is empty") from None
        self.names, self._parts, self.ignored = _columns(file, header)
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
        return f"{self.file}, line {self._numbers[row]}"

    def cell(self, name: str, row: int) -> str:
        """What stands there."""
        return self._rows[row][self._places[name]]

    def last_digit(self, name: str) -> float:
        """The unit of the last digit that any number of a column is written with."""
        place = min(int(Decimal(self.cell(name, i)).as_tuple().exponent) for i in range(len(self._rows)))
        return 10.0**place / self._parts[name]

    def column(self, name: str) -> NDArray[np.float64]:
        """Numbers of a column, NaN for its gaps."""
        values = np.empty(len(self._rows))
        for i in range(len(values)):
            cell = self.cell(name, i)
            try:
                values[i] = math.nan if cell.lower() in _GAPS else float(cell)
            except ValueError:
                values[i] = math.inf
            if "_" in cell:  # which Python reads over, as in 1_000
                values[i] = math.inf
            if math.isinf(values[i]):
                raise ValueError(f"{self.place(i)}: {self.names[name]} must be a number or empty, got {cell!r}")
        return values / self._parts[name]


def _lines(file: Path) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each line that is not blank."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{file} must be text in UTF-8, it is not") from None
    first = text.partition("\n")[0]
    separator = max(",;\t", key=first.count)
    reader = csv.reader(io.StringIO(text), delimiter=separator)
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells):
                yield reader.line_num, cells
    except csv.Error as error:
        raise ValueError(f"{file}, line {reader.line_num}: cells must be of a CSV file, got a {error}") from None


def _columns(file: Path, header: Sequence[str]) -> tuple[dict[str, str], dict[str, float], tuple[str, ...]]:
    """Title of each channel among the columns and how many of its unit are one of SI, and the titles of the others."""
    names: dict[str, str] = {}
    parts: dict[str, float] = {}
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
        names[name], parts[name] = title, UNITS[name][unit] if unit else 1.0
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
    return names, parts, tuple(ignored)


def _found_hold(
    times: NDArray[np.float64], valve: NDArray[np.float64], file: Path
) -> tuple[float, tuple[float, float]]:
    """The longest hold of which the valve turns at multiples, and the least and greatest that the rows allow."""
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
            low, high = float(min(low, high)), float(max(low, high))
            return _likeliest(low, high, times), (low, high)
    raise ValueError(f"hold must be given for {file}: its valve turns at multiples of no one time that its rows tell")


def _likeliest(low: float, high: float, times: NDArray[np.float64]) -> float:
    """The hold in an interval that somebody may have set: so many rows, a round time or a round rate.

    Each only where an interval of this length has one by chance in less than a tenth of all cases; else the middle.
    """
    row = float(times[-1] - times[0]) / max(len(times) - 1, 1)
    even = np.max(np.abs(times - times[0] - row * np.arange(len(times)))) <= _SAME_TIME * row
    rows = round(0.5 * (low + high) / row) if even else 0
    within = _SAME_TIME * low
    if high - low < _CHANCE * row and low - within <= rows * row <= high + within:
        low, high = rows * row - within, rows * row + within
    for digits in range(1, _DIGITS):
        if time := _round_between(low, high, digits):
            return time
        if rate := _round_between(1.0 / high, 1.0 / low, digits):
            return 1.0 / rate
    return 0.5 * (low + high)


def _round_between(low: float, high: float, digits: int) -> float | None:
    """A number of so many digits in an interval, its ends included, if few so long would have one by chance."""
    middle = 0.5 * (low + high)
    step = 10.0 ** (math.floor(math.log10(middle)) + 1 - digits)
    found = float(f"{middle:.{digits}g}")
    inside = low * (1.0 - _ROUNDING) <= found <= high * (1.0 + _ROUNDING)
    return found if inside and high - low < _CHANCE * step else None


def _evened(times: NDArray[np.float64], unit: float) -> NDArray[np.float64]:
    """Times whose rows are equally spaced but for the rounding to a multiple of some unit, without this rounding."""
    rows = np.arange(len(times))
    if len(times) < _FEW:
        return times
    step, begin = np.polyfit(rows, times, 1)
    since = step * rows
    for even in (since + round(begin / step) * step, since + begin):
        off = np.max(np.abs(times - even))
        if _SAME_TIME * step < off <= _ROUNDED * unit <= _FINE * step:
            return np.maximum(even, 0.0)
    return times


def _schedule(
    times: NDArray[np.float64], valve: NDArray[np.float64], hold: float, table: _Table
) -> NDArray[np.float64]:
    """Valve of each hold, by the rows within it; a row at an edge may tell of either side."""
    holds = max(1, math.ceil(times[-1] / hold - _SAME_TIME))
    if holds > len(times):
        raise ValueError(
            f"hold must be such that a row tells the valve of each, got {hold:g} for the {len(times)} rows of "
            f"{table.file}, which last {times[-1]:g}"
        )
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
