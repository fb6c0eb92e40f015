"""Tables and figures of `docs/reservoir.md` and the README: all tasks on all reservoirs, sweeps, and closed loops.

Run ``python benchmarks/laboratory.py``. Every attempt is kept in ``runs/laboratory``, which a further run goes on from.
Numbers go into `benchmarks/results/laboratory.json`, tables into `docs/reservoir.md` and `README.md`, figures into
`docs/images`. ``--quick`` makes what the README shows alone; ``--tables`` leaves the closed loops, whose scores are in
that file, as they are. ``--draw`` only draws those figures anew that the kept means tell.
"""

import argparse
import json
import math
import os
import shutil
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from measuring import keep, machine, refresh

from stickslip.common.figures import save_figure
from stickslip.reservoir import Estimate
from stickslip.studies.benchmark.bench import Bench
from stickslip.studies.benchmark.figures import plot_scores, plot_sweep
from stickslip.studies.benchmark.probe import probes
from stickslip.studies.benchmark.report import as_markdown, cell, KNOWN
from stickslip.studies.search import held_out_scores
from stickslip.tasks import BodyReservoir, DelayLine, EchoState, Reservoir, TASKS
from stickslip.tasks.task import mean_score

SEEDS = 15
SHOWN = (
    "memory capacity",
    "NARMA-2 NRMSE",
    "NARMA-10 NRMSE",
    "NARMA-10 uniform NRMSE",
    "parity-2 capacity",
    "parity-3 capacity",
    "Lorenz valid time",
)
BESIDE = ("crawler", "delay line", "echo-state network", "cycle reservoir")
SWEEPS = {
    "hold": "hold=0.125,0.25,0.5,1,2,4",
    "amplitude": "amplitude=0.25,0.5,1,2,4",
    "damping_ratio": "damping_ratio=0.0125,0.025,0.05,0.1,0.2,0.4",
}
LOOPS = ("Lorenz valid time", "Mackey-Glass valid time")
CHOICE = 1000
"""The seed by which a network's radius and input scaling are chosen for a closed loop."""
FIGURES = ("scores", "differences", "profiles", "information", "predictions")
ROOT = Path(__file__).parents[1]
FOLDER = Path("runs/laboratory")
RESULTS = ROOT / "benchmarks" / "results" / "laboratory.json"


def run(name: str, **arguments: Any) -> tuple[dict[str, Any], list[list[str]], list[list[str]]]:
    """A benchmark in its folder: what its JSON says but for single scores, and its two tables."""
    bench = Bench(FOLDER / name, seeds=SEEDS, resume=True, **arguments)
    for finished in bench.run():
        print(f"\r{name}: {finished} of {bench.total}", end="", flush=True)
    print()
    scores, differences = bench.report()
    told = json.loads((FOLDER / name / "benchmark.json").read_text(encoding="utf-8"))
    return {key: told[key] for key in ("inputs", "made for", "means", "differences")}, scores, differences


def closed_loops() -> dict[str, Any]:
    """Valid times of bodies and of networks up to some hundreds of nodes, as they are usually reported."""
    found: dict[str, Any] = {}
    sizes: dict[str, list[Reservoir]] = {
        "crawler, 12 features": [BodyReservoir(virtual_nodes=4)],
        "crawler, 60 features": [BodyReservoir(virtual_nodes=20)],
        "delay line, 60 taps": [DelayLine(60)],
        **{
            f"network, {nodes} nodes": [
                EchoState(nodes, radius, scaling, centred=True) for radius in (0.3, 0.6, 0.9) for scaling in (1.0, 3.0)
            ]
            for nodes in (12, 60, 300)
        },
    }
    for name, candidates in sizes.items():
        for task in LOOPS:
            chosen = candidates[0]
            if len(candidates) > 1:
                tried = [TASKS[task].attempt(each, length=4000, seed=CHOICE, washout=200).score for each in candidates]
                chosen = candidates[tried.index(max(tried))]
            scores, _ = held_out_scores(TASKS[task], chosen, range(SEEDS), validation_seeds=[CHOICE])
            found.setdefault(name, {})[task] = {"reservoir": repr(chosen), "scores": scores}
        print(*rows_of_loops({name: found[name]})[1], flush=True)
    return {"found": found, "probes": probes({task: TASKS[task] for task in LOOPS}, {})}


def rows_of_loops(found: dict[str, Any]) -> list[list[str]]:
    """Mean valid times with their intervals, a row a reservoir, under a row of headings."""
    rows = [["reservoir", *LOOPS]]
    for name, of_task in found.items():
        each = [mean_score(TASKS[task], of_task[task]["scores"]) for task in LOOPS]
        rows.append([name, *(cell(one) for one in each)])
    return rows


def draw(results: dict[str, Any]) -> None:
    """Draw anew what the kept means tell: all scores, their differences, and the sweep of the hold."""
    images = ROOT / "docs" / "images"
    scores, differences, hold = (
        {
            (row["task"], row["reservoir"]): Estimate(
                row["mean"], *(row["interval"] or (math.nan, math.nan)), row["seeds"]
            )
            for row in rows
        }
        for rows in (results["all"]["means"], results["all"]["differences"], results["hold"]["means"])
    )
    save_figure(plot_scores(scores, KNOWN), images / "bench_scores.png")
    save_figure(plot_scores(differences, KNOWN, against=BESIDE[0]), images / "bench_differences.png")
    by_task: dict[str, dict[float, Estimate]] = {}
    for (task, reservoir), one in hold.items():
        by_task.setdefault(task, {})[float(reservoir.rpartition(" ")[2])] = one
    values = sorted(next(iter(by_task.values())))
    shown = {task: [each[value] for value in values] for task, each in by_task.items()}
    save_figure(plot_sweep("hold", values, shown, KNOWN), images / "bench_sweep_hold.png")


def main() -> None:
    """Run, and write numbers, tables and figures."""
    parser = argparse.ArgumentParser(description="The tables of the laboratory's page and of the README.")
    parser.add_argument("--quick", action="store_true", help="only what the README shows")
    parser.add_argument("--tables", action="store_true", help="of closed loops only the table of the kept scores")
    parser.add_argument("--draw", action="store_true", help="only draw anew what the kept means tell")
    arguments = parser.parse_args()
    results = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    if arguments.draw:
        draw(results)
        return
    results["machine"] = machine("scipy", "scikit-learn")
    # What the README shows comes first, in the folder of all.
    results["readme"], shown, _ = run("all", tasks=",".join(SHOWN), reservoirs=",".join(BESIDE))
    refresh(ROOT / "README.md", {"tasks": as_markdown(shown)})
    keep(RESULTS, results)
    if arguments.quick:
        return
    page = ROOT / "docs" / "reservoir.md"
    for name, sweep in SWEEPS.items():
        results[name], table, _ = run(name, sweep=sweep)
        refresh(page, {name: as_markdown(table)})
        keep(RESULTS, results)
    shutil.copy(FOLDER / "hold" / "sweep.png", ROOT / "docs" / "images" / "bench_sweep_hold.png")
    if not arguments.tables:
        results["closed loops"] = closed_loops()
    refresh(page, {"loops": as_markdown(rows_of_loops(results["closed loops"]["found"]))})
    keep(RESULTS, results)
    results["all"], scores, differences = run("all")
    refresh(page, {"all": as_markdown(scores), "differences": as_markdown(differences)})
    for figure in FIGURES:
        shutil.copy(FOLDER / "all" / f"{figure}.png", ROOT / "docs" / "images" / f"bench_{figure}.png")
    keep(RESULTS, results)


if __name__ == "__main__":
    main()
