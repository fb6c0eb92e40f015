"""The figure of work and precision."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...common.extras import optional_import
from ...crawler import Scene
from .case import DEFORMATION, FOOT, MEAN_SPEED, RMS_DEFORMATION, SLIP_RATE
from .measurement import Row, WorkPrecision
from .recommendation import Recommendation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_work_precision"]

_UNITS = {FOOT: "$z_c$", DEFORMATION: "$z_c$", MEAN_SPEED: "$z_c/t_c$", SLIP_RATE: "$1/t_c$", RMS_DEFORMATION: "$z_c$"}
_SOLVERS = ("taylor", "radau", "closed_form")
_LABEL_SIZE = (17.0, 7.0)  # points
_SYMBOLS = {
    "duffing": r"\Pi_1",
    "damping_ratio": r"\Pi_2",
    "deborah": r"\Pi_4",
    "radial_coupling": r"\Pi_5",
    "foot_mass_fraction": "r",
    "static_friction": "s",
    "kinetic_friction": "k",
}


def plot_work_precision(study: WorkPrecision, recommendation: Recommendation | None = None) -> Figure:
    """Error against time per unit, a panel a quantity, a line a solver, a marker a tolerance.

    Parameters
    ----------
    study : WorkPrecision
    recommendation : Recommendation, optional
        Also draw the error that is wanted, and a ring around what is recommended.

    Returns
    -------
    matplotlib.figure.Figure
        Markers are labelled with their tolerance where there is room; a cross on an open marker says that the slip
        count is wrong. Bars span the quartiles of time. The grey band is what cannot be told from the reference.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt
        from matplotlib.lines import Line2D

    from ...common.figures import house_style

    quantities = list(study.reference.floors)
    with house_style():
        figure, axes = plt.subplots(
            1,
            len(quantities),
            sharex=True,
            sharey=study.reference.comparable,
            squeeze=False,
            figsize=(0.8 + 3.0 * len(quantities), 4.3),
            layout="constrained",
        )
        for ax, quantity in zip(axes[0], quantities, strict=True):
            if study.reference.comparable:
                _draw_errors(ax, study, quantity, recommendation)
            else:
                _draw_differences(ax, study, quantity)
            if recommendation is not None and recommendation.row is not None:
                _ring(ax, recommendation.row, _height(study, recommendation.row, quantity))
            _dress(ax, study, quantity)
        axes[0, 0].set_ylabel("error" if study.reference.comparable else "difference of means over twins")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        if not all(row.slips_agree for row in study.rows):
            open_marker = Line2D([], [], ls="", marker="o", ms=7, color="0.4", mfc="white")
            handles.append((open_marker, Line2D([], [], ls="", marker="x", ms=5, color="0.4")))
            labels.append("wrong slip count")
        columns = {1: 2, 2: 3, 3: 5}
        figure.legend(handles, labels, loc="outside lower left", ncols=columns[len(quantities)], fontsize=8)
        figure.suptitle(_caption(study), fontsize=7.5, x=0.01, ha="left")
        figure.draw_without_rendering()
        for ax, quantity in zip(axes[0], quantities, strict=True):
            _label_tolerances(ax, study, quantity)
    return figure


def _draw_errors(ax: Axes, study: WorkPrecision, quantity: str, recommendation: Recommendation | None) -> None:
    """Errors of trajectories, over decades."""
    _draw_rows(ax, study, quantity)
    bottom = 0.2 * min(study.reference.floors.values())
    largest = [study.largest_error(row) for row in study.rows]
    ax.set_yscale("log")
    ax.set_ylim(bottom, 5.0 * max(largest if recommendation is None else [*largest, recommendation.wanted]))
    ax.axhspan(
        bottom, study.reference.floors[quantity], color="0.9", lw=0, zorder=0, label="below the reference's own error"
    )
    if recommendation is not None:
        ax.axhline(recommendation.wanted, ls="--", lw=0.8, color="0.4", zorder=1, label="error wanted")


def _draw_differences(ax: Axes, study: WorkPrecision, quantity: str) -> None:
    """Differences of statistics, beside what chance makes of them."""
    _draw_rows(ax, study, quantity)
    ax.set_ylim(bottom=-0.03 * ax.get_ylim()[1])
    ax.axhspan(0.0, study.reference.floors[quantity], color="0.9", lw=0, zorder=0, label="within chance")


def _draw_rows(ax: Axes, study: WorkPrecision, quantity: str) -> None:
    """A line a solver, a marker a tolerance."""
    ax.set_xscale("log")
    for solver, (color, marker) in _styles(study).items():
        rows = [row for row in study.rows if row.solver == solver]
        height = np.array([_height(study, row, quantity) for row in rows])
        low, time, high = np.array([row.timing for row in rows]).T
        ax.hlines(height, low, high, color=color, lw=3, alpha=0.25, zorder=2)
        ax.plot(time, height, marker + "-", lw=1, ms=5, color=color, mec="white", mew=0.5, zorder=3, label=solver)
        wrong = np.array([not row.slips_agree for row in rows])
        ax.plot(time[wrong], height[wrong], marker, ms=7, color=color, mfc="white", zorder=4)
        ax.plot(time[wrong], height[wrong], "x", ms=5, color=color, zorder=5)


def _label_tolerances(ax: Axes, study: WorkPrecision, quantity: str) -> None:
    """Write the tolerance beside every marker where there is room, in axes whose limits are settled."""
    with optional_import():
        from matplotlib.patheffects import withStroke

    taken: list[np.ndarray] = []
    for solver, (color, _) in _styles(study).items():
        for row in study.rows:
            if row.solver != solver or row.tolerance is None:
                continue
            place = row.timing.median, _height(study, row, quantity)
            spot = ax.transData.transform(place) * 72.0 / ax.figure.dpi
            if all((abs(spot - other) > _LABEL_SIZE).any() for other in taken):
                taken.append(spot)
                text = f"$10^{{{round(np.log10(row.tolerance))}}}$"
                label = ax.annotate(
                    text, place, xytext=(6, 2), textcoords="offset points", fontsize=6.5, color=color, zorder=2.5
                )
                label.set_path_effects([withStroke(linewidth=1.5, foreground="white")])


def _styles(study: WorkPrecision) -> dict[str, tuple[str, str]]:
    """Colour and marker of each solver in a study, the same in all figures."""
    from ...common.figures import MARKERS, OKABE_ITO

    present = dict.fromkeys(row.solver for row in study.rows)
    known = dict.fromkeys((*_SOLVERS, *present))
    styles = dict(zip(known, zip(OKABE_ITO, MARKERS, strict=False), strict=False))
    return {solver: styles[solver] for solver in present}


def _ring(ax: Axes, row: Row, height: float) -> None:
    """Mark what is recommended."""
    ax.plot(row.timing.median, height, "o", ms=12, mfc="none", mec="black", mew=0.9, zorder=6, label="recommended")


def _height(study: WorkPrecision, row: Row, quantity: str) -> float:
    """Where a row is drawn: an error at least at its floor, a difference as it is."""
    return study.error(row, quantity) if study.reference.comparable else row.errors[quantity]


def _dress(ax: Axes, study: WorkPrecision, quantity: str) -> None:
    """Axes, grid and title."""
    with optional_import():
        from matplotlib.ticker import LogLocator, NullFormatter

    times = [row.timing.median for row in study.rows]
    narrow = max(times) < 10.0 * min(times)
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 4, 5, 6, 8) if narrow else (1, 2, 5), numticks=30))
    ax.xaxis.set_major_formatter("{x:g}")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.grid(color="0.93", lw=0.5, zorder=0)
    ax.set_axisbelow(True)
    ax.set_xlabel("time (µs per time unit)")
    ax.set_title(f"{quantity} ({_UNITS[quantity]})", loc="left", fontsize=9)


def _caption(study: WorkPrecision) -> str:
    """What was run, and what it was compared with."""
    case, reference = study.case, study.reference
    groups = ", ".join(f"${_SYMBOLS[name]} = {value:g}$" for name, value in case.groups.to_dict().items())
    plain = Scene().to_dict()
    scene = [f"{name} = {value}" for name, value in case.scene.to_dict().items() if value != plain[name]]
    lines = [f"{groups}{''.join('; ' + each for each in scene)}"]
    slips = "" if case.scene.anchored else f", {reference.trajectory.slips} slips"
    lines.append(f"{case.holds} random holds of {case.hold:g}{slips}; reference: {reference.solver} at $10^{{-15}}$")
    if not reference.comparable:
        lines.append("trajectories are not comparable: a change in the last digit grows")
        lines.append("compared are means over twins whose starts differ by a billionth")
    return "\n".join(lines)
