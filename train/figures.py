"""Figures of policies and schedules."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from pathlib import Path
from typing import Any, cast, TYPE_CHECKING

import numpy as np

from ..common.extras import optional_import
from .evaluations import read_evaluations
from .schedules import pareto_front, Performance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_learning", "plot_trade"]

_DASHES: tuple[Any, ...] = "--", "-.", (0, (1, 1)), (0, (6, 2, 1, 2, 1, 2))  # of lines across


def plot_trade(
    schedules: Mapping[str, Performance], policies: Mapping[str, Performance], *, ax: Axes | None = None
) -> Figure:
    """Speed against memory capacity: open-loop schedules and their front, and policies.

    Parameters
    ----------
    schedules : mapping of str to Performance
        By their words; all measured with the same dither.
    policies : mapping of str to Performance
        By the names to show, with that dither too.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there is no schedule, or one was measured without dither.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ..common.figures import house_style, MARKERS, OKABE_ITO, PAGE_WIDTH, SMALL

    points = _points(schedules)
    with house_style():
        if ax is None:
            _, ax = plt.subplots(figsize=(PAGE_WIDTH, 4.2), layout="constrained")
        ax.plot(points[:, 0], points[:, 1], "o", ms=4, color="0.65", label="open-loop schedules")
        front = pareto_front(points)
        ax.plot(points[front, 0], points[front, 1], "-", lw=1, color="0.35", zorder=1, label="open-loop front")
        words = list(schedules)
        for index in front:
            ax.annotate(
                words[index], points[index], xytext=(5, 4), textcoords="offset points", fontsize=SMALL, color="0.35"
            )
        if len(policies) >= len(MARKERS):
            raise ValueError(f"policies must be at most {len(MARKERS) - 1}, got {len(policies)}")
        if policies:
            for (name, (x, y)), color, marker in zip(
                zip(policies, _points(policies), strict=True), OKABE_ITO, MARKERS[1:], strict=False
            ):
                ax.plot(x, y, marker, ms=9, color=color, mec="white", label=name)
        ax.set(xlabel="speed ($z_c / t_c$)", ylabel="memory capacity, corrected total")
        ax.set(xlim=(0, None), ylim=(0, 1.08 * points[:, 1].max()))
        ax.legend(loc="upper right")
    return cast("Figure", ax.get_figure(root=True))


def plot_learning(table: Path, *, baselines: Mapping[str, float] | None = None, ax: Axes | None = None) -> Figure:
    """Mean reward in the periodic evaluations of a run, and its two terms, against environment steps.

    Parameters
    ----------
    table : Path
        The run's ``evaluations.csv``.
    baselines : mapping of str to float, optional
        Reward per step of what needs no training, by name; each is a line across.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.figure.Figure
        Its axis begins at 0, so that noise looks as small as it is.
    """
    with optional_import():
        from matplotlib import pyplot as plt

    from ..common.figures import house_style, OKABE_ITO, PAGE_WIDTH

    evaluations = read_evaluations(table)
    steps = [each.steps for each in evaluations]
    lines = {} if baselines is None else dict(baselines)
    with house_style():
        if ax is None:
            _, ax = plt.subplots(figsize=(PAGE_WIDTH, 3.2), layout="constrained")
        rewards = [each.reward for each in evaluations]
        ax.plot(steps, rewards, "o-", ms=4, color=OKABE_ITO[0], label="reward")
        for name, style, color in (("speed", "--", OKABE_ITO[1]), ("memory", ":", OKABE_ITO[2])):
            values = [getattr(each, name) for each in evaluations]
            if not np.isnan(values).all():  # a table from before it had them
                ax.plot(steps, values, style, color=color, lw=1.3, label=f"its {name}")
        for (name, reward), dashes in zip(lines.items(), cycle(_DASHES), strict=False):
            ax.axhline(reward, color="0.3", lw=0.9, ls=dashes, zorder=0, label=f"reward of {name}: {reward:.3f}")
        low, high = ax.get_ylim()
        ax.set(xlabel="environment steps", ylabel="mean per step", ylim=(min(low, 0.0), max(high, 0.0)))
        ax.legend(loc="upper left", bbox_to_anchor=(0, -0.18), ncols=3)
    return cast("Figure", ax.get_figure(root=True))


def _points(performances: Mapping[str, Performance]) -> np.ndarray:
    if not performances:
        raise ValueError("schedules must hold at least one performance, got none")
    rows = []
    for name, (speed, memory) in performances.items():
        if memory is None:
            raise ValueError(f"{name} was measured without dither and has no memory capacity; all must have one")
        rows.append((speed, memory.corrected))
    return np.array(rows)
