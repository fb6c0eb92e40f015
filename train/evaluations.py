"""The table of a run's periodic evaluations."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from ..common.files import write_text

__all__ = ["Evaluation", "best_of", "read_evaluations", "write_evaluations"]

_COLUMNS = ("steps", "mean_reward_per_step", "mean_speed", "mean_memory")


class Evaluation(NamedTuple):
    """What a policy came to, as means over the steps of its episodes.

    `speed` (z_c / t_c) and `memory` are the two terms of the reward, each before its weight; NaN where the environments
    did not tell them at every step, or the table was written before it had them.
    """

    steps: int  # of the training so far
    reward: float
    speed: float
    memory: float


def read_evaluations(file: Path) -> list[Evaluation]:
    """Rows of a table, in the order in which they were written.

    Parameters
    ----------
    file : Path
        A run's ``evaluations.csv``.

    Returns
    -------
    list of Evaluation

    Raises
    ------
    ValueError
        If it is not such a table.
    OSError
        If it cannot be read.
    """
    with file.open(encoding="utf-8", newline="") as text:
        rows = list(csv.DictReader(text, restval="nan"))
    try:
        return [
            Evaluation(int(row["steps"]), *(float(row.get(column, "nan")) for column in _COLUMNS[1:])) for row in rows
        ]
    except (KeyError, TypeError, ValueError):
        raise ValueError(f"evaluations must be a table of {', '.join(_COLUMNS)}, got {file}") from None


def write_evaluations(file: Path, evaluations: Sequence[Evaluation]) -> None:
    """Write a table, whole or not at all.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    rows = (",".join([str(each.steps), *(repr(value) for value in each[1:])]) for each in evaluations)
    text = "\n".join([",".join(_COLUMNS), *rows]) + "\n"
    write_text(file, text)


def best_of(evaluations: Sequence[Evaluation]) -> Evaluation:
    """The evaluation with most reward, the first of equals; `evaluations` must not be empty."""
    return max(evaluations, key=lambda each: each.reward)
