"""Figures of a benchmark: all scores, memory profiles, information by degree, predictions, and sweeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...common.extras import optional_import
from ...reservoir import Estimate
from ...tasks.task import Task
from .records import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_information", "plot_predictions", "plot_profiles", "plot_scores", "plot_sweep"]

_UNITS = {
    "capacity": "capacity (functions of the input)",
    "NRMSE": "NRMSE (of the target's standard deviation)",
    "accuracy": "accuracy (share of samples)",
    "valid time": "valid prediction time (Lyapunov times)",
    "rank": "rank (dimensions)",
    "index": "echo index (trajectories)",
}
_DRAWN_TOGETHER = ("crawler", "delay line", "echo-state network")
_ALPHA = 0.2


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

    from ...common.figures import house_style

    titles = list(dict.fromkeys(task for task, _ in found))
    styles = _styles(list(dict.fromkeys(reservoir for _, reservoir in found)), without=against)
    kinds = list(dict.fromkeys(tasks[title].metric.name for title in titles))
    of_kind = {kind: [title for title in titles if tasks[title].metric.name == kind] for kind in kinds}
    with house_style():
        figure, axes = plt.subplots(
            len(kinds),
            squeeze=False,
            figsize=(7.5, 0.8 + 0.55 * len(kinds) + 0.42 * len(titles)),
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
            ax.set_yticks(range(len(rows)), [f"{title} {_arrow(tasks[title])}" for title in rows])
            ax.set_ylim(len(rows) - 0.5, -0.5)
            ax.tick_params(axis="y", length=0)
            difference = "" if against is None else f"difference from the {against}: "
            ax.set_xlabel(difference + _UNITS.get(kind, kind))
        figure.align_ylabels()
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=min(4, len(styles)))
    return figure


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

    from ...common.figures import house_style

    titles, styles = _order(records)
    with house_style():
        figure, axes = plt.subplots(
            1, len(titles), sharey=True, squeeze=False, figsize=(1.0 + 2.9 * len(titles), 3.4), layout="constrained"
        )
        for ax, title in zip(axes[0], titles, strict=True):
            last = 4
            for reservoir, (color, marker) in styles.items():
                of_seeds = np.array(
                    [r.details["profile"] for r in records if (r.task, r.reservoir) == (title, reservoir)]
                )
                mean, low, high = _band(of_seeds, most=1.0)
                ax.fill_between(np.arange(len(mean)), low, high, color=color, alpha=_ALPHA, lw=0)
                ax.plot(mean, marker, ls="-", lw=1, ms=3.5, color=color, label=reservoir)
                last = max([last, *np.flatnonzero(mean > 0.02).tolist()])
            ax.set(xlabel="delay (samples)", xlim=(-0.5, last + 1.5), ylim=(-0.02, 1.05))
            ax.set_title(title, loc="left", fontsize=9)
            ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes[0, 0].set_ylabel("capacity at this delay")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(4, len(styles)) if len(titles) < 3 else 7)
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

    from ...common.figures import house_style, OKABE_ITO

    _, styles = _order(records)
    own = {reservoir: [record for record in records if record.reservoir == reservoir] for reservoir in styles}
    degrees = sorted({degree for record in records for degree in record.details["by degree"]}, key=int)
    with house_style():
        figure, ax = plt.subplots(figsize=(6.5, 0.9 + 0.42 * len(own)), layout="constrained")
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
        bands = [_band(np.array([[r.score] for r in each])) for each in own.values()]
        spread = np.nan_to_num([[mean[0] - low[0], high[0] - mean[0]] for mean, low, high in bands]).T
        ax.errorbar(total, place, xerr=spread, fmt="none", ecolor="black", capsize=2, lw=1)
        rank = [np.mean([r.details["rank"] for r in each]) for each in own.values()]
        ax.vlines(rank, place - 0.38, place + 0.38, color="black", lw=1.5, label="rank of the states")
        ax.set_yticks(place, list(own))
        ax.set_xlim(0.0, 1.04 * max([*rank, *total, 1.0]))
        ax.invert_yaxis()
        ax.set_xlabel(_UNITS["capacity"])
        figure.legend(loc="outside upper center", ncols=4)
    return figure


def plot_predictions(records: Sequence[Record], samples: int = 80) -> Figure:
    """Predictions against their target, a panel a task, on the first held-out samples of one seed.

    Parameters
    ----------
    records : sequence of Record
        With predictions; of the reservoirs at most three are drawn, crawler, delay line and echo-state network first.
    samples : int

    Returns
    -------
    matplotlib.figure.Figure
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ...common.figures import house_style

    titles, styles = _order(records)
    preferred = [name for name in _DRAWN_TOGETHER if name in styles]
    drawn = [*preferred, *(name for name in styles if name not in preferred)][:3]
    columns = min(2, len(titles))
    rows = -(-len(titles) // columns)
    with house_style():
        figure, axes = plt.subplots(
            rows, columns, squeeze=False, figsize=(4.6 * columns, 0.6 + 1.5 * rows), layout="constrained"
        )
        for ax, title in zip(axes.flat, titles, strict=False):
            mine = [record for record in records if record.task == title]
            first = min(record.seed for record in mine)
            of_first = {record.reservoir: record for record in mine if record.seed == first}
            target = next(iter(of_first.values())).details["target"][:samples]
            ax.plot(target, color="0.8", lw=3.0, label="target")
            for reservoir in drawn:
                record = of_first[reservoir]
                ax.plot(record.details["prediction"][:samples], lw=0.9, color=styles[reservoir][0], label=reservoir)
            errors = ", ".join(f"{of_first[name].score:.2f}" for name in drawn)
            ax.set_title(f"{title}: {errors}", loc="left", fontsize=8.5)
            ax.margins(x=0.01)
        for ax in axes.flat[len(titles) :]:
            ax.set_axis_off()
        for ax in axes[-1]:
            ax.set_xlabel("held-out sample")
        figure.supylabel("target's own unit", fontsize=9)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        order = "a title gives the scores in this order"
        figure.legend(handles, labels, loc="outside upper center", ncols=4, title=order, title_fontsize=8)
    return figure


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

    from ...common.figures import house_style, OKABE_ITO

    columns = min(3, len(found))
    rows = -(-len(found) // columns)
    with house_style():
        figure, axes = plt.subplots(
            rows, columns, squeeze=False, figsize=(0.5 + 2.9 * columns, 0.3 + 2.4 * rows), layout="constrained"
        )
        for ax, (title, each) in zip(axes.flat, found.items(), strict=False):
            metric = tasks[title].metric
            spread = np.nan_to_num([[one.mean - one.low, one.high - one.mean] for one in each]).T
            ax.errorbar(values, [one.mean for one in each], yerr=spread, fmt="o-", ms=4, color=OKABE_ITO[0], capsize=2)
            ax.axhline(metric.chance, color="0.5", lw=0.8, ls="--", zorder=0)
            if min(values) > 0 and max(values) > 4 * min(values):
                _log_axis(ax, values)
            ax.set(xlabel=_SWEPT_LABELS.get(name, name.replace("_", " ")), ylabel=metric.name)
            ax.set_title(f"{title} {_arrow(tasks[title])}", loc="left", fontsize=9)
        for ax in axes.flat[len(found) :]:
            ax.set_axis_off()
    return figure


_SWEPT_LABELS = {
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


def _log_axis(ax: Axes, values: Sequence[float]) -> None:
    """A logarithmic axis that is labelled at the values."""
    with optional_import():
        from matplotlib.ticker import NullLocator

    ax.set_xscale("log")
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticks(list(values), [f"{value:g}" for value in values])


def _order(records: Sequence[Record]) -> tuple[list[str], dict[str, tuple[str, str]]]:
    """Tasks, and reservoirs with their styles, in order of first appearance."""
    titles = list(dict.fromkeys(record.task for record in records))
    return titles, _styles(list(dict.fromkeys(record.reservoir for record in records)))


def _styles(reservoirs: Sequence[str], without: str | None = None) -> dict[str, tuple[str, str]]:
    """Colour and marker of each reservoir; the eighth colour and those after it come again with another marker.

    One that is left out, and so has no place among the others, takes the first.
    """
    from ...common.figures import MARKERS, OKABE_ITO

    # Yellow is hardly seen on white, and a star is small.
    colors = [*OKABE_ITO[:6], OKABE_ITO[7]]
    markers = MARKERS.replace("*", "")
    first = 0 if without is None else 1
    return {
        name: (colors[index % len(colors)], markers[(index + index // len(colors)) % len(markers)])
        for index, name in enumerate(reservoirs, start=first)
    }


def _band(of_seeds: np.ndarray, most: float = np.inf) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean and ends of the 95% interval of capacities over the first axis; of a single seed the mean itself."""
    from ...reservoir import mean_over_runs

    if len(of_seeds) == 1:
        return of_seeds[0], of_seeds[0], of_seeds[0]
    each = [mean_over_runs(values, bounds=(0.0, most)) for values in of_seeds.T]
    mean, low, high = (np.array([getattr(one, end) for one in each]) for end in ("mean", "low", "high"))
    return mean, low, high


def _arrow(task: Task) -> str:
    return "↑" if task.metric.more_is_better else "↓"
