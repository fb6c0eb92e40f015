"""The figure of all scores, or of their differences from one reservoir's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ....common.extras import optional_import
from ....reservoir import Estimate
from ....tasks.task import Task
from .style import arrow, styles_of, UNITS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_scores"]


def plot_scores(
    found: Mapping[tuple[str, str], Estimate], tasks: Mapping[str, Task], *, against: str | None = None
) -> Figure:
    """All tasks on all reservoirs: a panel a kind of score, a row a task, a marker a reservoir.

    Parameters
    ----------
    found : mapping of (task, reservoir) to Estimate
    tasks : mapping of str to Task
    against : str, optional
        The reservoir from which `found` are the differences.

    Returns
    -------
    matplotlib.figure.Figure
        Bars are 95% intervals; the dashed line is what a reservoir scores that knows nothing, or no difference.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ....common.figures import house_style, PAGE_WIDTH

    titles = list(dict.fromkeys(task for task, _ in found))
    styles = styles_of(list(dict.fromkeys(reservoir for _, reservoir in found)), without=against)
    kinds = list(dict.fromkeys(tasks[title].metric.name for title in titles))
    of_kind = {kind: [title for title in titles if tasks[title].metric.name == kind] for kind in kinds}
    with house_style():
        figure, axes = plt.subplots(
            len(kinds),
            squeeze=False,
            figsize=(PAGE_WIDTH, 0.9 + 0.6 * len(kinds) + 0.4 * len(titles)),
            height_ratios=[len(of_kind[kind]) + 0.3 for kind in kinds],
            layout="constrained",
        )
        for ax, kind in zip(axes[:, 0], kinds, strict=True):
            rows = of_kind[kind]
            for place, (reservoir, (color, marker)) in enumerate(styles.items()):
                offset = 0.62 * ((place + 0.5) / len(styles) - 0.5)
                each = [found[title, reservoir] for title in rows]
                ax.errorbar(
                    [one.mean for one in each],
                    np.arange(len(rows)) + offset,
                    xerr=np.nan_to_num([[one.mean - one.low, one.high - one.mean] for one in each]).T,
                    fmt=marker,
                    ms=4,
                    mec="white",
                    mew=0.3,
                    lw=1,
                    color=color,
                    label=reservoir,
                )
            for row, title in enumerate(rows):
                ax.vlines(
                    tasks[title].metric.chance if against is None else 0.0,
                    row - 0.45,
                    row + 0.45,
                    color="0.5",
                    lw=0.8,
                    ls="--",
                    zorder=0,
                )
                if row % 2 == 1:
                    ax.axhspan(row - 0.5, row + 0.5, color="0.95", lw=0, zorder=-1)
            ax.set_yticks(range(len(rows)), [f"{title} {arrow(tasks[title])}" for title in rows])
            ax.set_ylim(len(rows) - 0.5, -0.5)
            ax.tick_params(axis="y", length=0)
            difference = "" if against is None else f"difference from the {against}: "
            ax.set_xlabel(difference + UNITS.get(kind, kind))
        figure.align_ylabels()
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=min(3, len(styles)))
    return figure
