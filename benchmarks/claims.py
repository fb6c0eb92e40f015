"""What of the paper stands: `stickslip reproduce`, and the page that it makes.

Run ``python benchmarks/claims.py``; ``--quick`` takes three seeds instead of eight, and less of all else. What is
finished in the folder is not done again. Claims go into `benchmarks/results/claims.json`, the page is
`docs/claims.md`, its figures are in `docs/images`.
"""

import argparse
import os
import shutil
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from measuring import keep, machine, refresh

from stickslip.common.sharing import processors
from stickslip.studies.claims.claim import Claim, FIGURES
from stickslip.studies.claims.page import sections
from stickslip.studies.claims.reproduce import reproduce

RESULTS = Path(__file__).parent / "results" / "claims.json"
PAGE = Path(__file__).parents[1] / "docs" / "claims.md"
IMAGES = Path(__file__).parents[1] / "docs" / "images"
_PICTURE = "claims_{}.png"


def tables(results: Mapping[str, Any]) -> dict[str, str]:
    """The page's sections, and the command that wrote them."""
    decided = [Claim.from_json(each) for each in results["claims"]]
    return {
        "command": f"Written by `python benchmarks/claims.py{' --quick' if results['quick'] else ''}`.",
        "claims": sections(decided, f"images/{_PICTURE}"),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="three seeds instead of eight, and less of all else")
    parser.add_argument("--folder", type=Path, default=Path("runs/claims"))
    parser.add_argument("--processes", type=int, default=processors())
    arguments = parser.parse_args()
    decided = reproduce(
        arguments.folder, quick=arguments.quick, processes=arguments.processes, show=partial(print, flush=True)
    )
    results = {
        "machine": machine("pysindy", "xarray"),
        "quick": arguments.quick,
        "claims": [claim.as_json() for claim in decided],
    }
    for figure in {figure for figures in FIGURES.values() for figure in figures}:
        shutil.copyfile(arguments.folder / f"{figure}.png", IMAGES / _PICTURE.format(figure))
    keep(RESULTS, results)
    refresh(PAGE, tables(results))
    print("\n".join(f"{claim.name}  {claim.verdict}" for claim in decided))


if __name__ == "__main__":
    main()
