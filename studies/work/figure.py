"""Work as a figure: what spreads it, Jarzynski's average by beta, and the free energy that it would give."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...common.extras import optional_import
from ...common.figures import house_style, MARKERS, OKABE_ITO, PAGE_WIDTH
from .study import BETAS, COUNTS, Study

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.patches import Patch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_work"]

_BETA = r"$\beta$ ($1 / P_{\max} A_0 z_c$)"
_TRUSTED = 30.0  # samples that must carry an average for it to be drawn full


def plot_work(study: Study) -> Figure:
    """Spread by body, the average by beta, and the free energy by beta and number of runs."""
    with house_style():
        figure = plt.figure(figsize=(PAGE_WIDTH, 5.6), layout="constrained")
        rows = figure.add_gridspec(2, 1, height_ratios=(1.0, 1.1))
        above, below = figure.add_subfigure(rows[0]), figure.add_subfigure(rows[1])
        _spreads(above.subplots(), study)
        left, right = below.subplots(1, 2)
        _averages(left, study)
        _free_energies(right, study)
    return figure


def _spreads(ax: Axes, study: Study) -> None:
    names = list(study.spreads)
    for row, spread in enumerate(study.spreads.values()):
        (whole, low, high), share = spread.relative, spread.parts.share
        ax.barh(row, whole * (1.0 - share), color=OKABE_ITO[0], height=0.6)
        ax.barh(row, whole * share, left=whole * (1.0 - share), color=OKABE_ITO[1], height=0.6)
        ax.errorbar(whole, row, xerr=[[whole - low], [high - whole]], color="black", lw=1, capsize=2)
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.set(xlabel="standard deviation of the work over its mean (lines: 95%)", xlim=(0.0, None))
    ax.set_title("What spreads the work?")
    handles = [Patch(color=OKABE_ITO[place], label=what) for place, what in enumerate(("inputs", "starts"))]
    ax.legend(handles=handles, title="made by, as shares of the variance", loc="center right")


def _averages(ax: Axes, study: Study) -> None:
    for marker, (name, found) in zip(
        MARKERS,
        {"energy conserved": study.conserving, "damped": study.damped, "crawler, from rest": study.crawler}.items(),
        strict=False,
    ):
        means = np.array([found[beta].mean for beta in BETAS])
        ends = np.array([found[beta].interval for beta in BETAS]).T
        lines = ax.errorbar(BETAS, means, np.abs(ends - means), fmt=marker + "-", ms=4, lw=1, label=name)
        hollow = [beta for beta in BETAS if found[beta].samples < _TRUSTED]
        ax.plot(
            hollow,
            [found[beta].mean for beta in hollow],
            marker,
            ms=4,
            mfc="white",
            color=lines.lines[0].get_color(),
            zorder=4,
        )
    ax.axhline(1.0, color="0.4", lw=0.8, zorder=0)
    ax.set(xscale="log", xlabel=_BETA, ylabel=r"$\langle \exp(-\beta W) \rangle$")
    ax.set(title="Is Jarzynski's average 1?", ylim=(-0.05, 2.4))
    ax.legend(title=f"hollow: fewer than {_TRUSTED:.0f} runs carry it", loc="upper right")


def _free_energies(ax: Axes, study: Study) -> None:
    works = study.cycles
    ax.axhspan(float(works.min()), float(works.mean()), color="0.92", zorder=0)
    for marker, count in zip(MARKERS, COUNTS, strict=False):
        found = [study.by_count[beta, count].free_energy for beta in BETAS if (beta, count) in study.by_count]
        if found:
            ax.plot(BETAS, found, marker + "-", ms=4, lw=1, label=str(count))
    ax.axhline(0.0, color="black", lw=1, ls="--")
    ax.annotate("energy that is stored", (BETAS[-1], 0.0), (0, 3), textcoords="offset points", ha="right")
    ax.set(xscale="log", xlabel=_BETA, ylabel=r"$-\ln\langle \exp(-\beta W)\rangle / \beta$ ($P_{\max} A_0 z_c$)")
    ax.set(title="What free energy would it give?", ylim=(-0.75, None))
    ax.legend(title="runs; grey: least to mean work", loc="lower center", ncols=3)
