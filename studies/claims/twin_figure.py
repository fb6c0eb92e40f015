"""C2 as a figure: one spring and chains against the finest chain, by the tube's mass."""

from __future__ import annotations

from typing import Any

from ...common.extras import optional_import
from ...common.figures import house_style, MARKERS, OKABE_ITO, PAGE_WIDTH, SMALL
from .twin import MASSES, PAPER_LIMIT, REGIMES, SEGMENTS, SHARES, TWIN, Twin

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_twin"]

_LINE: dict[str, Any] = {"color": "0.4", "ls": ":", "lw": 1}


def plot_twin(twin: Twin) -> Figure:
    """NMSE of z and of the foot: of one spring by the tube's mass, and by the number of segments."""
    with house_style():
        figure, axes = plt.subplots(2, 2, sharex="row", sharey="row", figsize=(PAGE_WIDTH, 6.0), layout="constrained")
        for place, what in enumerate(("z", "the foot")):
            _one_spring(axes[0, place], twin, place)
            _chains(axes[1, place], twin, place)
            axes[0, place].set_title(f"One spring: {what}")
            axes[1, place].set_title(f"Segments, nominal: {what}")
        for row in axes:
            row[0].set_ylabel("NMSE")
        axes[0, 0].set(yscale="log", ylim=(5e-7, 1.0))
        axes[1, 0].set(yscale="log", ylim=(1e-8, 10.0))
        _limit(axes[0, 0], 0.0)
        _limit(axes[1, 0], 1.0)
        axes[0, 1].legend(title="a third of the tube at each end\n(dashed: half)", loc="lower right")
        axes[1, 1].legend(title="mass of the tube", loc="upper right", ncols=3)
    return figure


def _one_spring(ax: Axes, twin: Twin, place: int) -> None:
    for colour, marker, regime in zip(OKABE_ITO, MARKERS, REGIMES, strict=False):
        for line, share in zip(("--", "-"), SHARES, strict=True):
            label = regime if line == "-" else None
            errors = twin.lumped[regime, share][place].mean(axis=1)
            ax.plot(MASSES, errors, marker + line, color=colour, ms=4, label=label)
    ax.axhline(PAPER_LIMIT, **_LINE)
    ax.set(xscale="log", xlabel="mass of the tube, of payload and foot")
    ax.set_xticks(MASSES, [str(mass) for mass in MASSES])
    ax.minorticks_off()


def _chains(ax: Axes, twin: Twin, place: int) -> None:
    """One spring, by either way of lumping, and the chains that are not the finest."""
    names = ["1, third", "1, half", *map(str, SEGMENTS[:-1])]
    third, half = (twin.lumped["nominal", share][place].mean(axis=1) for share in reversed(SHARES))
    chains = twin.refined[place].mean(axis=-1)
    for colour, marker, row in zip(OKABE_ITO, MARKERS, range(len(MASSES)), strict=False):
        ax.plot(range(1, len(names)), [half[row], *chains[:, row]], marker + "-", color=colour, ms=4, label=MASSES[row])
        ax.plot(0, third[row], marker, color=colour, ms=4)
    ax.axhline(PAPER_LIMIT, **_LINE)
    ax.set_xticks(range(len(names)), names)
    ax.set(xlabel=f"segments, against {SEGMENTS[-1]} (1: against {TWIN})")


def _limit(ax: Axes, end: float) -> None:
    """Name the paper's limit at either end of its line."""
    ax.annotate(
        f"the paper's {PAPER_LIMIT}",
        (end, PAPER_LIMIT),
        (2 - 4 * end, 2),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right" if end else "left",
        color="0.3",
        fontsize=SMALL,
    )
