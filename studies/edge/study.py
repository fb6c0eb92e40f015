"""How much of everything a study of the edge of chaos takes, and its maps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TYPE_CHECKING

from ..maps import parameter_map

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["DEBORAH", "DUFFING", "FULL", "PLACES", "QUICK", "READ", "Size", "Study"]

DUFFING = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
"""Columns of a map."""
DEBORAH = (0.05, 8.0)
"""First and last row of a map, equally spaced in their logarithm."""
PLACES: dict[str, dict[str, Any]] = {"anchored": {"anchored": True}, "ground": {}}
"""Scenes by name."""
READ = {"raw": 1, "4 nodes": 4}
"""Virtual nodes by the name of what is read."""


@dataclass(frozen=True)
class Size:
    """How much of everything.

    Attributes
    ----------
    name : str
        Of the folder in which maps of this size are kept.
    columns : int
        Every so manieth of `DUFFING` is a column of a map.
    rows, seeds, holds : int
        Of a map.
    line, line_holds : int
        Cells of the line through the edge, and holds of each.
    ground, chain : int
        Columns of the map at low damping, and rows and columns of that of a chain.
    words : int
        Periodic words that are tried.
    long_holds, long_delays : int
        Of the map whose bodies remember beyond 20 delays.
    """

    name: str
    columns: int
    rows: int
    seeds: int
    holds: int
    line: int
    line_holds: int
    ground: int
    chain: int
    words: int
    long_holds: int
    long_delays: int


FULL = Size("full", 1, 7, 8, 2000, 33, 4000, 7, 5, 300, 8000, 150)
QUICK = Size("quick", 3, 5, 4, 1500, 13, 2000, 5, 3, 60, 3000, 60)


class Study:
    """The maps of a study, each kept in a folder.

    Parameters
    ----------
    size : Size
    folder : Path
        In which each map has a store of its own; what is finished there is not done again.
    processes : int
        As in `parameter_map`.
    show : callable
        Told the name of each map as it begins.
    """

    def __init__(
        self, size: Size, folder: Path, processes: int, show: Callable[[str], object] = lambda _: None
    ) -> None:
        self.size, self._folder, self._processes, self._show = size, folder / size.name, processes, show

    def map(self, name: str, x: Any, y: Any = None, **asked: Any) -> xr.Dataset:
        """A map of that name, made or gone on with."""
        self._show(f"{name} ...")
        return parameter_map(
            x,
            y,
            store=self._folder / f"{name.replace(' ', '_')}.zarr",
            processes=self._processes,
            **{"seeds": self.size.seeds, "holds": self.size.holds, "inputs": "bits", **asked},
        )
