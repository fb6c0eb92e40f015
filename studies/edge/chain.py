"""A chain of three segments, whose edge is where two starts no longer come together."""

import numpy as np

from ..maps.edge import best_cell
from .over_maps import KEPT
from .study import DEBORAH, PLACES, Study
from .wording import at, said, Told

__all__ = ["CHAIN", "chains"]

CHAIN = {"segments": 3, "tube_mass": 0.3}


def chains(study: Study) -> Told:
    """A chain of three segments, whose edge is where two starts no longer come together."""
    x = ("duffing", np.array([0.0, 2.0, 20.0, 80.0, 200.0])[:: 1 if study.size.chain > 3 else 2])
    y = ("deborah", np.geomspace(*DEBORAH, study.size.chain))
    rows, told = (
        [["scene", "cells that keep their start", "most memory", "at", "keeps its start", "most of a cell that does"]],
        {},
    )
    for place, scene in PLACES.items():
        found = study.map(
            f"chain {place}",
            x,
            y,
            measures=["memory", "start"],
            virtual_nodes=1,
            scene=scene | CHAIN,
            groups={"damping_ratio": 0.02},
            seeds=4,
            holds=study.size.holds // 2,
        )
        kept = found.start_difference.mean("seed").values > KEPT
        best, inside = best_cell(found.memory.values), best_cell(found.memory.values, kept)
        assert best is not None
        row = [
            place,
            f"{kept.sum()} of {kept.size}",
            said(best.estimate),
            at(found, best),
            "yes" if kept[best.cell] else "no",
        ]
        rows.append([*row, "" if inside is None else said(inside.estimate)])
        told[place] = {
            "kept": int(kept.sum()),
            "cells": kept.size,
            "most": best.estimate.mean,
            "best keeps": bool(kept[best.cell]),
        }
    return rows, told
