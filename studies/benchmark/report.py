"""What records come to: means and paired differences with intervals over seeds, as tables and as JSON."""

import math
import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from typing import Any

from ...common.validation import known_names
from ...reservoir import Estimate, mean_over_runs
from ...tasks.catalogue import TASKS
from ...tasks.measures import MEASURES
from ...tasks.reservoirs import Reservoir
from ...tasks.task import mean_score, Task
from .records import Record

__all__ = [
    "KNOWN",
    "as_json",
    "as_markdown",
    "as_rows",
    "cell",
    "estimates",
    "paired_differences",
    "table",
    "versions",
]

KNOWN: Mapping[str, Task] = {**TASKS, **MEASURES}
"""All that a benchmark can run by name."""


_LIBRARIES = ("stickslip", "numpy", "scipy", "numba", "scikit-learn")
_NONE: Mapping[str, Any] = {}
_DIGITS = {"NRMSE": 3, "accuracy": 3}


def estimates(
    records: Iterable[Record],
    tasks: Mapping[str, Task] = _NONE,
    reservoirs: Mapping[str, Reservoir] = _NONE,
    *,
    bounds: tuple[float, float] | None = None,
) -> dict[tuple[str, str], Estimate]:
    """Average scores over seeds.

    Parameters
    ----------
    records : iterable of Record
    tasks : mapping of str to Task, optional
        By name. The mean of a task that is among them has the bounds of `mean_score`.
    reservoirs : mapping of str to Reservoir, optional
        By name; no capacity and no rank of one that is among them is more than its features.
    bounds : tuple of two floats, optional
        As in `mean_over_runs`, for the mean of a task that is not among `tasks`.

    Returns
    -------
    dict of (task, reservoir) to Estimate
        Means with their 95% intervals, in order of first appearance. Of a single seed, and of seeds that all score the
        same, the ends of the interval are not numbers.
    """
    values: dict[tuple[str, str], list[float]] = {}
    for record in records:
        values.setdefault((record.task, record.reservoir), []).append(record.score)

    def estimate(task: str, reservoir: str, scores: list[float]) -> Estimate:
        if len(scores) == 1:
            return Estimate(scores[0], math.nan, math.nan, 1)
        if task not in tasks:
            return mean_over_runs(scores, bounds=bounds)
        return mean_score(tasks[task], scores, getattr(reservoirs.get(reservoir), "features", None))

    return {key: estimate(*key, scores) for key, scores in values.items()}


def paired_differences(records: Iterable[Record], reference: str) -> dict[tuple[str, str], Estimate]:
    """Mean difference of each reservoir's score from that of a reference on the same draws, with its 95% interval.

    What makes one draw harder than another for both drops out, so that a difference is known better than either score.

    Parameters
    ----------
    records : iterable of Record
        With the reference's on every task and seed.
    reference : str
        A reservoir's name.

    Returns
    -------
    dict of (task, reservoir) to Estimate
        Of the other reservoirs, in order of first appearance.

    Raises
    ------
    ValueError
        If there is no record of the reference.
    """
    records = list(records)
    known_names("against", [reference], dict.fromkeys(record.reservoir for record in records))
    base = {(record.task, record.seed): record.score for record in records if record.reservoir == reference}
    return estimates(
        (
            record._replace(score=record.score - base[record.task, record.seed])
            for record in records
            if record.reservoir != reference
        ),
        bounds=(-math.inf, math.inf),
    )


def as_rows(
    found: Mapping[tuple[str, str], Estimate], tasks: Mapping[str, Task], *, signed: bool = False
) -> list[list[str]]:
    """Lay estimates out as text, a row a task and a column a reservoir, under a row of headings.

    Parameters
    ----------
    found : mapping of (task, reservoir) to Estimate
        Every task on every reservoir.
    tasks : mapping of str to Task
        Which way is better, told by an arrow where a task is among them.
    signed : bool
        Whether a number that is positive has a plus, as a difference has.

    Returns
    -------
    list of list of str
        Cells read "mean [low, high]", or "mean" where no interval is known.
    """
    reservoirs = list(dict.fromkeys(reservoir for _, reservoir in found))
    rows = []
    for task in dict.fromkeys(task for task, _ in found):
        metric = tasks[task].metric if task in tasks else None
        digits = _DIGITS.get(metric.name, 2) if metric else 2
        arrow = "" if metric is None else " ↑" if metric.more_is_better else " ↓"
        cells = [cell(found[task, reservoir], digits, "+" if signed else "") for reservoir in reservoirs]
        rows.append([task + arrow, *cells])
    return [["task", *reservoirs], *rows]


def table(records: Iterable[Record], tasks: Mapping[str, Task] = KNOWN) -> list[list[str]]:
    """Lay scores out as text, a row a task and a column a reservoir, under a row of headings.

    Parameters
    ----------
    records : iterable of Record
        Every task on every reservoir, as from `run_benchmark`.
    tasks : mapping of str to Task
        By name, of your own too; the arrow of a task tells which way is better.

    Returns
    -------
    list of list of str
        Cells read "mean [low, high]" with the 95% interval of the mean over seeds, or "mean" where none is known.
    """
    return as_rows(estimates(records, tasks), tasks)


def as_markdown(rows: list[list[str]]) -> str:
    """A table for a page of Markdown."""
    under = ["---", *["---:"] * (len(rows[0]) - 1)]
    return "\n".join(f"| {' | '.join(row)} |" for row in [rows[0], under, *rows[1:]])


def as_json(
    records: Iterable[Record],
    found: Mapping[tuple[str, str], Estimate],
    paired: Mapping[tuple[str, str], Estimate],
    inputs: Mapping[str, Any],
) -> dict[str, Any]:
    """Inputs, versions, means, paired differences and every score, ready for JSON."""
    return {
        "inputs": dict(inputs),
        "versions": versions(),
        "interval": "95% of the mean over seeds",
        "means": _listed(found),
        "differences": _listed(paired),
        "scores": [
            {
                **{name: value for name, value in record._asdict().items() if name != "details"},
                **{name: value for name, value in record.details.items() if name not in ("prediction", "target")},
            }
            for record in records
        ],
    }


def _listed(found: Mapping[tuple[str, str], Estimate]) -> list[dict[str, Any]]:
    return [
        {
            "task": task,
            "reservoir": reservoir,
            "mean": each.mean,
            "interval": None if math.isnan(each.low) else [each.low, each.high],
            "seeds": each.runs,
        }
        for (task, reservoir), each in found.items()
    ]


def versions() -> dict[str, str]:
    """Of Python and of the libraries that the numbers come from."""
    return {"python": platform.python_version(), **{library: version(library) for library in _LIBRARIES}}


def cell(each: Estimate, digits: int = 2, sign: str = "") -> str:
    """An estimate as text: "mean [low, high]", or "mean" where no interval is known."""
    ends = "" if math.isnan(each.low) else f" [{each.low:{sign}.{digits}f}, {each.high:{sign}.{digits}f}]"
    return f"{each.mean:{sign}.{digits}f}{ends}"
