"""A map on disk or in memory, as Zarr has it, block by block: what is in it once is never done again."""

from __future__ import annotations

import json
import os
import shutil
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.extras import optional_import
from ...common.fingerprint import described, refuse_other
from .cells import UNFINISHED
from .plan import Block, Plan

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MapStore"]

_SETTINGS = "settings"
_STATUS = "status"
_MEANINGS = "unfinished finished no_such_body solver_gave_up"
_SYMBOLS = {
    "duffing": "Pi1",
    "damping_ratio": "Pi2",
    "deborah": "Pi4",
    "radial_coupling": "Pi5",
    "foot_mass_fraction": "r",
    "static_friction": "s",
    "kinetic_friction": "k",
}
_FORMAT: Any = 3


class MapStore:
    """A map's store, begun or gone on with.

    Parameters
    ----------
    folder : Path or None
        Made if it is missing, in one stroke; None keeps the map in memory.
    plan : Plan
    probe : mapping
        What the measures come to on a small body now.

    Raises
    ------
    ValueError
        If the folder holds something else, or a map of other settings.
    MissingExtra
        If xarray or Zarr is not installed.
    """

    def __init__(self, folder: Path | None, plan: Plan, probe: Mapping[str, Any]) -> None:
        with optional_import():
            import xarray as xr
            import zarr

        self._xarray, self._plan = xr, plan
        self.folder = folder
        settings = described({**plan.settings, "probe": dict(probe)})
        self._store: Any = zarr.storage.MemoryStore() if folder is None else str(folder)
        if folder is None:
            self._begin(self._store, settings)
        elif folder.exists():
            self._refuse_other(folder, settings)
        else:
            self._begin_whole(folder, settings)
        self._group: Any = zarr.open_group(self._store, mode="r+", zarr_format=_FORMAT)

    def unfinished(self) -> list[Block]:
        """Blocks that are not in it yet."""
        status = np.asarray(self._group[_STATUS][...])
        return [block for block in self._plan.blocks if status[self._place(block)].min() == UNFINISHED]

    @property
    def cells(self) -> int:
        """How many are in it."""
        return int(np.count_nonzero(np.asarray(self._group[_STATUS][...]) != UNFINISHED))

    def keep(self, block: Block, found: Mapping[str, NDArray[Any]]) -> None:
        """Write a block. It counts once its last piece, the status, is there."""
        for name in (*self._plan.variables, _STATUS):
            self._group[name][self._place(block)] = found[name]

    def dataset(self) -> xr.Dataset:
        """All that is in it, loaded."""
        with self._xarray.open_zarr(self._store, consolidated=False, zarr_format=_FORMAT) as found:
            return found[[*self._plan.variables, _STATUS]].load()

    def _place(self, block: Block) -> tuple[Any, ...]:
        columns = slice(block.first, block.last)
        return (block.row, columns) if len(self._plan.axes) == 2 else (columns,)

    def _refuse_other(self, folder: Path, settings: Any) -> None:
        try:
            kept = json.loads((folder / "zarr.json").read_text(encoding="utf-8"))["attributes"][_SETTINGS]
            found = json.loads(kept)
        except (OSError, KeyError, TypeError, ValueError):
            raise ValueError(f"store must be a map or not be there yet, got {folder} with something else") from None
        refuse_other(f"to go on with the map in {folder}", found, settings)

    def _begin_whole(self, folder: Path, settings: Any) -> None:
        folder.parent.mkdir(parents=True, exist_ok=True)
        unfinished = folder.with_name(f".{folder.name}-{os.getpid()}")
        try:
            self._begin(str(unfinished), settings)
            unfinished.replace(folder)
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)

    def _begin(self, store: Any, settings: Any) -> None:
        plan = self._plan
        axes = [axis.name for axis in plan.axes]
        of_block = [1] * (len(axes) - 1) + [plan.columns]
        data: dict[str, Any] = {}
        encoding: dict[str, Any] = {}
        for name, each in plan.variables.items():
            further = [each.along] if each.along else []
            lengths = [len(plan.seeds), *(len(plan.points[along]) for along in further)]
            attributes: dict[str, Any] = {"long_name": each.label, "units": each.unit}
            if each.least is not None:
                attributes["valid_min"] = each.least
            data[name] = ([*axes, "seed", *further], np.full((*plan.shape, *lengths), np.nan), attributes)
            encoding[name] = {"chunks": (*of_block, *lengths)}
        flags = {"flag_values": [*range(4)], "flag_meanings": _MEANINGS}
        data[_STATUS] = (axes, np.full(plan.shape, UNFINISHED, np.int8), {"long_name": "state of the cell", **flags})
        encoding[_STATUS] = {"chunks": tuple(of_block)}
        coordinates: dict[str, Any] = {
            axis.name: (axis.name, list(axis.values), _attributes(axis.name)) for axis in plan.axes
        }
        coordinates["seed"] = ("seed", list(plan.seeds), {"long_name": "seed of the input"})
        for along in {each.along for each in plan.variables.values() if each.along}:
            coordinates[along] = (along, list(plan.points[along]), {"units": "holds"} if along == "delay" else {})
        whole = self._xarray.Dataset(data, coordinates, {_SETTINGS: json.dumps(settings)})
        with warnings.catch_warnings():
            # What xarray looks for, and says so where it is missing, though the format does not have it yet.
            warnings.filterwarnings("ignore", message="Consolidated metadata is currently not part")
            whole.to_zarr(store, mode="w-", encoding=encoding, consolidated=True, zarr_format=_FORMAT)


def _attributes(name: str) -> dict[str, str]:
    units = {"hold": "t_c", "slope": "P_max A_0"}.get(name, "1")
    symbol = {"symbol": _SYMBOLS[name]} if name in _SYMBOLS else {}
    return {"long_name": name.replace("_", " "), "units": units, **symbol}
