"""What of the paper stands: `stickslip reproduce`, and the page that it makes.

Run ``python benchmarks/claims.py``; ``--quick`` takes three seeds instead of eight, and less of all else. What is
finished in the folder is not done again. ``python benchmarks/claims.py figS6 work`` renews the claims of these figures
alone, and of what rests on the same numbers: the others stay as they were kept. Claims go
into `benchmarks/results/claims.json`, the page is `docs/claims.md`, its figures are in `docs/images`.
"""

import argparse
import json
import os
import shutil
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from measuring import keep, machine, refresh

from stickslip.common.sharing import processors
from stickslip.studies.claims.claim import Claim, CLAIMS, FIGURES
from stickslip.studies.claims.page import sections
from stickslip.studies.claims.reproduce import reproduce, STUDIES, Study

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


def _asked(study: Study, figures: Sequence[str]) -> bool:
    return not figures or not set(figures).isdisjoint(study.figures)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("figures", nargs="*", help="those to renew; all by default")
    parser.add_argument("--quick", action="store_true", help="three seeds instead of eight, and less of all else")
    parser.add_argument("--folder", type=Path, default=Path("runs/claims"))
    parser.add_argument("--processes", type=int, default=processors())
    arguments = parser.parse_args()
    found = reproduce(
        arguments.folder,
        arguments.figures,
        quick=arguments.quick,
        processes=arguments.processes,
        show=partial(print, flush=True),
    )
    drawn = {figure for study in STUDIES.values() if _asked(study, arguments.figures) for figure in study.figures}
    renewed = [claim for claim in found if drawn & set(FIGURES[claim.name])]
    before = json.loads(RESULTS.read_text(encoding="utf-8")) if arguments.figures else {"quick": arguments.quick}
    if before["quick"] != arguments.quick:
        raise ValueError(f"figures can be renewed by a run of the same size only, got quick = {arguments.quick}")
    claims = {claim["name"]: claim for claim in before.get("claims", ())}
    claims |= {claim.name: claim.as_json() for claim in renewed}
    results = {
        "machine": machine("pysindy", "xarray"),
        "quick": arguments.quick,
        "claims": [claims[name] for name in CLAIMS if name in claims],
    }
    for figure in {figure for claim in renewed for figure in FIGURES[claim.name]}:
        shutil.copyfile(arguments.folder / f"{figure}.png", IMAGES / _PICTURE.format(figure))
    keep(RESULTS, results)
    refresh(PAGE, tables(results))
    print("\n".join(f"{claim.name}  {claim.verdict}" for claim in renewed))


if __name__ == "__main__":
    main()
