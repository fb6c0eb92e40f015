"""The figure of scores against a number that is swept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....common.extras import optional_import
from ....reservoir import Estimate
from ....tasks.task import Task
from .style import arrow

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["SWEPT_LABELS", "plot_sweep"]

SWEPT_LABELS = {
    "hold": "hold ($t_c$)",
    "amplitude": "peak pressure (relative)",
    "duffing": r"duffing $\Pi_1$",
    "damping_ratio": r"damping ratio $\Pi_2$",
    "deborah": r"Deborah number $\Pi_4$",
    "radial_coupling": r"radial coupling $\Pi_5$",
    "foot_mass_fraction": "foot mass fraction $r$",
    "static_friction": "static friction $s$",
    "kinetic_friction": "kinetic friction $k$",
    "slope": "slope (weight along the ground)",
}
"""Names and units of what can be swept, for an axis."""

_NARROW = 5  # values whose names there is room for in a third of a page


def plot_sweep(
    name: str, values: Sequence[float], found: Mapping[str, Sequence[Estimate]], tasks: Mapping[str, Task]
) -> Figure:
    """Scores of the crawler against a number that is swept, a panel a task, with 95% intervals.

    Parameters
    ----------
    name : str
        What is swept, one of `SWEPT`.
    values : sequence of float
        In ascending order.
    found : mapping of str to sequence of Estimate
        By task, one for each value.
    tasks : mapping of str to Task

    Returns
    -------
    matplotlib.figure.Figure
        The dashed line is what a reservoir scores that knows nothing.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ....common.figures import house_style, OKABE_ITO, PAGE_WIDTH, SMALL

    columns = min(3 if len(values) <= _NARROW else 2, len(found))
    rows = -(-len(found) // columns)
    with house_style():
        figure, axes = plt.subplots(
            rows,
            columns,
            squeeze=False,
            figsize=(PAGE_WIDTH if columns > 1 else 0.6 * PAGE_WIDTH, 0.3 + 2.0 * rows),
            layout="constrained",
        )
        for ax, (title, each) in zip(axes.flat, found.items(), strict=False):
            metric = tasks[title].metric
            spread = np.nan_to_num([[one.mean - one.low, one.high - one.mean] for one in each]).T
            ax.errorbar(values, [one.mean for one in each], yerr=spread, fmt="o-", ms=4, color=OKABE_ITO[0], capsize=2)
            ax.axhline(metric.chance, color="0.5", lw=0.8, ls="--", zorder=0)
            if min(values) > 0 and max(values) > 4 * min(values):
                _log_axis(ax, values)
            ax.set(xlabel=SWEPT_LABELS.get(name, name.replace("_", " ")), ylabel=metric.name)
            ax.set_title(f"{title} {arrow(tasks[title])}", loc="left", fontsize=SMALL)
        for ax in axes.flat[len(found) :]:
            ax.set_axis_off()
    return figure


def _log_axis(ax: Axes, values: Sequence[float]) -> None:
    """A logarithmic axis that is labelled at the values."""
    with optional_import():
        from matplotlib.ticker import NullLocator

    ax.set_xscale("log")
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticks(list(values), [f"{value:g}" for value in values])
