"""Figures of the edge of chaos: exponents and memory over two numbers, and along a line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..maps.figures import plot_map
from .over_maps import name_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["plot_edge", "plot_line"]


def plot_edge(maps: Mapping[str, xr.Dataset]) -> Figure:
    """Exponent and memory over Π₁ and Π₄, anchored, hold 0.5, raw states."""
    figure = plot_map(maps[name_of("anchored", 0.5, 0.02, "raw")], ["lyapunov", "memory"])
    for ax in figure.axes[:2]:
        ax.set_xscale("symlog", linthresh=1.0)  # most happens near 0
    return figure


def plot_line(lines: Mapping[str, xr.Dataset]) -> Figure:
    """Exponent, memory and parity of two along Π₁, anchored, hold 2, raw states."""
    return plot_map(lines["hold 2, Π₂ 0.05, raw"], ["lyapunov", "memory", "parity_2"])
