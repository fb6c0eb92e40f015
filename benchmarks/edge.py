"""Whether memory lives at the edge of chaos: maps, a line through the edge, chaos on the ground, and verdicts.

Run ``python benchmarks/edge.py``; ``--quick`` takes less than three minutes. Maps are kept in ``runs/edge`` and gone on
with. Numbers go into `benchmarks/results/edge.json`, tables and verdicts into `docs/edge.md`, figures into
`docs/images`; a quick run prints them and leaves the page alone. The study itself is `stickslip.studies.edge`.
"""

import argparse
import os
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from measuring import keep, machine, refresh

from stickslip.common.figures import save_figure
from stickslip.common.sharing import processors
from stickslip.studies.edge import FULL, QUICK, Study
from stickslip.studies.edge.chain import chains
from stickslip.studies.edge.figures import plot_edge, plot_line
from stickslip.studies.edge.ground import chaos_on_the_ground, chaotic_words
from stickslip.studies.edge.line import lines_through_the_edge
from stickslip.studies.edge.modes import modes
from stickslip.studies.edge.over_maps import (
    forgetting,
    maps_of_all,
    over_all_cells,
    where_memory_is_largest,
    work_and_memory,
)
from stickslip.studies.edge.spread import spread_of_work
from stickslip.studies.edge.verdicts import verdicts
from stickslip.studies.edge.wording import table

RESULTS = Path(__file__).parent / "results" / "edge.json"
PAGE = Path(__file__).parents[1] / "docs" / "edge.md"
IMAGES = Path(__file__).parents[1] / "docs" / "images"


def tables(results: Mapping[str, Any]) -> dict[str, str]:
    """The page's tables and verdicts."""
    return {
        "verdicts": verdicts(results["told"]),
        **{name: table(rows) for name, rows in results["rows"].items()},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer of everything; the page stays as it is")
    parser.add_argument("--folder", type=Path, default=Path("runs/edge"))
    parser.add_argument("--processes", type=int, default=processors())
    arguments = parser.parse_args()
    study = Study(QUICK if arguments.quick else FULL, arguments.folder, arguments.processes, partial(print, flush=True))
    maps = maps_of_all(study)
    lines, line_rows, line_told = lines_through_the_edge(study)
    made = {
        "largest memory": where_memory_is_largest(maps),
        "all cells": over_all_cells(maps),
        "line": (line_rows, line_told),
        "work": work_and_memory(maps),
        "forgetting": forgetting(maps),
        "modes": modes(study),
        "ground": chaos_on_the_ground(study),
        "words": chaotic_words(study),
        "chain": chains(study),
        "spread of work": spread_of_work(study),
    }
    results = {
        "machine": machine("xarray", "zarr"),
        "size": asdict(study.size),
        "told": {name: numbers for name, (_, numbers) in made.items()},
        "rows": {name: rows for name, (rows, _) in made.items()},
    }
    for name, text in tables(results).items():
        print(f"\n{name}\n{text}")
    drawn = {
        "edge": plot_edge(maps),
        "edge_line": plot_line(lines),
    }
    folder = arguments.folder if arguments.quick else IMAGES
    for name, figure in drawn.items():
        save_figure(figure, *(folder / f"{name}.{form}" for form in ("png", "svg")))
    if not arguments.quick:
        keep(RESULTS, results)
        refresh(PAGE, tables(results))


if __name__ == "__main__":
    main()
