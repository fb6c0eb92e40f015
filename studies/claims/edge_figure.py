"""C3 to C5 as figures: memory against work, the map of exponent and memory, and a line through the edge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...common.extras import optional_import
from ...common.figures import house_style, MARKERS, PAGE_WIDTH
from ..edge.figures import plot_edge as plot_map_of_edge
from ..edge.figures import plot_line
from ..edge.over_maps import name_of
from .edge import Edge

with optional_import():
    from matplotlib import pyplot as plt

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_edge", "plot_through_the_edge", "plot_work"]


def plot_work(edge: Edge) -> Figure:
    """The paper's Fig. 2: memory against work along Pi1, a line a lag of the fluid, each work over its row's most."""
    with house_style():
        figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.9), sharey=True, layout="constrained")
        for ax, place in zip(axes, ("anchored", "ground"), strict=True):
            found = edge.maps[name_of(place, 0.5, 0.02, "raw")].mean("seed")
            rows = np.linspace(0, found.sizes["deborah"] - 1, 4).round().astype(int)
            for marker, row in zip(MARKERS, rows, strict=False):
                one = found.isel(deborah=row)
                share = one.work / one.work.max()
                ax.plot(share, one.memory, marker + "-", ms=4, label=f"$\\Pi_4$ = {float(one.deborah):.2g}")
                ax.plot(share[0], one.memory[0], "o", ms=9, mfc="none", color="0.4", lw=0)
            ax.set(xlabel="work a hold, over the most along $\\Pi_1$", title=place, xlim=(0.0, 1.05))
        axes[0].set(ylabel="memory capacity", ylim=(0.0, None))
        axes[1].legend(title=f"ringed: $\\Pi_1$ = {float(edge.maps[name_of('ground', 0.5, 0.02, 'raw')].duffing[0]):g}")
    return figure


def plot_edge(edge: Edge) -> Figure:
    """The paper's Fig. 3: exponent and memory over Pi1 and Pi4."""
    return plot_map_of_edge(edge.maps)


def plot_through_the_edge(edge: Edge) -> Figure:
    """The paper's S7: exponent, memory and parity along a line through the edge."""
    return plot_line(edge.lines)
