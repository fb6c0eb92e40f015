"""Figures of maps: a panel a variable, in colours that all tell apart, with what is uncertain hatched."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.extras import optional_import
from ..benchmark.figures.sweeps import SWEPT_LABELS
from .statistics import over_seeds

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["drawn_names", "plot_map"]

EXPONENT, RIDGE = "lyapunov", "memory"
# Standard errors within which the sign of an exponent is not told.
_TOLD = 2.0
_ROOM = 26  # letters of a label beside a low panel
_SIGNED = "RdBu_r"
_POSITIVE = "cividis"
_ZERO: dict[str, Any] = {"colors": "black", "linewidths": 1.4}
_HATCH: dict[str, Any] = {"fill": False, "hatch": "/////", "ec": "0.35", "lw": 0.0}
_WHITE: dict[str, Any] = {"ls": "none", "mec": "black", "mfc": "white", "mew": 0.8}
_OF_COLUMN: dict[str, Any] = {"marker": "o", "ms": 3.2, **_WHITE}
_OF_ALL: dict[str, Any] = {"marker": "*", "ms": 12, **_WHITE}
_UNITS = {
    "t_c": "$t_c$",
    "z_c": "$z_c$",
    "1 / t_c": "$1 / t_c$",
    "z_c / t_c": "$z_c / t_c$",
    "P_max A_0": r"$P_{\max} A_0$",
    "P_max A_0 z_c": r"$P_{\max} A_0 z_c$",
}


def drawn_names(found: xr.Dataset) -> list[str]:
    """Variables of a map that a panel can show: a number a cell and seed."""
    return [str(name) for name, each in found.data_vars.items() if each.dims[-1] == "seed"]


def plot_map(found: xr.Dataset, names: Sequence[str] | None = None) -> Figure:
    """A map's variables, a panel each: colours over two numbers, or curves over one.

    Parameters
    ----------
    found : xarray.Dataset
        As from `parameter_map`, or `in_si` of it.
    names : sequence of str, optional
        Variables without a further dimension; all of them by default.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page at most. Means over the seeds. Over two numbers: where the map has exponents, black lines are
        the contour of zero, and in their panel cells are hatched where the exponent is within two standard errors of
        it; where it has memory, circles mark the cell of most memory in each column, and a star that of all. Over one:
        bands are 95% intervals, and vertical lines stand where the exponent changes its sign.

    Raises
    ------
    ValueError
        If a variable is not in the map.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ...common.figures import house_style, PAGE_WIDTH

    drawn = drawn_names(found) if names is None else list(names)
    for name in drawn:
        if name not in drawn_names(found):
            raise ValueError(f"names must be of {drawn_names(found)}, got {name!r}")
    means = over_seeds(found)
    axes = [str(dim) for dim in found["status"].dims]
    columns = min(2, len(drawn)) if len(axes) == 2 else 1
    rows = -(-len(drawn) // columns)
    size = PAGE_WIDTH if columns == 2 else 4.4, 0.4 + (2.5 if len(axes) == 2 else 1.7) * rows
    with house_style():
        figure, grid = plt.subplots(
            rows, columns, squeeze=False, sharex=len(axes) == 1, figsize=size, layout="constrained"
        )
        for ax, name in zip(grid.flat, drawn, strict=False):
            (_draw_map if len(axes) == 2 else _draw_line)(ax, found, means, name, axes)
        for ax in grid.flat[len(drawn) :]:
            ax.set_axis_off()
        if len(axes) == 2:
            _explain(figure, means, drawn)
        else:
            for ax in grid[:-1, 0]:
                ax.set_xlabel("")
    return figure


def _draw_map(ax: Axes, found: xr.Dataset, means: xr.Dataset, name: str, axes: list[str]) -> None:
    with optional_import():
        from matplotlib.colors import CenteredNorm

    y, x = (means[axis].values for axis in axes)
    values = means[name].values
    signed = name == EXPONENT
    colours: dict[str, Any] = {"cmap": _SIGNED, "norm": CenteredNorm()} if signed else {"cmap": _POSITIVE}
    mesh = ax.pcolormesh(_edges(x), _edges(y), values, rasterized=True, **colours)
    for axis, coordinates in zip("yx", (y, x), strict=True):
        if _geometric(coordinates):
            getattr(ax, f"set_{axis}scale")("log")
    if name == EXPONENT:
        _hatch(ax, x, y, np.abs(values) < _TOLD * standard_errors(found, means))
    if EXPONENT in means and min(values.shape) > 1:
        exponent = np.ma.masked_invalid(means[EXPONENT].values)
        if exponent.min() < 0.0 < exponent.max():
            ax.contour(x, y, exponent, levels=[0.0], **_ZERO)
    if RIDGE in means:
        memory = np.nan_to_num(means[RIDGE].values, nan=-1.0)
        ax.plot(x, y[memory.argmax(axis=0)], **_OF_COLUMN)
        row, column = np.unravel_index(int(memory.argmax()), memory.shape)
        ax.plot(x[column], y[row], **_OF_ALL)
    colourbar = ax.figure.colorbar(mesh, ax=ax)
    colourbar.set_label(label(found, name))
    ax.set(xlabel=label(found, axes[1]), ylabel=label(found, axes[0]))


def _explain(figure: Figure, means: xr.Dataset, drawn: Sequence[str]) -> None:
    """A legend of the marks."""
    with optional_import():
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

    handles: list[Any] = []
    if EXPONENT in means:
        line = {"color": _ZERO["colors"], "lw": _ZERO["linewidths"]}
        handles.append(Line2D([], [], label="exponent 0", **line))
    if EXPONENT in drawn:
        handles.append(Patch(label=f"within {_TOLD:g} standard errors of 0", **_HATCH))
    if RIDGE in means:
        handles.append(Line2D([], [], label="most memory of the column", **_OF_COLUMN))
        handles.append(Line2D([], [], label="of all", **_OF_ALL))
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=2 if len(drawn) == 1 else 4, fontsize=8)


def _hatch(ax: Axes, x: NDArray[Any], y: NDArray[Any], where: NDArray[np.bool_]) -> None:
    """Hatch cells, each over its own area."""
    with optional_import():
        from matplotlib.patches import Rectangle

    left, low = _edges(x), _edges(y)
    for row, column in np.argwhere(where).tolist():
        width, height = left[column + 1] - left[column], low[row + 1] - low[row]
        ax.add_patch(Rectangle((left[column], low[row]), width, height, **_HATCH))


def _edges(values: NDArray[Any]) -> NDArray[Any]:
    """Edges of the cells around values: half way between neighbours, on the scale of the axis."""
    if _geometric(values):
        return np.exp(_edges(np.log(values)))
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    half = np.diff(values) / 2.0
    return np.concatenate([[values[0] - half[0]], values[:-1] + half, [values[-1] + half[-1]]])


def _draw_line(ax: Axes, found: xr.Dataset, means: xr.Dataset, name: str, axes: list[str]) -> None:
    from ...common.figures import OKABE_ITO

    x = means[axes[0]].values
    if found.sizes["seed"] > 1:
        ax.fill_between(x, means[f"{name}_low"], means[f"{name}_high"], color=OKABE_ITO[0], alpha=0.25, lw=0)
    ax.plot(x, means[name], ".-", ms=3, color=OKABE_ITO[0])
    if EXPONENT in means:
        for crossing in crossings(x, means[EXPONENT].values):
            ax.axvline(crossing, color="0.4", lw=0.8, ls="--", zorder=0)
    if name == EXPONENT:
        ax.axhline(0.0, color="0.4", lw=0.8, zorder=0)
    if _geometric(x):
        ax.set_xscale("log")
    ax.set(xlabel=label(found, axes[0]), ylabel=_folded(label(found, name)))


def _folded(said: str) -> str:
    """A label in lines that a low panel has room for, its unit whole."""
    if len(said) <= _ROOM:
        return said
    name, bracket, unit = said.partition(" (")
    return "\n".join([*textwrap.wrap(name, _ROOM), *([f"({unit}"] if bracket else [])])


def standard_errors(found: xr.Dataset, means: xr.Dataset) -> NDArray[np.float64]:
    """Of the exponent in each cell: over the seeds, or of the one run."""
    if found.sizes["seed"] > 1:
        return np.asarray(means[f"{EXPONENT}_error"].values)
    return np.asarray(means[f"{EXPONENT}_standard_error"].values)


def crossings(x: NDArray[Any], values: NDArray[Any]) -> list[float]:
    """Where values change their sign, by straight lines between neighbours."""
    before, after = values[:-1], values[1:]
    changed = np.flatnonzero(before * after < 0.0)
    share = before[changed] / (before[changed] - after[changed])
    return (x[changed] + share * (x[changed + 1] - x[changed])).tolist()


def label(found: xr.Dataset, name: str) -> str:
    """A variable's or a coordinate's name and unit, for an axis."""
    attributes = found[name].attrs
    unit = attributes.get("units", "1")
    if name in SWEPT_LABELS and (unit == "1" or unit in _UNITS):
        return SWEPT_LABELS[name]
    said = str(attributes.get("long_name", name))
    return said if unit == "1" else f"{said} ({_UNITS.get(unit, unit)})"


def _geometric(values: NDArray[Any]) -> bool:
    if len(values) < 3 or values[0] <= 0.0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.ptp(steps) < 1e-6 * steps.max())
