"""Cells done wherever there is room, and kept as they are finished: what was finished once is never done again."""

import json
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, TYPE_CHECKING

from ...common.jobs import as_done
from ...common.kept import Kept
from ...train.policies import Policy, read_policy, write_policy
from .cells import finish, Job, Outcome
from .plan import Cell, CONDITIONED, Trade

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["Finished", "TradeFolder"]

_CELLS, _POLICIES = "cells", "policies"


class Finished(NamedTuple):
    """How far a trade has come."""

    done: int
    of: int
    cell: Cell | None
    """What was finished last, in this run."""


class TradeFolder:
    """A trade in a folder: ``cells/`` with a JSON file for each that is finished, and ``policies/``.

    Parameters
    ----------
    folder : Path
        Made if it is missing. What it holds already is gone on with; weights, dithers and seeds may be added.
    trade : Trade

    Raises
    ------
    ValueError
        If the folder holds cells of a trade with other settings.
    """

    def __init__(self, folder: Path, trade: Trade) -> None:
        self.folder = folder
        self.trade = trade
        begun = any((folder / _CELLS).glob("[!.]*-*.json"))
        self._kept = Kept(folder / _CELLS, {**trade.settings, "probe": trade.probe()}, resume=begun)
        (folder / _POLICIES).mkdir(exist_ok=True)

    def policy(self, cell: Cell) -> Policy:
        """The policy of a finished training.

        Raises
        ------
        ValueError
            If its files are missing or damaged.
        """
        return read_policy(self.folder / _POLICIES / cell.name)

    def results(self) -> dict[Cell, Any]:
        """What is finished of what is asked for.

        Raises
        ------
        ValueError
            If a file was made with other settings, as one copied from another folder.
        """
        kept = self._kept.load()
        found = {}
        for cell in (cell for stage in self.trade.cells() for cell in stage):
            if cell.name in kept:
                if kept[cell.name].get("fingerprint") != self._fingerprint(cell):
                    raise ValueError(
                        f"{self.folder / _CELLS / cell.name}.json must be of this trade, it is of other settings"
                    )
                found[cell] = kept[cell.name]["result"]
        return found

    def run(self, *, processes: int = 1, dask: "str | Client | None" = None) -> Iterator[Finished]:
        """Do what is not finished yet.

        Parameters
        ----------
        processes, dask
            Who does it: see `stickslip.common.jobs.as_done`.

        Yields
        ------
        Finished
            At first what was done before, then each cell once it is kept.
        """
        stages = self.trade.cells()
        total = sum(map(len, stages))
        finished = self.results()
        done = len(finished)
        yield Finished(done, total, None)
        for stage in stages:
            left = [cell for cell in stage if cell not in finished]
            jobs = [Job(self.trade, cell, tuple(map(self.policy, self._needed(cell)))) for cell in left]
            for index, outcome in as_done(finish, jobs, processes=processes, dask=dask):
                self._keep(left[index], outcome)
                done += 1
                yield Finished(done, total, left[index])

    def _needed(self, cell: Cell) -> list[Cell]:
        """Cells whose policies a cell works on."""
        if cell.kind == CONDITIONED:
            return self.trade.teachers(cell.dither)
        return [] if cell.judges is None else [cell.judges]

    def _keep(self, cell: Cell, outcome: Outcome) -> None:
        # The policy first: what has a result is finished.
        if outcome.policy is not None:
            write_policy(outcome.policy, self.folder / _POLICIES / cell.name)
        self._kept.keep(
            cell.name,
            {"cell": cell._asdict(), "fingerprint": self._fingerprint(cell), "result": outcome.result},
        )

    def _fingerprint(self, cell: Cell) -> str:
        made_for = {"settings": self.trade.settings, "cell": cell._asdict()}
        return sha256(json.dumps(made_for, sort_keys=True).encode()).hexdigest()
