"""What trainings come to beside what needs none, over weights, dithers and seeds.

Run ``python benchmarks/training_outcomes.py``; ``--minutes 9`` begins no training after so long. Every training is kept
in ``benchmarks/results/training_outcomes.json`` as it ends, and a run that was stopped goes on where it stopped. A
training is that of ``stickslip train``: the shipped hyperparameters of PPO, the defaults of the environment but for
weight and dither, and the verdict that every training ends with, on fresh seeds over long runs. At the end the tables
are written into ``docs/training.md`` between their marks, and say of how many trainings they are.
"""

import argparse
import json
import os
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh
from scipy.stats import binomtest

from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.run import Configuration
from stickslip.train.training import train
from stickslip.train.verdict import read_report

BENCHMARKS = Path(__file__).parent
RESULTS = BENCHMARKS / "results" / "training_outcomes.json"
PAGE = BENCHMARKS.parent / "docs" / "training.md"

DITHER = 0.1
WEIGHTS = (0.0, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)
SEEDS = range(10)
QUIETER_AND_NOISIER = (0.0, 0.05, 0.25)
FEWER_SEEDS = range(3)
LIMITS = BENCHMARKS / "results" / "trade_limits.json"  # by dynamic programming: benchmarks/trade_limits.py


class Training(NamedTuple):
    """One of the trainings."""

    weight: float
    dither: float
    seed: int

    @property
    def key(self) -> str:
        """Its name in the results."""
        return f"{self.weight}/{self.dither}/{self.seed}"


def trainings() -> list[Training]:
    """All of them, every weight once before one is trained again."""
    of_weights = [Training(weight, DITHER, seed) for seed in SEEDS for weight in WEIGHTS]
    of_dithers = [Training(0.0, dither, seed) for seed in FEWER_SEEDS for dither in QUIETER_AND_NOISIER]
    return sorted(of_weights + of_dithers, key=lambda each: each.seed)


def outcome(training: Training, entry: dict[str, Any]) -> dict[str, Any]:
    """The verdict's numbers, and how long the training took, the verdict's own time included."""
    asked = Configuration(
        env_kwargs={"memory_weight": training.weight, "dither": training.dither},
        hyperparameters=entry,
        seed=training.seed,
    )
    wall, processor = time.perf_counter(), time.process_time()
    with TemporaryDirectory(prefix="training_outcomes_") as folder:
        report = read_report(train(asked, Path(folder)).folder)
    assert report is not None
    means = {
        name: {term: float(np.mean(runs[term])) for term in ("speed", "memory", "reward")}
        for name, runs in {"policy": report["policy"], **report["baselines"]}.items()
    }
    still = any(
        report["policy"]["reward"] == report["baselines"][name]["reward"] for name in ("held open", "held shut")
    )
    return {
        **means,
        "gain": report["gain of reward"],
        "best baseline": report["best baseline"],
        "word": report["baselines"]["best word"]["word"],
        "loses": report["loses"],
        "holds still": still,
        "seconds": {"wall": time.perf_counter() - wall, "processor": time.process_time() - processor},
    }


def measure(minutes: float) -> dict[str, Any]:
    """All outcomes by key, each kept on disk as it came; none is begun after `minutes`."""
    entry = read_hyperparameters("ppo", Configuration.environment)
    kept = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    found: dict[str, Any] = kept.get("outcomes", {}) if kept.get("hyperparameters") == entry else {}
    end = time.monotonic() + 60.0 * minutes
    for training in trainings():
        if training.key not in found and time.monotonic() < end:
            found[training.key] = outcome(training, entry)
            print(
                training,
                {name: found[training.key][name] for name in ("policy", "gain", "loses", "seconds")},
                flush=True,
            )
            made_by = machine("torch", "stable-baselines3")
            keep(RESULTS, {"machine": made_by, "hyperparameters": entry, "outcomes": found})
    return found


def spread(values: Sequence[float]) -> str:
    """Mean and standard deviation over trainings."""
    return f"{np.mean(values):.3f}" + (f" ± {np.std(values, ddof=1):.3f}" if len(values) > 1 else "")


def share(lost: int, count: int) -> str:
    """How many of how many, with the exact 95% interval of the share."""
    interval = binomtest(lost, count).proportion_ci(0.95, "exact")
    return f"{lost} of {count} [{100 * interval.low:.0f}%, {100 * interval.high:.0f}%]"


def table_of_weights(found: dict[str, Any]) -> str:
    lines = [
        "| memory weight | speed | memory | reward | best that needs no training | its reward | hold still | lose |",
        "| ---: | ---: | ---: | ---: | --- | ---: | ---: | --- |",
    ]
    everything = []
    for weight in WEIGHTS:
        each = [found[key] for key in (Training(weight, DITHER, seed).key for seed in SEEDS) if key in found]
        if not each:
            continue
        everything += each
        terms = " | ".join(spread([one["policy"][term] for one in each]) for term in ("speed", "memory", "reward"))
        best = each[0]["best baseline"]
        named = f"the word {each[0]['word']}" if best == "best word" else best
        baseline = f"{np.mean([one[one['best baseline']]['reward'] for one in each]):.3f}"
        still = sum(one["holds still"] for one in each)
        lost = sum(one["loses"] for one in each)
        lines.append(f"| {weight:g} | {terms} | {named} | {baseline} | {still} | {lost} of {len(each)} |")
    lost = sum(one["loses"] for one in everything)
    lines.append(
        f"| all | | | | | | {sum(one['holds still'] for one in everything)} | {share(lost, len(everything))} |"
    )
    return "\n".join(lines)


def limits() -> dict[float, float]:
    """The most speed that any policy has, by dither."""
    kept = json.loads(LIMITS.read_text(encoding="utf-8"))["limit"]["dithers"]
    return {float(dither): each["speed"][0] for dither, each in kept.items()}


def table_of_dithers(found: dict[str, Any]) -> str:
    lines = ["| dither | speed | of the limit, least | limit | trainings |", "| ---: | ---: | ---: | ---: | ---: |"]
    for dither, limit in limits().items():
        each = [found[key] for key in (Training(0.0, dither, seed).key for seed in SEEDS) if key in found]
        if each:
            speeds = [one["policy"]["speed"] for one in each]
            least = f"{100 * min(speeds) / limit:.1f}%"
            lines.append(f"| {dither:g} | {spread(speeds)} | {least} | {limit:.3f} | {len(each)} |")
    return "\n".join(lines)


def table_of_seconds(found: dict[str, Any]) -> str:
    """What a training takes; the clock on the wall has waited for others, where the machine had more to do."""
    lines = ["| seconds of one training, its verdict included | mean | least | most |", "| --- | ---: | ---: | ---: |"]
    for name, what in (("processor", "of all threads together"), ("wall", "on the wall, the machine busy or not")):
        each = [one["seconds"][name] for one in found.values()]
        lines.append(f"| {what} | {np.mean(each):.0f} | {min(each):.0f} | {max(each):.0f} |")
    return "\n".join(lines)


def tables(found: dict[str, Any]) -> dict[str, str]:
    """What the page shows, by the names of its marks."""
    return {
        "outcomes": table_of_weights(found),
        "limits": table_of_dithers(found),
        "seconds of a training": table_of_seconds(found),
    }


def main() -> None:
    """Train what is missing; then print and write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--minutes", type=float, default=float("inf"), help="Begin no training after so long.")
    found = measure(parser.parse_args().minutes)
    made = tables(found)
    print("\n\n".join(made.values()))
    seconds = [one["seconds"]["processor"] for one in found.values()]
    print(f"\n{len(found)} of {len(trainings())} trainings; processor seconds of one: {spread(seconds)}")
    refresh(PAGE, made)


if __name__ == "__main__":
    main()
