"""Numbers of a study, as a table has them."""

from __future__ import annotations

from typing import Any, TYPE_CHECKING

import numpy as np

from ...reservoir import Estimate, mean_over_runs
from ..maps.edge import Best

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Told", "at", "exponent_at", "numbers", "said", "table"]

Told = tuple[list[list[str]], dict[str, Any]]
"""Rows of a table, its heading first, and the numbers in it by name."""


def said(estimate: Estimate, digits: int = 2) -> str:
    """A mean with its interval, if it has one."""
    if not np.isfinite(estimate.low):
        return f"{estimate.mean:.{digits}f}"
    return f"{estimate.mean:.{digits}f} [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]"


def at(found: xr.Dataset, best: Best) -> str:
    """Where in the map a cell lies."""
    dims = found["status"].dims
    values = [float(found[dim][place]) for dim, place in zip(dims, best.cell, strict=True)]
    signs = {"duffing": "Π₁", "deborah": "Π₄"}
    return ", ".join(f"{signs[str(dim)]} {value:.3g}" for dim, value in reversed(list(zip(dims, values, strict=True))))


def exponent_at(found: xr.Dataset, cell: tuple[int, ...]) -> Estimate:
    """The exponent of a cell, over the seeds."""
    return mean_over_runs(found.lyapunov.values[cell])


def numbers(estimate: Estimate) -> list[float]:
    """Mean and ends of the interval, ready for JSON."""
    return [estimate.mean, estimate.low, estimate.high]


def table(rows: list[list[str]]) -> str:
    """Rows as Markdown, their heading first."""
    lines = [rows[0], ["---", *["---:"] * (len(rows[0]) - 1)], *rows[1:]]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
