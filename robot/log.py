"""What a run has measured, kept in memory while it lasts and written as columns when it is over."""

import math
import tempfile
from array import array
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..common.files import write_text
from .sensors import SENSORS

__all__ = ["Log", "refuse_unwritable"]

# In the order of the columns, with the unit that each is written in.
_UNITS = {
    "deformation": "mm",
    "velocity": "mm_s",
    "pressure": "kPa",
    "foot": "mm",
    "foot_velocity": "mm_s",
    "payload": "mm",
}
_NONE = math.nan


class Log:
    """Rows of numbers: the time, the valve from then on, the command that it came of, and what was measured.

    Writing to a disk now and then holds a loop up; a row here is eight bytes a number.
    """

    def __init__(self) -> None:
        self._channels: tuple[str, ...] = ()
        self._numbers = array("d")

    def add(self, time: float, valve: int | None, command: int | None, measured: dict[str, float]) -> None:
        """Keep a row; what is measured, in SI, is the same in every one."""
        if not self._channels:
            self._channels = tuple(name for name in _UNITS if name in measured)
        states = (_NONE if state is None else state for state in (valve, command))
        self._numbers.extend((time, *states, *[measured[name] for name in self._channels]))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the columns."""
        return "time_s", "valve", "command", *[f"{name}_{_UNITS[name]}" for name in self._channels]

    @property
    def rows(self) -> NDArray[np.float64]:
        """A row a reading, in the units of the names; not a number where there was no command, or no valve is told."""
        rows = np.array(self._numbers).reshape(-1, len(self.names))
        rows[:, 3:] *= [SENSORS[name][_UNITS[name]] for name in self._channels]
        return rows

    def write(self, file: Path) -> None:
        """Write a file of comma-separated columns, whole or not at all.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        lines = [",".join(self.names), *(_line(row) for row in self.rows.tolist())]
        write_text(file, "\n".join(lines) + "\n")


def refuse_unwritable(file: Path) -> None:
    """Refuse a file that could not be written when a run is over, since nobody can repeat a run.

    Raises
    ------
    OSError
        If its folder is missing or takes no files, or it is a folder itself.
    """
    if file.is_dir():
        raise IsADirectoryError(f"log must be a file, {file} is a folder")
    if not file.parent.is_dir():
        raise FileNotFoundError(f"log must be in a folder that is there, {file.parent} is none")
    tempfile.TemporaryFile(dir=file.parent).close()


def _line(row: Sequence[float]) -> str:
    states = ["" if math.isnan(state) else f"{state:.0f}" for state in row[1:3]]
    return ",".join([f"{row[0]:.9g}", *states, *(f"{value:.9g}" for value in row[3:])])
