"""What a map costs beside the bare motion of the same crawlers, and how it grows with cells, holds and seeds.

Run ``python benchmarks/map_speed.py`` (``--rounds N`` for more turns, ``--whole`` for 64 by 64 cells too). The
bare motion is that of the vector environment, of the same bodies, holds and valve states, without its readout. One
processor does all; works take turns in one process, and ratios are of neighbours in time. Medians with quartiles are
printed as the table of the docs and kept in `benchmarks/results/map_speed.json`.
"""

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import gymnasium as gym
import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns

from stickslip import parameter_map
from stickslip.crawler import Groups
from stickslip.studies.maps import Inputs

RESULTS = Path(__file__).parent / "results" / "map_speed.json"
PAGE = Path(__file__).parents[1] / "docs" / "reservoir.md"
SIDE, WHOLE, HOLDS, DAMPING = 16, 64, 4000, 0.02
MOTION, MEMORY, BOTH = "no more than speed", "memory", "memory and exponents"
MEASURES = {MOTION: ["speed"], MEMORY: ["memory"], BOTH: ["memory", "lyapunov"]}


def axes(side: int) -> tuple[str, str]:
    return f"duffing=0:200:{side}", f"deborah=0.05:8:{side}:log"


def bare(side: int, holds: int, anchored: bool) -> Callable[[], object]:
    """The vector environment's steps of the same holds."""
    bodies = [
        Groups(duffing=duffing, deborah=deborah, damping_ratio=DAMPING)
        for deborah in np.geomspace(0.05, 8.0, side)
        for duffing in np.linspace(0.0, 200.0, side)
    ]
    env = gym.make_vec(
        "stickslip:StickSlipCrawler-v0",
        len(bodies),
        groups=bodies,
        scene={"anchored": anchored},
        dither=0.0,
        memory_weight=0.0,
        threads=1,
        max_episode_steps=None,
        copy=False,
    )
    valve = Inputs().drawn(holds, 0).valve

    def steps() -> None:
        env.reset(seed=0)
        for state in valve:
            env.step(np.full(len(bodies), state))

    return steps


def mapped(side: int, holds: int, anchored: bool, measures: list[str], seeds: int = 1) -> Callable[[], object]:
    x, y = axes(side)
    asked = {"groups": {"damping_ratio": DAMPING}, "scene": {"anchored": anchored}, "holds": holds, "seeds": seeds}
    return lambda: parameter_map(x, y, measures=measures, **asked)


def measured(rounds: int, whole: bool) -> dict[str, Any]:
    """Ratios to the bare motion, and microseconds a hold at several sizes."""
    results: dict[str, Any] = {"machine": machine("xarray", "zarr"), "ratios": {}, "growth": {}, "side": SIDE}
    for place, anchored in (("anchored", True), ("on the ground", False)):
        works = {"bare": bare(SIDE, HOLDS, anchored)}
        works |= {name: mapped(SIDE, HOLDS, anchored, which) for name, which in MEASURES.items()}
        results["ratios"][place] = ratios(works, rounds)
    if whole:
        works = {"bare": bare(WHOLE, HOLDS, True), BOTH: mapped(WHOLE, HOLDS, True, MEASURES[BOTH])}
        results["ratios"][f"anchored, {WHOLE} by {WHOLE}"] = ratios(works, 1)
    sizes = [(8, 500, 1), (16, 500, 1), (32, 500, 1), (8, 2000, 1), (8, 8000, 1), (8, 500, 4), (8, 500, 16)]
    works = {str(size): mapped(size[0], size[1], True, MEASURES[BOTH], size[2]) for size in sizes}
    seconds = take_turns(works, max(3, rounds // 2), budget=20.0)
    for (side, holds, seeds), of_rounds in zip(sizes, seconds.values(), strict=True):
        each = [1e6 * one / (side**2 * holds * seeds) for one in of_rounds.values()]
        results["growth"][f"{side**2} cells, {holds} holds, {seeds} seeds"] = quartiles(each)
    return results


def ratios(works: dict[str, Callable[[], object]], rounds: int) -> dict[str, list[float]]:
    """Quartiles of the seconds of each work over those of the bare motion; of that itself, the seconds."""
    if rounds > 1:
        for work in works.values():
            work()  # compiles
    seconds = take_turns(works, rounds, budget=1e9)
    own = seconds["bare"]
    found = {name: quartiles([each[k] / own[k] for k in each]) for name, each in seconds.items() if name != "bare"}
    return {"bare (seconds)": quartiles(list(own.values())), **found}


def tables(results: dict[str, Any]) -> dict[str, str]:
    lines = ["| cost of a map, over that of the bare motion | " + " | ".join(results["ratios"]) + " |"]
    lines.append("| --- |" + " ---: |" * len(results["ratios"]))
    for name in MEASURES:
        cells = [
            f"{each[name][1]:.1f} [{each[name][0]:.1f}, {each[name][2]:.1f}]" if name in each else ""
            for each in results["ratios"].values()
        ]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    growth = ["| size | µs a hold |", "| --- | ---: |"]
    growth += [
        f"| {size} | {middle:.2f} [{low:.2f}, {high:.2f}] |" for size, (low, middle, high) in results["growth"].items()
    ]
    return {"map speed": "\n".join(lines), "map growth": "\n".join(growth)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--whole", action="store_true", help="also the map of 64 by 64 cells, once")
    arguments = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # else the threads of a map would share its work
    results = measured(arguments.rounds, arguments.whole)
    keep(RESULTS, results)
    made = tables(results)
    print("\n\n".join(made.values()))
    refresh(PAGE, made)


if __name__ == "__main__":
    main()
