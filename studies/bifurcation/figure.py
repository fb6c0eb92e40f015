"""The figure of a bifurcation diagram."""

from __future__ import annotations

from typing import Any, TYPE_CHECKING

import numpy as np

from ...common.extras import optional_import
from ...common.figures import house_style, OKABE_ITO
from ..benchmark.figures.sweeps import SWEPT_LABELS

with optional_import():
    from matplotlib import pyplot as plt

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .diagram import BifurcationDiagram

__all__ = ["plot_diagram"]

_INTERVAL = 1.96
_DOTS: dict[str, Any] = {"ls": "none", "marker": ".", "ms": 1.6, "mew": 0.0, "color": "black", "rasterized": True}


def plot_diagram(diagram: BifurcationDiagram) -> Figure:
    """The sections above, the exponents below with their 95% intervals and a line at 0."""
    x, sections = diagram.values, diagram.sections
    with house_style():
        figure, (above, below) = plt.subplots(
            2, 1, sharex=True, figsize=(5.2, 4.6), layout="constrained", height_ratios=(3, 2)
        )
        # As dark as a dot is, where there are many.
        alpha = float(np.clip(100.0 / sections.shape[1], 0.2, 1.0))
        above.plot(np.repeat(x, sections.shape[1]), sections.ravel(), alpha=alpha, **_DOTS)
        what = "hold" if diagram.inputs.dither or len(diagram.inputs.word) == 1 else "word"
        above.set_ylabel(f"$z$ at the end of each {what} ($z_c$)")
        below.axhline(0.0, color="0.4", lw=0.8)
        for column, name in enumerate(("first", "second")):
            middle, error = diagram.exponents[:, column], _INTERVAL * diagram.standard_error[:, column]
            below.fill_between(x, middle - error, middle + error, color=OKABE_ITO[column], alpha=0.25, lw=0)
            below.plot(x, middle, ".-", ms=2.5, lw=0.9, color=OKABE_ITO[column], label=f"{name} exponent")
        below.set(ylabel="exponents of $(z, v)$ ($1 / t_c$)", xlabel=SWEPT_LABELS.get(diagram.name, diagram.name))
        below.legend(fontsize=8, ncols=2, loc="lower left")
        ratios = np.diff(np.log(x)) if x[0] > 0.0 else np.zeros(0)
        if len(ratios) > 1 and np.ptp(ratios) < 1e-6 * ratios.max():
            below.set_xscale("log")
    return figure
