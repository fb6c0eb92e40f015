"""C6 to C9 as one figure: where SINDy fails, and how far a regression that knows of slips goes."""

from __future__ import annotations

import numpy as np

from ...common.extras import optional_import
from ...common.figures import house_style, MARKERS
from .laws import FRICTIONS, Laws, LENGTHS, NOISES, PAPER_NMSE

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

__all__ = ["plot_laws"]

_FLOOR = 1e-4  # of the scale of errors; the payload's is 1e-30


def plot_laws(laws: Laws) -> Figure:
    """One-step errors of SINDy against friction, and errors of whole runs by regression with slips."""
    with house_style():
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.0), layout="constrained")
        for marker, (name, errors) in zip(MARKERS, laws.by_friction.items(), strict=False):
            middle = np.maximum(errors.mean(axis=1), _FLOOR)
            left.plot(FRICTIONS, middle, marker + "-", ms=4, label=name)
        left.axhline(PAPER_NMSE, color="0.4", ls=":", lw=1)
        left.annotate(
            f"the paper's {PAPER_NMSE}", (FRICTIONS[0], PAPER_NMSE), (0, 3), textcoords="offset points", color="0.3"
        )
        left.annotate(
            "at rounding, 1e-30", (FRICTIONS[-1], _FLOOR), (0, 4), textcoords="offset points", ha="right", color="0.3"
        )
        left.set(yscale="log", ylim=(0.7 * _FLOOR, 2.0), xlabel="static friction s (kinetic 2 s / 3)")
        left.set(ylabel="NMSE of the acceleration, one step", title="SINDy, noise-free")
        left.legend(loc="center left", bbox_to_anchor=(0.0, 0.42))
        errors = np.median(laws.whole, axis=2)
        image = right.imshow(errors, norm=LogNorm(1e-8, 1.0), cmap="cividis", origin="lower", aspect="auto")
        for (row, column), value in np.ndenumerate(errors):
            shade = "white" if value < 1e-4 else "black"
            right.text(
                column, row, f"{value:.0e}".replace("e-0", "e-"), ha="center", va="center", color=shade, fontsize=8
            )
        right.set_xticks(range(len(NOISES)), [f"{noise:.1%}" for noise in NOISES])
        right.set_yticks(range(len(LENGTHS)), [str(length) for length in LENGTHS])
        right.set(xlabel="noise of the data", ylabel="length of the data, holds", title="Regression that finds slips")
        figure.colorbar(image, ax=right, label="NMSE of z over 200 unseen holds")
    return figure
