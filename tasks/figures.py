"""Figures of memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast, TYPE_CHECKING

import numpy as np

from ..common.extras import optional_import
from ..reservoir import MemoryCapacity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_GONE = 0.02  # of the input: what no eye tells from nothing


def plot_memory_profile(memories: Mapping[str, MemoryCapacity], *, ax: Axes | None = None) -> Figure:
    """Plot memory capacity against delay, a curve a reservoir.

    Parameters
    ----------
    memories : mapping of str to MemoryCapacity
        By the name to show; the legend adds each corrected total and its bound. Eight at most.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there are no curves, or more than can be told apart.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt
        from matplotlib.ticker import MaxNLocator

    from ..common.figures import house_style, MARKERS, OKABE_ITO, PAGE_WIDTH, SMALL

    if not 1 <= len(memories) <= len(OKABE_ITO):
        raise ValueError(f"memories must hold 1 to {len(OKABE_ITO)} curves, got {len(memories)}")
    with house_style():
        if ax is None:
            _, ax = plt.subplots(figsize=(PAGE_WIDTH, 3.2), layout="constrained")
        last = 4
        for (name, memory), color, marker in zip(memories.items(), OKABE_ITO, MARKERS, strict=False):
            label = f"{name}: total {memory.corrected:.1f} of at most {memory.bound}"
            ax.plot(memory.delays, memory.profile, marker, ls="-", lw=1, ms=3.5, color=color, label=label)
            last = max([last, *memory.delays[memory.profile > _GONE].tolist()])
        cutoff = max(np.max(memory.cutoff) for memory in memories.values())
        ax.axhspan(0, cutoff, color="0.8", lw=0, zorder=0, label=f"what chance gives, below {cutoff:.2g}")
        ax.axhline(cutoff, color="0.4", lw=0.7, ls="--", zorder=0)
        # Curves that have come to nothing say nothing more.
        ax.set(xlim=(-0.3, last + 1.3), ylim=(-0.02, 1.05))
        ax.set(xlabel="delay $d$ (holds)", ylabel="recalled share $MC_d$")
        ax.set_title("How much of the input of $d$ holds ago a linear readout finds in the state: 1 is all of it")
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        ax.legend(
            title="total: the sum over all delays, chance taken off",
            loc="upper right" if len(memories) < 3 else "upper left",
            bbox_to_anchor=None if len(memories) < 3 else (0, -0.2),
            ncols=1 if len(memories) < 3 else 2,
            fontsize=SMALL,
        )
    return cast("Figure", ax.get_figure(root=True))
