"""C6 to C9 as one figure: where SINDy fails, and how far a regression that knows of slips goes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...common.extras import optional_import
from ...common.figures import house_style, MARKERS, PAGE_WIDTH, SMALL
from .laws import FRICTIONS, Laws, LENGTHS, NOISES, PAPER_NMSE

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

__all__ = ["plot_laws"]

_BREAK: dict[str, Any] = {"marker": [(-1, -0.5), (1, 0.5)], "ms": 8, "ls": "none", "mec": "black", "clip_on": False}


def plot_laws(laws: Laws) -> Figure:
    """One-step errors of SINDy against friction, and errors of whole runs by regression with slips."""
    with house_style():
        figure, axes = plt.subplot_mosaic(
            [["left", "right"], ["floor", "right"]],
            figsize=(PAGE_WIDTH, 3.2),
            layout="constrained",
            height_ratios=(4.0, 1.0),
        )
        left, floor, right = axes["left"], axes["floor"], axes["right"]
        for ax in (left, floor):
            for marker, (name, found) in zip(MARKERS, laws.by_friction.items(), strict=False):
                ax.plot(FRICTIONS, found.mean(axis=1), marker + "-", ms=4, label=name)
            ax.set(yscale="log", xlim=(0.05, 0.85))
        left.axhline(PAPER_NMSE, color="0.4", ls=":", lw=1)
        left.annotate(
            f"the paper's {PAPER_NMSE}", (FRICTIONS[0], PAPER_NMSE), (0, 3), textcoords="offset points", color="0.3"
        )
        least = laws.by_friction["payload, cubic"].mean(axis=1)
        left.set(ylim=(5e-4, 2.0), ylabel="NMSE of the acceleration, one step", title="SINDy, noise-free")
        left.tick_params(axis="x", which="both", bottom=False, labelbottom=False)
        left.spines["bottom"].set_visible(False)
        floor.set(ylim=(0.01 * least.min(), 100.0 * least.max()), xlabel="static friction s (kinetic 2 s / 3)")
        floor.set_yticks([10.0 ** np.round(np.log10(np.median(least)))])
        floor.minorticks_off()
        left.plot([0.0], [0.0], transform=left.transAxes, color="black", **_BREAK)
        floor.plot([0.0], [1.0], transform=floor.transAxes, color="black", **_BREAK)
        left.legend(loc="lower right")
        errors = np.median(laws.whole, axis=2)
        image = right.imshow(errors, norm=LogNorm(1e-8, 1.0), cmap="cividis", origin="lower", aspect="auto")
        for (row, column), value in np.ndenumerate(errors):
            shade = "white" if value < 1e-4 else "black"
            right.text(
                column, row, f"{value:.0e}".replace("e-0", "e-"), ha="center", va="center", color=shade, fontsize=SMALL
            )
        right.set_xticks(range(len(NOISES)), [f"{noise:.1%}" for noise in NOISES])
        right.set_yticks(range(len(LENGTHS)), [str(length) for length in LENGTHS])
        right.set(xlabel="noise of the data", ylabel="length of the data, holds", title="Regression that finds slips")
        figure.colorbar(image, ax=right, label="NMSE of z over 200 unseen holds")
    return figure
