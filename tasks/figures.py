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

    from ..common.figures import house_style, MARKERS, OKABE_ITO

    if not 1 <= len(memories) <= len(OKABE_ITO):
        raise ValueError(f"memories must hold 1 to {len(OKABE_ITO)} curves, got {len(memories)}")
    with house_style():
        if ax is None:
            _, ax = plt.subplots(figsize=(6.5, 3.0), layout="constrained")
        for (name, memory), color, marker in zip(memories.items(), OKABE_ITO, MARKERS, strict=False):
            label = f"{name}: {memory.corrected:.2f} of {memory.bound}"
            ax.plot(memory.delays, memory.profile, marker, ls="-", lw=1, ms=3.5, color=color, label=label)
        cutoff = max(np.max(memory.cutoff) for memory in memories.values())
        ax.axhspan(0, cutoff, color="0.85", lw=0, zorder=0, label="chance")
        ax.set(xlabel="delay (holds)", ylabel=r"memory capacity $MC_d$", ylim=(-0.02, 1.05))
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        ax.legend(title="corrected total of bound", loc="upper left", bbox_to_anchor=(1, 1))
    return cast("Figure", ax.get_figure(root=True))
