"""A batch in `simulate` against the vector environment, and the start of an episode against its steps, in turns.

Run ``python benchmarks/batch.py`` (``--rounds N`` for more turns). All works take turns in one process, so that the
machine's drift falls on all alike; ratios are of neighbours in time, and their median and quartiles are printed and
kept in `benchmarks/results/batch.json`. The environment is without the readout, and has one sample a hold as the batch
has; its actions are the batch's schedules, drawn beforehand.
"""

import argparse
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import gymnasium as gym
import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns

from stickslip.crawler import Groups, simulate

RESULTS = Path(__file__).parent / "results" / "batch.json"
PAGE = Path(__file__).parents[1] / "docs" / "vector.md"
NAME = "stickslip:StickSlipCrawler-v0"
HOLD, TOLERANCE = 0.5, 1e-6
# Crawlers and holds of each case: as in sweeps, and as in long runs.
CASES = {40: 4096, 4000: 256}
NO_READOUT: dict[str, Any] = {"dither": 0.0, "memory_weight": 0.0}
RANDOM = {"duffing": (0.3, 0.7), "deborah": (0.3, 0.7), "slope": (-0.05, 0.05)}
MANY, STEPS = 4096, 40


def stepping(count: int, schedule: np.ndarray, **arguments: Any) -> Callable[[], None]:
    """All the holds of a schedule, by the environment."""
    env = gym.make_vec(NAME, count, hold=HOLD, tolerance=TOLERANCE, max_episode_steps=None, **NO_READOUT, **arguments)
    env.reset(seed=0)
    columns = np.ascontiguousarray(schedule.T)

    def steps() -> None:
        for actions in columns:
            env.step(actions)

    return steps


def restarting(count: int) -> Callable[[], None]:
    """The start of an episode of crawlers drawn anew."""
    env = gym.make_vec(NAME, count, hold=HOLD, tolerance=TOLERANCE, randomize=RANDOM, **NO_READOUT)
    env.reset(seed=0)
    return lambda: env.reset()


def works() -> dict[str, Callable[[], object]]:
    rng = np.random.default_rng(0)
    made: dict[str, Callable[[], object]] = {}
    for holds, count in CASES.items():
        schedule = rng.integers(0, 2, (count, holds))
        different = [Groups(deborah=float(deborah)) for deborah in rng.uniform(0.3, 0.7, count)]
        made[f"environment, {holds} holds"] = stepping(count, schedule)
        for name, groups in (("", Groups()), (", groups differ", different)):
            made[f"simulate, {holds} holds{name}"] = partial(simulate, groups, schedule, HOLD, tolerance=TOLERANCE)
    made["steps of randomised crawlers"] = stepping(MANY, rng.integers(0, 2, (MANY, STEPS)), randomize=RANDOM)
    made["episode start of randomised crawlers"] = restarting(MANY)
    return made


def tables(results: dict[str, Any]) -> dict[str, str]:
    """Tables of the page, by name."""
    lines = ["| crawlers x holds | | us a hold | over the environment |", "|---|---|---:|---:|"]
    for holds, count in CASES.items():
        for name in (
            f"environment, {holds} holds",
            f"simulate, {holds} holds",
            f"simulate, {holds} holds, groups differ",
        ):
            who = name.replace(f", {holds} holds", "")
            ratio = _cell(results["ratios"][f"{name} over environment"]) if "simulate" in name else ""
            lines.append(f"| {count} x {holds} | {who} | {_cell(results['us a hold'][name])} | {ratio} |")
    head = f"| {MANY} randomised crawlers | ratio |\n|---|---:|\n"
    start = f"| episode start over {STEPS} steps | {_cell(results['ratios']['episode start over 40 steps'])} |"
    return {"batch": "\n".join(lines), "batch starts": head + start}


def _cell(quartile: list[float]) -> str:
    low, middle, high = quartile
    return f"{middle:.2f} [{low:.2f}, {high:.2f}]"


def main() -> None:
    """Measure, print and keep, and write the page's tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    rounds = parser.parse_args().rounds
    each = works()
    for work in each.values():
        work()
    seconds = take_turns(each, rounds)
    results: dict[str, Any] = {"machine": machine("gymnasium"), "rounds": rounds, "us a hold": {}, "ratios": {}}
    for holds, count in CASES.items():
        environment = seconds[f"environment, {holds} holds"]
        for name in (
            f"environment, {holds} holds",
            f"simulate, {holds} holds",
            f"simulate, {holds} holds, groups differ",
        ):
            times = [1e6 * second / (holds * count) for second in seconds[name].values()]
            results["us a hold"][name] = quartiles(times)
            shared = [turn for turn in seconds[name] if turn in environment]
            results["ratios"][f"{name} over environment"] = quartiles(
                [seconds[name][turn] / environment[turn] for turn in shared]
            )
    steps, starts = seconds["steps of randomised crawlers"], seconds["episode start of randomised crawlers"]
    results["ratios"]["episode start over 40 steps"] = quartiles(
        [starts[turn] / steps[turn] for turn in starts if turn in steps]
    )
    for kind in ("us a hold", "ratios"):
        print(f"\n{kind}: median [quartiles]")
        for name, (low, middle, high) in results[kind].items():
            print(f"    {name:55}{middle:8.3f} [{low:.3f}, {high:.3f}]")
    keep(RESULTS, results)
    refresh(PAGE, tables(results))


if __name__ == "__main__":
    main()
