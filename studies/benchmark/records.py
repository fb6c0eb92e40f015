"""What one attempt at a task came to, and a folder of such records, kept one by one so that a crash loses nothing."""

import json
import re
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ...common.kept import Kept
from ...tasks.task import Solution

__all__ = ["SHOWN", "Record", "Records"]

_GROWING = ("tasks", "reservoirs")

SHOWN = 120
"""Held-out samples of each prediction that are kept for figures."""


class Record(NamedTuple):
    """What one reservoir made of one task with one seed.

    Attributes
    ----------
    task, reservoir : str
        Their names.
    seed : int
    score : float
    details : dict
        What else was measured, ready for JSON: of memory the profile, its cutoffs and bound; of a series the first
        held-out samples of prediction and target.
    """

    task: str
    reservoir: str
    seed: int
    score: float
    details: dict[str, Any]

    @classmethod
    def of(cls, task: str, reservoir: str, seed: int, solution: Solution) -> Self:
        """What is kept of a solution."""
        details = dict(solution.details or {})
        if solution.memory is not None:
            memory = solution.memory
            details |= {
                "profile": memory.profile.tolist(),
                "cutoff": np.asarray(memory.cutoff).tolist(),
                "bound": memory.bound,
            }
        if solution.prediction is not None and solution.target is not None:
            details["prediction"] = solution.prediction[:SHOWN].tolist()
            details["target"] = solution.target[:SHOWN].tolist()
        return cls(task, reservoir, seed, solution.score, details)


class Records:
    """A folder of records, one file each, beside the settings that they were made with.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    settings : mapping
        What must be equal for records to belong together, as in `stickslip.common.fingerprint`. Under "tasks" and
        "reservoirs" names may be added, and what they name must be equal where the folder has it already.
    resume : bool
        Whether to go on from what the folder holds.

    Raises
    ------
    ValueError
        If the folder holds records and is not to be resumed, or they were made with other settings.
    """

    def __init__(self, folder: Path, settings: Mapping[str, Any], *, resume: bool = False) -> None:
        self._kept = Kept(folder, settings, resume=resume, growing=_GROWING)

    def keep(self, record: Record) -> None:
        """Write a record, whole or not at all."""
        self._kept.keep(_file_name(record), record._asdict())

    def load(self) -> dict[tuple[str, str, int], Record]:
        """All records in the folder, by task, reservoir and seed."""
        records = [Record(**each) for each in self._kept.load().values()]
        return {(record.task, record.reservoir, record.seed): record for record in records}


def _file_name(record: Record) -> str:
    # Names are anyone's choice; the digest tells apart what the readable part does not.
    readable = re.sub(r"[^A-Za-z0-9]+", "-", f"{record.task} {record.reservoir}").strip("-").lower()
    digest = sha256(json.dumps([record.task, record.reservoir]).encode()).hexdigest()[:8]
    return f"{readable[:80]}-{digest}-{record.seed}"
