"""Policies trained on bodies that `randomize` draws, against those trained on one, on frictions and slopes never seen.

Run ``python benchmarks/robustness.py``; ``--minutes 9`` begins no training after so long. Every training is kept in
``benchmarks/results/robustness.json`` as it ends, judged on every ground, and a run that was stopped goes on where it
stopped. At the end the tables are written into ``docs/training.md`` between their marks.
"""

import argparse
import json
import os
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh
from numpy.typing import NDArray

from stickslip.reservoir import mean_over_runs
from stickslip.studies.benchmark.report import as_markdown, cell
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.long_runs import LongRuns, of_policy, of_words
from stickslip.train.policies import read_policy
from stickslip.train.run import Configuration
from stickslip.train.schedules import necklaces
from stickslip.train.training import train
from stickslip.train.verdict import STANDARD

BENCHMARKS = Path(__file__).parent
RESULTS = BENCHMARKS / "results" / "robustness.json"
PAGE = BENCHMARKS.parent / "docs" / "training.md"

DRAWN = {"static_friction": [0.25, 0.45], "kinetic_friction": [0.1, 0.25], "slope": [-0.05, 0.05]}
RECIPES: dict[str, dict[str, Any]] = {"one body": {}, "drawn bodies": {"randomize": DRAWN}}
WEIGHTS = 0.2, 0.0  # of memory: the default, whose policies hardly look at the body, and speed alone, whose do
SEEDS = range(2)
JUDGES = range(3_000_000, 3_000_016)
LENGTH = {"steps": 2000, "burn_in": 1000}
LONGEST_WORD = 8


class Ground(NamedTuple):
    """What a policy crawls on."""

    static_friction: float
    kinetic_friction: float
    slope: float

    @property
    def key(self) -> str:
        """Its name in the results."""
        return f"{self.static_friction}/{self.kinetic_friction}/{self.slope}"

    @property
    def arguments(self) -> dict[str, Any]:
        """Of the environment."""
        frictions = {"static_friction": self.static_friction, "kinetic_friction": self.kinetic_friction}
        return {"groups": frictions, "scene": {"slope": self.slope}}


HOME = Ground(0.3, 0.2, 0.0)
FRICTIONS = (0.15, 0.08), (0.3, 0.2), (0.55, 0.35), (0.7, 0.5)
SLOPES = -0.1, 0.0, 0.1
# Where the slope outweighs the drag a foot once loose slides down for ever, whatever the valve does.
GROUNDS = tuple(
    Ground(*frictions, slope) for frictions, slope in product(FRICTIONS, SLOPES) if frictions[1] + slope > 0.0
)
NEVER_SEEN = tuple(ground for ground in GROUNDS if ground != HOME)


def key_of(weight: float, recipe: str, seed: int) -> str:
    """Name of a training in the results."""
    return f"{weight}/{recipe}/{seed}"


def word_key(weight: float) -> str:
    """Name of the best words in the results."""
    return f"{weight}/best word"


def on_every_ground(runs: Callable[[dict[str, Any]], LongRuns]) -> dict[str, Any]:
    """What something comes to on each ground, a number a seed."""
    found = {ground.key: runs(ground.arguments) for ground in GROUNDS}
    return {key: {term: values.tolist() for term, values in each._asdict().items()} for key, each in found.items()}


def best_word(arguments: dict[str, Any]) -> LongRuns:
    """The schedule of most reward on a ground, the valve held open or shut among them, judged on other seeds."""
    words = list(necklaces(LONGEST_WORD))
    shorter = {name: count // 2 for name, count in LENGTH.items()}
    tried = of_words(words, arguments, seeds=range(2_000_000, 2_000_004), **shorter)
    best = words[int(np.argmax([runs.reward.mean() for runs in tried]))]
    return of_words([best], arguments, seeds=JUDGES, **LENGTH)[0]


def training(weight: float, recipe: str, seed: int, entry: dict[str, Any]) -> dict[str, Any]:
    """Train a policy, and judge it on every ground."""
    asked = Configuration(env_kwargs={"memory_weight": weight, **RECIPES[recipe]}, hyperparameters=entry, seed=seed)
    with TemporaryDirectory(prefix="robustness_") as folder:
        # What it came to at home against words is not asked here.
        policy = read_policy(train(asked, Path(folder), judging=replace(STANDARD, longest_word=1)).best_policy)
    fixed = {name: value for name, value in policy.env_kwargs.items() if name not in ("randomize", "groups", "scene")}
    return on_every_ground(lambda ground: of_policy(policy, {**fixed, **ground}, seeds=JUDGES, **LENGTH))


def measure(minutes: float) -> dict[str, Any]:
    """All results, each kept on disk as it came; none is begun after `minutes`."""
    entry = read_hyperparameters("ppo", Configuration.environment)
    made_for = json.loads(
        json.dumps({"hyperparameters": entry, "drawn": DRAWN, "judges": list(JUDGES), "length": LENGTH})
    )
    kept = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    found: dict[str, Any] = kept.get("found", {}) if kept.get("made for") == made_for else {}
    works: dict[str, Callable[[], dict[str, Any]]] = {
        key_of(weight, recipe, seed): partial(training, weight, recipe, seed, entry)
        for weight, seed, recipe in product(WEIGHTS, SEEDS, RECIPES)
    }
    for weight in WEIGHTS:
        works[word_key(weight)] = partial(
            on_every_ground, lambda ground, weight=weight: best_word({"memory_weight": weight, **ground})
        )
    end = time.monotonic() + 60.0 * minutes
    for name, work in works.items():
        done = name in found and all(ground.key in found[name] for ground in GROUNDS)
        if not done and time.monotonic() < end:
            found[name] = work()
            print(name, f"{np.mean([each['reward'] for each in found[name].values()]):.3f}", flush=True)
            keep(RESULTS, {"machine": machine("torch", "stable-baselines3"), "made for": made_for, "found": found})
    return found


def of_recipe(found: dict[str, Any], weight: float, recipe: str, ground: Ground, term: str) -> NDArray[np.float64]:
    """A term on a ground by seed that judges, the mean over trainings."""
    names = [name for name in (key_of(weight, recipe, seed) for seed in SEEDS) if name in found]
    return np.mean([found[name][ground.key][term] for name in names], axis=0)


def told(values: NDArray[np.float64], digits: int = 2, sign: str = "") -> str:
    """A mean over seeds, and its interval."""
    return cell(mean_over_runs(values, bounds=(-np.inf, np.inf)), digits, sign)


def table_of_grounds(found: dict[str, Any], weight: float) -> str:
    """Reward, speed and memory on every ground."""
    rows = [
        [
            "frictions", "slope", "best word, reward", "one body, reward", "drawn bodies, reward", "difference",
            "one body: speed, memory", "drawn bodies: speed, memory",
        ]
    ]  # fmt: skip
    for ground in GROUNDS:
        rewards = [of_recipe(found, weight, recipe, ground, "reward") for recipe in RECIPES]
        terms = [
            f"{of_recipe(found, weight, recipe, ground, 'speed').mean():.2f}, "
            f"{of_recipe(found, weight, recipe, ground, 'memory').mean():.2f}"
            for recipe in RECIPES
        ]
        rows.append(
            [
                f"{ground.static_friction:g}, {ground.kinetic_friction:g}{' (home)' if ground == HOME else ''}",
                f"{ground.slope:g}",
                told(np.array(found[word_key(weight)][ground.key]["reward"])),
                *map(told, rewards),
                told(rewards[1] - rewards[0], 2, "+"),
                *terms,
            ]
        )
    return as_markdown(rows)


def table_of_trainings(found: dict[str, Any]) -> str:
    """Each training at home and over all grounds never seen."""
    rows = [
        [
            "weight",
            "trained on",
            "seed",
            "reward at home",
            "never seen: reward",
            "speed",
            "memory",
            "below the best word",
        ]
    ]
    for weight, recipe, seed in product(WEIGHTS, RECIPES, SEEDS):
        if (name := key_of(weight, recipe, seed)) in found:
            over = {
                term: np.mean([found[name][ground.key][term] for ground in NEVER_SEEN], axis=0)
                for term in ("reward", "speed", "memory")
            }
            lost = sum(
                np.mean(found[name][ground.key]["reward"]) < np.mean(found[word_key(weight)][ground.key]["reward"])
                for ground in NEVER_SEEN
            )
            home = np.array(found[name][HOME.key]["reward"])
            rows.append(
                [
                    f"{weight:g}",
                    recipe,
                    str(seed),
                    told(home),
                    *map(told, over.values()),
                    f"{lost} of {len(NEVER_SEEN)}",
                ]
            )
    return as_markdown(rows)


def tables(found: dict[str, Any]) -> dict[str, str]:
    """What the page shows, by the names of its marks."""
    grounds = {f"grounds at weight {weight:g}": table_of_grounds(found, weight) for weight in WEIGHTS}
    return {"robustness": table_of_trainings(found), **grounds}


def main() -> None:
    """Train what is missing; then print and write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--minutes", type=float, default=float("inf"), help="Begin no training after so long.")
    found = measure(parser.parse_args().minutes)
    made = tables(found)
    print("\n\n".join(made.values()))
    refresh(PAGE, made)


if __name__ == "__main__":
    main()
