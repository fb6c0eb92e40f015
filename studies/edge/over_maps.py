"""Maps over Π₁ and Π₄: where memory is largest, against the exponent, and against work."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..maps.edge import best_cell, chaotic, difference, edge_cells, rank_correlation
from .study import DEBORAH, DUFFING, PLACES, READ, Study
from .wording import at, exponent_at, numbers, said, Told

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "KEPT",
    "LONG",
    "forgetting",
    "maps_of_all",
    "name_of",
    "over_all_cells",
    "where_memory_is_largest",
    "work_and_memory",
]

LONG = "anchored", 0.5, 0.02
"""Scene, hold and damping at which a linear body remembers beyond 20 delays."""
KEPT = 1e-3
"""Difference of two starts at the end, over the spread of the motion, above which the start is kept."""


def name_of(place: str, hold: float, damping: float, read: str) -> str:
    """The name of a map."""
    return f"{place}, hold {hold:g}, Π₂ {damping:g}, {read}"


def maps_of_all(
    study: Study, holds: Sequence[float] = (0.5, 2.0), dampings: Sequence[float] = (0.02, 0.05)
) -> dict[str, xr.Dataset]:
    """Memory, parity and exponents over Π₁ and Π₄, by scene, hold, damping and what is read."""
    x = ("duffing", DUFFING[:: study.size.columns])
    y = ("deborah", np.geomspace(*DEBORAH, study.size.rows))
    found = {}
    for place, scene in PLACES.items():
        for hold in holds:
            for damping in dampings:
                common = {"scene": scene, "hold": hold, "groups": {"damping_ratio": damping}}
                exponents = study.map(
                    f"{place} {hold} {damping} exponents",
                    x,
                    y,
                    measures=["lyapunov", "start", "work"],
                    virtual_nodes=1,
                    **common,
                )
                for read, nodes in READ.items():
                    own = study.map(
                        f"{place} {hold} {damping} {read}",
                        x,
                        y,
                        measures=["memory", "parity"],
                        virtual_nodes=nodes,
                        **common,
                    )
                    found[name_of(place, hold, damping, read)] = own.merge(exponents.drop_vars("status"))
                if (place, hold, damping) == LONG:
                    delays = study.size.long_delays
                    asked = {"delays": delays, "holds": study.size.long_holds, **common}
                    own = study.map(f"long {place}", x, y, measures=["memory", "parity"], virtual_nodes=1, **asked)
                    name = f"{name_of(place, hold, damping, 'raw')}, {delays} delays"
                    found[name] = own.merge(exponents.drop_vars("status"))
    return found


def where_memory_is_largest(maps: Mapping[str, xr.Dataset]) -> Told:
    """A row a map: the cell of most memory and its exponent, the best cell at the edge, and how much they differ."""
    rows, told = (
        [["map", "chaotic cells", "most memory", "at", "exponent there", "best at the edge", "at", "most less edge"]],
        {},
    )
    for name, found in maps.items():
        exponents, memory = found.lyapunov.values, found.memory.values
        best, edge = best_cell(memory), best_cell(memory, edge_cells(exponents.mean(axis=-1)))
        assert best is not None
        share = chaotic(exponents)
        row = [
            name,
            f"{share.sum()} of {share.size}",
            said(best.estimate),
            at(found, best),
            said(exponent_at(found, best.cell), 3),
        ]
        told[name] = {"chaotic": int(share.sum()), "cells": share.size, "most": numbers(best.estimate)}
        told[name] |= {"at": at(found, best), "exponent": numbers(exponent_at(found, best.cell))}
        if edge is None:
            row += ["no edge", "", ""]
        else:
            more = difference(best, edge)
            row += [said(edge.estimate), at(found, edge), said(more)]
            told[name] |= {"edge": numbers(edge.estimate), "more": numbers(more)}
        rows.append(row)
    return rows, told


def over_all_cells(maps: Mapping[str, xr.Dataset]) -> Told:
    """Rank correlations of capacities with the exponent and with its distance from 0, over the cells of a map."""
    rows, told = [["map", "capacity", "most", "exponent there", "best at the edge", "with λ", "with −abs(λ)"]], {}
    for name, found in maps.items():
        exponent = found.lyapunov.mean("seed").values
        edge = edge_cells(exponent)
        for capacity in ("memory", "parity_2", "parity_3"):
            values = found[capacity].values
            best, beside = best_cell(values), best_cell(values, edge)
            assert best is not None
            mean = values.mean(axis=-1)
            both = rank_correlation(mean, exponent), rank_correlation(mean, -np.abs(exponent))
            there = f"{float(exponent[best.cell]):.3f}"
            rows.append(
                [
                    name,
                    capacity.replace("_", " of "),
                    said(best.estimate),
                    there,
                    "" if beside is None else said(beside.estimate),
                    *(f"{each:.2f}" for each in both),
                ]
            )
            told[f"{name}: {capacity}"] = {
                "with exponent": both[0],
                "with closeness": both[1],
                "most": best.estimate.mean,
                "exponent": float(exponent[best.cell]),
                "edge": None if beside is None else beside.estimate.mean,
            }
    return rows, told


def work_and_memory(maps: Mapping[str, xr.Dataset]) -> Told:
    """Along Π₁, for each Π₄: where memory is largest, and the work there."""
    rows, told = (
        [
            [
                "map",
                "rows of Π₄",
                "largest at the least Π₁",
                "inside",
                "at the largest Π₁",
                "work there over the row's most",
                "with work, rank correlation",
            ]
        ],
        {},
    )
    for name, found in maps.items():
        memory, work = found.memory.mean("seed").values, found.work.mean("seed").values
        places = memory.argmax(axis=1)
        last = memory.shape[1] - 1
        counts = [int((places == 0).sum()), int(((places > 0) & (places < last)).sum()), int((places == last).sum())]
        there = work[np.arange(len(places)), places] / work.max(axis=1)
        own = [rank_correlation(*pair) for pair in zip(memory, work, strict=True)]
        rows.append(
            [
                name,
                str(len(places)),
                *map(str, counts),
                f"{np.median(there):.2f} ({there.min():.2f} to {there.max():.2f})",
                f"{np.median(own):.2f}",
            ]
        )
        told[name] = {"rows": len(places), "first": counts[0], "inside": counts[1], "last": counts[2]}
    return rows, told


def forgetting(maps: Mapping[str, xr.Dataset]) -> Told:
    """Whether bodies of negative exponent, and no others, come together from two starts."""
    rows, told = [["scene and body", "λ < 0, forget", "λ < 0, keep", "λ > 0, forget", "λ > 0, keep", "undecided"]], {}
    for name, found in maps.items():
        if not name.endswith("raw"):
            continue
        exponents = found.lyapunov.values
        above, below = chaotic(exponents), chaotic(-exponents)
        kept = found.start_difference.mean("seed").values > KEPT
        counts = [
            int((sign & keeps).sum()) for sign, keeps in ((below, ~kept), (below, kept), (above, ~kept), (above, kept))
        ]
        undecided = int((~above & ~below).sum())
        rows.append([name.removesuffix(", raw"), *map(str, counts), str(undecided)])
        told[name.removesuffix(", raw")] = counts
    return rows, told
