"""What the figures of a benchmark share: units, the look of each reservoir, the order, and intervals over seeds."""

from collections.abc import Sequence

import numpy as np

from ....tasks.task import Task
from ..records import Record

__all__ = ["UNITS", "arrow", "band_of", "order_of", "styles_of"]

UNITS = {
    "capacity": "capacity (functions of the input)",
    "NRMSE": "NRMSE (of the target's standard deviation)",
    "accuracy": "accuracy (share of samples)",
    "valid time": "valid prediction time (Lyapunov times)",
    "rank": "rank (dimensions)",
    "index": "echo index (trajectories)",
}
"""By the name of a metric, what its axis says."""


def order_of(records: Sequence[Record]) -> tuple[list[str], dict[str, tuple[str, str]]]:
    """Tasks, and reservoirs with their styles, in order of first appearance."""
    titles = list(dict.fromkeys(record.task for record in records))
    return titles, styles_of(list(dict.fromkeys(record.reservoir for record in records)))


def styles_of(reservoirs: Sequence[str], without: str | None = None) -> dict[str, tuple[str, str]]:
    """Colour and marker of each reservoir; the eighth colour and those after it come again with another marker.

    One that is left out, and so has no place among the others, takes the first.
    """
    from ....common.figures import MARKERS, OKABE_ITO

    # Yellow is hardly seen on white, and a star is small.
    colors = [*OKABE_ITO[:6], OKABE_ITO[7]]
    markers = MARKERS.replace("*", "")
    first = 0 if without is None else 1
    return {
        name: (colors[index % len(colors)], markers[(index + index // len(colors)) % len(markers)])
        for index, name in enumerate(reservoirs, start=first)
    }


def band_of(of_seeds: np.ndarray, most: float = np.inf) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean and ends of the 95% interval of capacities over the first axis; of a single seed the mean itself."""
    from ....reservoir import mean_over_runs

    if len(of_seeds) == 1:
        return of_seeds[0], of_seeds[0], of_seeds[0]
    each = [mean_over_runs(values, bounds=(0.0, most)) for values in of_seeds.T]
    mean, low, high = (np.array([getattr(one, end) for one in each]) for end in ("mean", "low", "high"))
    return mean, low, high


def arrow(task: Task) -> str:
    """Which way the scores of a task are better."""
    return "↑" if task.metric.more_is_better else "↓"
