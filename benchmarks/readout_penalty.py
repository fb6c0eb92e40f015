"""What it changes that a readout's penalty is chosen by leave-one-out within the training part, and not fixed at 1e-6.

Run ``python benchmarks/readout_penalty.py``. Every task that is scored by one readout runs on every reservoir both
ways, on the same draws; a change is the mean of the differences over seeds with its 95% interval. Baselines are tuned
and scored the same way as the bodies. The table goes into `docs/reservoir.md`, all scores into
``results/readout_penalty.json``.
"""

import math
import os
from dataclasses import replace
from pathlib import Path

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh
from numpy.typing import NDArray

from stickslip.reservoir import mean_over_runs, nrmse, predict_held_out
from stickslip.studies.benchmark import Record, run_benchmark
from stickslip.tasks import ACCURACY, NRMSE, RESERVOIRS, Solution, TASKS

RESULTS = Path(__file__).parent / "results" / "readout_penalty.json"
PAGE = Path(__file__).parents[1] / "docs" / "reservoir.md"
SEEDS, LENGTH, PENALTY = range(5), 4000, 1e-6

Array = NDArray[np.float64]


def _nrmse(states: Array, targets: Array, start: int) -> Solution:
    return Solution(nrmse(*predict_held_out(states[start:], targets[start:], ridge=PENALTY)))


def _accuracy(states: Array, targets: Array, start: int) -> Solution:
    prediction, target = predict_held_out(states[start:], targets[start:], ridge=PENALTY)
    return Solution(float(np.mean((prediction >= 0.5) == (target >= 0.5))))


FIXED = {NRMSE.name: NRMSE._replace(solve=_nrmse), ACCURACY.name: ACCURACY._replace(solve=_accuracy)}
CHOSEN = {name: task for name, task in TASKS.items() if task.metric.name in FIXED}


def changes(fixed: list[Record], chosen: list[Record]) -> dict[tuple[str, str], list[float]]:
    """Differences chosen - fixed by task and reservoir, one a seed."""
    before = {score[:3]: score.score for score in fixed}
    found: dict[tuple[str, str], list[float]] = {}
    for score in chosen:
        found.setdefault((score.task, score.reservoir), []).append(score.score - before[score[:3]])
    return found


def markdown(found: dict[tuple[str, str], list[float]]) -> str:
    """The table of the page."""
    tasks, reservoirs = (list(dict.fromkeys(names)) for names in zip(*found, strict=True))
    lines = [f"| change of | {' | '.join(reservoirs)} |", f"|---|{'---:|' * len(reservoirs)}"]
    for task in tasks:
        cells = []
        for reservoir in reservoirs:
            each = mean_over_runs(found[task, reservoir], bounds=(-math.inf, math.inf))
            half = "" if math.isnan(each.low) else f" ± {(each.high - each.low) / 2:.3f}"
            cells.append(f"{each.mean:+.3f}{half}")
        lines.append(f"| {task} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, print the table, put it into the page and keep the scores."""
    asis = {name: replace(task, metric=FIXED[task.metric.name]) for name, task in CHOSEN.items()}
    runs = {
        label: run_benchmark(tasks=tasks, reservoirs=RESERVOIRS, seeds=SEEDS, length=LENGTH)
        for label, tasks in (("fixed", asis), ("chosen", CHOSEN))
    }
    table = markdown(changes(runs["fixed"], runs["chosen"]))
    print(table)
    refresh(PAGE, {"penalty": table})
    told = ("task", "reservoir", "seed", "value")
    scores = {label: [dict(zip(told, each[:4], strict=True)) for each in records] for label, records in runs.items()}
    keep(RESULTS, {"machine": machine("scikit-learn"), "penalty": PENALTY, "length": LENGTH, "scores": scores})


if __name__ == "__main__":
    main()
