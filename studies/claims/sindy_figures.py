"""C6 to C8 as figures: accelerations told and true, the quadratic term of an offset, and what the rates change."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...common.extras import optional_import
from ...common.figures import house_style, OKABE_ITO, PAGE_WIDTH
from .laws import Laws, OFFSETS, PAPER_NMSE, TRACED, WAYS

with optional_import():
    from matplotlib import pyplot as plt

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_offsets", "plot_polynomial", "plot_rates", "plot_ways"]


def plot_polynomial(laws: Laws) -> Figure:
    """The paper's S8: the foot's acceleration, and the one that a cubic tells."""
    return _plot_trace(laws, TRACED[0])


def plot_rates(laws: Laws) -> Figure:
    """The paper's S10: the same with max(0, p') and sign(p') in the library."""
    return _plot_trace(laws, TRACED[1])


def plot_ways(laws: Laws) -> Figure:
    """The paper's Fig. 5: errors with the rates in the library and without, and in other ways."""
    with house_style():
        figure, ax = plt.subplots(figsize=(6.0, 3.0), layout="constrained")
        for row, (name, errors) in enumerate(laws.by_way.items()):
            ax.barh(row, errors.mean(), color=OKABE_ITO[1] if name == TRACED[1] else OKABE_ITO[0], height=0.6)
            ax.plot(errors, np.full(errors.size, row), ".", color="black", ms=4)
        ax.axvline(PAPER_NMSE, color="0.4", ls=":", lw=1)
        ax.annotate(f"the paper's {PAPER_NMSE}", (PAPER_NMSE, -0.3), (3, 0), textcoords="offset points", color="0.3")
        ax.set_yticks(range(len(laws.by_way)), list(laws.by_way))
        ax.invert_yaxis()
        ax.set(xlabel="NMSE of the foot's acceleration, one step (dots: seeds)", xlim=(0.0, 0.6))
    return figure


def plot_offsets(laws: Laws) -> Figure:
    """The paper's S9: the quadratic term that SINDy finds where z is measured from an offset."""
    found, exact = laws.offsets
    with house_style():
        figure, ax = plt.subplots(figsize=(4.0, 3.0), layout="constrained")
        ax.plot(OFFSETS, exact, "-", color="0.4", label=r"$-3\,\Pi_1 c / (1 - r)$, of $(z + c)^3$")
        ax.plot(OFFSETS, found, "o", ms=5, label="SINDy")
        ax.set(xlabel="offset $c$ of $z$ ($z_c$)", ylabel="coefficient of $z^2$ in $X_p''$")
        ax.legend()
    return figure


def _plot_trace(laws: Laws, name: str) -> Figure:
    told, true = laws.traces[name]
    time = np.arange(1, told.size + 1) * WAYS[name].step
    with house_style():
        figure, ax = plt.subplots(figsize=(PAGE_WIDTH, 2.6), layout="constrained")
        ax.plot(time, true, color=OKABE_ITO[7], lw=1, label="true")
        ax.plot(time, told, color=OKABE_ITO[1], lw=1, label=f"SINDy, {name}")
        ax.set(xlabel="time ($t_c$)", ylabel="foot's acceleration ($z_c / t_c^2$)")
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    return figure
