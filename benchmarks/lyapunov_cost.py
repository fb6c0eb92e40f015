"""What Lyapunov exponents of a block of crawlers cost in lanes: over their motion alone, and over a vector environment.

Run ``python benchmarks/lyapunov_cost.py`` (``--rounds N`` for more turns). All take turns in one process and on one
thread, and ratios are of the same round; their median and quartiles are printed as the table of the docs and kept in
`benchmarks/results/lyapunov_cost.json`. The motion alone is what a batch of `simulate` drives in lanes, without
samples, energies and log of events. The environment steps the same crawlers by the same commands at its own default
tolerance, with four samples a hold and without memory readout.
"""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import gymnasium as gym
import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns

from stickslip import lyapunov_spectrum
from stickslip.crawler import Groups, Scene
from stickslip.crawler.batch.driving import drive_in_lanes, grow_in_lanes
from stickslip.crawler.batch.lane_runs import blank_runs, Runs
from stickslip.crawler.model.columns import coefficients_of_each
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import MAX_STEPS

RESULTS = Path(__file__).parent / "results" / "lyapunov_cost.json"
PAGE = Path(__file__).parents[1] / "docs" / "lyapunov.md"
ROWS, HOLDS, HOLD, BLOCKS = 256, 1000, 0.5, 20
CASES = {
    "default": (Groups(), Scene()),
    "anchored, `Pi1 = 200`, `Pi2 = 0.02`: chaotic": (Groups(duffing=200.0, damping_ratio=0.02), Scene(anchored=True)),
}
TOLERANCES = (1e-6, 1e-9)
MOTION, GROWTH, SPECTRUM, STEPPING = "motion", "motion and changes", "lyapunov_spectrum", "environment"
COLUMNS = (
    "motion alone, us a hold",
    "with changes, over it",
    "`lyapunov_spectrum`, over it",
    "`lyapunov_spectrum`, over steps of the vector environment",
)


def works_of(groups: Groups, scene: Scene, tolerance: float) -> dict[str, Callable[[], object]]:
    """The same holds of the same crawlers, each way."""
    valves = np.random.default_rng(0).integers(0, 2, (ROWS, HOLDS))
    columns = coefficients_of_each([groups] * ROWS, [scene] * ROWS)
    options = SOLVERS["taylor"].options(tolerance)
    ends = np.linspace(0, HOLDS, BLOCKS + 1).astype(np.int64)[1:]
    environment = gym.make_vec(
        "stickslip:StickSlipCrawler-v0",
        ROWS,
        groups=groups.to_dict(),
        scene=scene.to_dict(),
        hold=HOLD,
        threads=1,
        dither=0.0,
        memory_weight=0.0,
    )
    environment.reset(seed=0)

    def runs() -> Runs:
        return blank_runs(np.zeros((7, ROWS)), columns, np.full(ROWS, HOLD), np.empty((ROWS, 5, 0)), MAX_STEPS)

    def stepping() -> None:
        for actions in valves.T:
            environment.step(actions)

    return {
        MOTION: lambda: drive_in_lanes(np.arange(ROWS), valves, runs(), options, 1),
        GROWTH: lambda: grow_in_lanes(runs(), valves, 0, ends, options, 1),
        SPECTRUM: lambda: lyapunov_spectrum(
            [groups] * ROWS, valves, HOLD, scene=scene, tolerance=tolerance, solver="taylor", washout=0, threads=1
        ),
        STEPPING: stepping,
    }


def ratios(rounds: int) -> dict[str, dict[str, list[float]]]:
    """Quartiles of what `COLUMNS` names, by crawler and tolerance."""
    works: dict[str, Callable[[], object]] = {}
    for name, crawler in CASES.items():
        for tolerance in TOLERANCES:
            for way, work in works_of(*crawler, tolerance).items():
                work()
                works[f"{name}|{tolerance:g}|{way}"] = work
    seconds = take_turns(works, rounds)
    found = {}
    for case in dict.fromkeys(key.rpartition("|")[0] for key in works):
        turns = {way: seconds[f"{case}|{way}"] for way in (MOTION, GROWTH, SPECTRUM, STEPPING)}
        shared = [turn for turn in turns[MOTION] if all(turn in each for each in turns.values())]
        pairs = ((GROWTH, MOTION), (SPECTRUM, MOTION), (SPECTRUM, STEPPING))
        row = [quartiles([1e6 * turns[MOTION][turn] / ROWS / HOLDS for turn in shared])]
        row += [quartiles([turns[way][turn] / turns[other][turn] for turn in shared]) for way, other in pairs]
        found[case] = dict(zip(COLUMNS, row, strict=True))
    return found


def table(found: dict[str, dict[str, list[float]]]) -> str:
    """Markdown."""
    lines = [f"| crawler | tolerance | {' | '.join(COLUMNS)} |", "|---|---:|" + "---:|" * len(COLUMNS)]
    for case, row in found.items():
        cells = [f"{middle:.2f} [{low:.2f}, {high:.2f}]" for low, middle, high in row.values()]
        lines.append(f"| {' | '.join([*case.split('|'), *cells])} |")
    return "\n".join(lines)


def main() -> None:
    """Print the table, put it into the page and keep the results."""
    parser = argparse.ArgumentParser(description="Cost of exponents in lanes.")
    parser.add_argument("--rounds", type=int, default=9, help="turns of every run (default 9)")
    found = ratios(parser.parse_args().rounds)
    print(table(found))
    refresh(PAGE, {"lanes": table(found)})
    keep(RESULTS, {"machine": machine(), "rows": ROWS, "holds": HOLDS, "hold": HOLD, "ratios": found})


if __name__ == "__main__":
    main()
