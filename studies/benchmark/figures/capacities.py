"""Figures of what states hold: capacity by delay, and information by degree."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....common.extras import optional_import
from ..records import Record
from .style import band_of, order_of, UNITS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_information", "plot_profiles"]

_ALPHA = 0.2
_COLUMNS = 3


def plot_profiles(records: Sequence[Record]) -> Figure:
    """Capacity against delay, a panel a task, a curve a reservoir with its 95% interval over seeds.

    Parameters
    ----------
    records : sequence of Record
        With profiles.

    Returns
    -------
    matplotlib.figure.Figure
        Curves end where all reservoirs have forgotten.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt
        from matplotlib.ticker import MaxNLocator

    from ....common.figures import house_style, PAGE_WIDTH

    titles, styles = order_of(records)
    columns = min(_COLUMNS, len(titles))
    rows = -(-len(titles) // columns)
    with house_style():
        figure, axes = plt.subplots(
            rows, columns, sharey=True, squeeze=False, figsize=(PAGE_WIDTH, 0.8 + 2.2 * rows), layout="constrained"
        )
        for ax, title in zip(axes.flat, titles, strict=False):
            last = 4
            for reservoir, (color, marker) in styles.items():
                of_seeds = np.array(
                    [r.details["profile"] for r in records if (r.task, r.reservoir) == (title, reservoir)]
                )
                mean, low, high = band_of(of_seeds, most=1.0)
                ax.fill_between(np.arange(len(mean)), low, high, color=color, alpha=_ALPHA, lw=0)
                ax.plot(mean, marker, ls="-", lw=1, ms=3.5, color=color, label=reservoir)
                last = max([last, *np.flatnonzero(mean > 0.02).tolist()])
            ax.set(xlabel="delay (samples)", xlim=(-0.5, last + 1.5), ylim=(-0.02, 1.05))
            ax.set_title(title, loc="left")
            ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        for ax in axes.flat[len(titles) :]:
            ax.set_axis_off()
        for ax in axes[:, 0]:
            ax.set_ylabel("capacity at this delay")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(4, len(styles)))
    return figure


def plot_information(records: Sequence[Record]) -> Figure:
    """Information processing capacity by degree, stacked to the total, beside the rank that bounds it.

    Parameters
    ----------
    records : sequence of Record
        With capacities by degree.

    Returns
    -------
    matplotlib.figure.Figure
        Means over seeds; the bar at the end of a stack is the total's 95% interval.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ....common.figures import house_style, OKABE_ITO, PAGE_WIDTH

    _, styles = order_of(records)
    own = {reservoir: [record for record in records if record.reservoir == reservoir] for reservoir in styles}
    degrees = sorted({degree for record in records for degree in record.details["by degree"]}, key=int)
    with house_style():
        figure, ax = plt.subplots(figsize=(PAGE_WIDTH, 1.1 + 0.42 * len(own)), layout="constrained")
        place = np.arange(len(own))
        total = np.zeros(len(own))
        hatches = ("", "///", "...", "xxx")
        for index, degree in enumerate(degrees):
            share = [np.mean([r.details["by degree"].get(degree, 0.0) for r in each]) for each in own.values()]
            label = f"degree {degree}" + (" (memory)" if degree == "1" else "")
            ax.barh(
                place, share, 0.6, left=total, color=OKABE_ITO[index], label=label, ec="white", hatch=hatches[index % 4]
            )
            total += share
        bands = [band_of(np.array([[r.score] for r in each])) for each in own.values()]
        spread = np.nan_to_num([[mean[0] - low[0], high[0] - mean[0]] for mean, low, high in bands]).T
        ax.errorbar(total, place, xerr=spread, fmt="none", ecolor="black", capsize=2, lw=1)
        rank = [np.mean([r.details["rank"] for r in each]) for each in own.values()]
        ax.vlines(rank, place - 0.38, place + 0.38, color="black", lw=1.5, label="rank of the states")
        ax.set_yticks(place, list(own))
        ax.set_xlim(0.0, 1.04 * max([*rank, *total, 1.0]))
        ax.invert_yaxis()
        ax.set_xlabel(UNITS["capacity"])
        figure.legend(loc="outside upper center", ncols=3)
    return figure
