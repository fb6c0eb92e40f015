"""A fine line through the edge: capacities by degree."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TYPE_CHECKING

import numpy as np

from ..maps.edge import best_cell, difference, edge_cells
from ..maps.figures import crossings
from .study import PLACES, READ, Study
from .wording import exponent_at, numbers, said

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LINES", "lines_through_the_edge"]

LINES = {"hold 0.5, Π₂ 0.02": (0.5, 0.02), "hold 2, Π₂ 0.05": (2.0, 0.05)}
"""Hold and damping of each."""


def lines_through_the_edge(
    study: Study, measures: Sequence[str] = ("memory", "parity", "capacity")
) -> tuple[dict[str, xr.Dataset], list[list[str]], dict[str, Any]]:
    """Anchored, along Π₁, at a lag of the fluid at which the exponent changes its sign: capacities by degree."""
    x = ("duffing", np.geomspace(0.1, 100.0, study.size.line))
    lines: dict[str, xr.Dataset] = {}
    told: dict[str, Any] = {}
    heading = [
        "line, read",
        "capacity",
        "largest at Π₁ (over seeds)",
        "λ there",
        "most",
        "beside λ = 0",
        "most less edge",
    ]
    rows = [heading]
    for line, (hold, damping) in LINES.items():
        groups = {"damping_ratio": damping, "deborah": 0.5}
        common = {"scene": PLACES["anchored"], "hold": hold, "groups": groups, "holds": study.size.line_holds}
        exponents = study.map(f"line {hold} exponents", x, measures=["lyapunov", "work"], virtual_nodes=1, **common)
        mean = exponents.lyapunov.mean("seed").values
        edge = edge_cells(mean)
        told[line] = {"crossings": crossings(x[1], mean)}
        for read, nodes in READ.items():
            own = study.map(f"line {hold} {read}", x, measures=list(measures), virtual_nodes=nodes, **common)
            lines[f"{line}, {read}"] = found = own.merge(exponents.drop_vars("status"))
            series = {name: found[name].values for name in ("memory", "parity_2", "parity_3")}
            for degree in (1, 2, 3) if "capacity" in measures else ():
                series[f"degree {degree}"] = found.capacity.sel(degree=degree).transpose("duffing", "seed").values
            for name, values in series.items():
                best, beside = best_cell(values), best_cell(values, edge)
                assert best is not None
                places = found.duffing.values[values.argmax(axis=0)]
                row = [f"{line}, {read}", name.replace("_", " of ")]
                row += [f"{np.median(places):.2g} ({places.min():.2g} to {places.max():.2g})"]
                row += [said(exponent_at(found, best.cell), 3), said(best.estimate)]
                more = None if beside is None else difference(best, beside)
                row += ["", ""] if beside is None or more is None else [said(beside.estimate), said(more)]
                rows.append(row)
                told[f"{line}, {read}: {name}"] = {
                    "at": float(np.median(places)),
                    "exponent": float(mean[best.cell]),
                    "most": numbers(best.estimate),
                    "edge": None if beside is None else numbers(beside.estimate),
                    "more": None if more is None else numbers(more),
                }
    return lines, rows, told
