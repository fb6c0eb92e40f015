"""What accuracy is worth to results: scores, speeds, returns and chaotic statistics at each tolerance, against cost.

Run ``python benchmarks/accuracy_worth.py``. Every result is kept in ``benchmarks/results/accuracy_worth.json`` as it
comes, and a run that was stopped goes on where it stopped. ``--only cost`` measures one experiment anew, and leaves the
others as they are. At the end the tables are printed and written into ``docs/accuracy.md`` between their marks, and the
figure is drawn. About 13 minutes of one core from nothing, half of it for the trainings.
"""

import argparse
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from measuring import keep, machine, refresh
from worth.cost import cost
from worth.experiments import chaos, crawling, fixed_policies, tasks, Work
from worth.figure import draw
from worth.page import tables
from worth.settings import ALL

from stickslip.common.figures import save_figure

BENCHMARKS = Path(__file__).parent
RESULTS = BENCHMARKS / "results" / "accuracy_worth.json"
PAGE = BENCHMARKS.parent / "docs" / "accuracy.md"
FIGURE = BENCHMARKS.parent / "docs" / "images" / "accuracy_worth"
LIBRARIES = ("stickslip", "numpy", "numba", "llvmlite", "scipy", "scikit-learn", "stable-baselines3", "torch")


def trained_policies() -> Work:
    from worth.trainings import trained_policies  # slow to import

    return trained_policies()


EXPERIMENTS: dict[str, Callable[[], Work]] = {
    "tasks": tasks,
    "crawling": crawling,
    "fixed policy": fixed_policies,
    "chaos": chaos,
    "cost": cost,
    "trained": trained_policies,
}


def main() -> None:
    """Measure what is missing, or one experiment anew; then print, write and draw."""
    parser = argparse.ArgumentParser(description="What accuracy is worth to results, against what it costs.")
    parser.add_argument("--only", choices=list(EXPERIMENTS), help="measure this experiment anew, and no other")
    results, missing = measure(parser.parse_args().only)
    if missing:
        print(f"no tables yet: run without --only for {', '.join(missing)}")
    else:
        report(results)


def measure(only: str | None) -> tuple[dict[str, Any], list[str]]:
    """All results after measuring, each of them kept on disk as it came, and the experiments that lack some."""
    kept = json.loads(RESULTS.read_text(encoding="utf-8"))["results"] if RESULTS.exists() else {}
    if only is not None:
        kept = {key: value for key, value in kept.items() if not key.startswith(f"{only}/")}
    missing = []
    for name, experiment in EXPERIMENTS.items():
        for key, work in experiment():
            if key in kept:
                continue
            if only in (None, name):
                print(f"measuring {key}", flush=True)
                kept[key] = work()
                save(kept)
            elif name not in missing:
                missing.append(name)
    return kept, missing


def save(results: dict[str, Any]) -> None:
    """Write the file, whole or not at all."""
    content = {"machine": machine(*LIBRARIES), "tolerances": ALL, "results": results}
    RESULTS.parent.mkdir(exist_ok=True)
    keep(RESULTS, content)


def report(results: dict[str, Any]) -> None:
    """Print the tables, put them into the page and draw the figure."""
    made = tables(results)
    for name, table in made.items():
        print(f"\n{name}\n\n{table}")
    refresh(PAGE, made)
    figure = draw(results)
    save_figure(figure, *(FIGURE.with_suffix(suffix) for suffix in (".png", ".svg")))


if __name__ == "__main__":
    main()
