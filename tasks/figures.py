"""Figures of memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast, TYPE_CHECKING

from ..reservoir import MemoryCapacity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "savefig.bbox": "tight",
    "savefig.dpi": 300,
}

_OKABE_ITO = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442", "#000000")
_MARKERS = "os^Dvp*X"


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
    from matplotlib import pyplot as plt  # matplotlib is optional, and slow to import

    if not 1 <= len(memories) <= len(_OKABE_ITO):
        raise ValueError(f"memories must hold 1 to {len(_OKABE_ITO)} curves, got {len(memories)}")
    with plt.rc_context(_STYLE):
        if ax is None:
            _, ax = plt.subplots(figsize=(6.5, 3.0), layout="constrained")
        for (name, memory), color, marker in zip(memories.items(), _OKABE_ITO, _MARKERS, strict=False):
            label = f"{name}: {memory.corrected:.2f} of {memory.bound}"
            ax.plot(memory.delays, memory.profile, marker, ls="-", lw=1, ms=3.5, color=color, label=label)
        cutoff = max(memory.cutoff for memory in memories.values())
        ax.axhspan(0, cutoff, color="0.85", lw=0, zorder=0, label="chance")
        ax.set(xlabel="delay (holds)", ylabel=r"memory capacity $MC_d$", ylim=(-0.02, 1.05))
        ax.legend(title="corrected total of bound", loc="upper left", bbox_to_anchor=(1, 1))
    return cast("Figure", ax.get_figure(root=True))
