"""Learning curves of every algorithm, over a DummyVecEnv of single environments and over the native batch.

Run ``python benchmarks/learning_curves.py``. Every training is kept in ``benchmarks/results/learning_curves.json`` as
it ends, and a run that was stopped goes on where it stopped. Each algorithm has the package's hyperparameters, with
fewer steps, and the speed task; a curve is the mean reward per step of the periodic evaluations. At the end the table
is written into ``docs/training.md`` between its marks, and the figure is drawn. About 8 minutes of one core from
nothing.
"""

import json
import os
import time
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TYPE_CHECKING

os.environ.setdefault("OMP_NUM_THREADS", "1")

import gymnasium as gym
import numpy as np
from measuring import keep, machine, refresh

from stickslip.common.extras import optional_import
from stickslip.common.figures import house_style, OKABE_ITO, PAGE_WIDTH, save_figure
from stickslip.train import StickSlipVecEnv
from stickslip.train.evaluations import read_evaluations
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.run import Configuration
from stickslip.train.training import train

with optional_import():
    from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BENCHMARKS = Path(__file__).parent
RESULTS = BENCHMARKS / "results" / "learning_curves.json"
PAGE = BENCHMARKS.parent / "docs" / "training.md"
FIGURE = BENCHMARKS.parent / "docs" / "images" / "learning_curves"

TASK = {"memory_weight": 0.0, "dither": 0.0}
# Both kinds of PPO update once in 8192 steps.
STEPS = {"ppo": 65_536, "a2c": 32_768, "dqn": 32_768, "qrdqn": 32_768, "recurrent_ppo": 65_536}
ALGORITHMS = tuple(STEPS)
SEEDS = range(3)
OPTIMUM = 1.0615  # the best open-loop word, without its start from rest
EPISODES = 20  # of the random policy


def dummy(count: int, **arguments: Any) -> VecEnv:
    return DummyVecEnv([lambda: gym.make(Configuration.environment, **arguments) for _ in range(count)])


def native(count: int, **arguments: Any) -> VecEnv:
    return StickSlipVecEnv(count, sparse_infos=True, **arguments)


WAYS = {"DummyVecEnv": dummy, "native": native}


def curve(algorithm: str, seed: int, way: str) -> dict[str, Any]:
    """Steps and mean reward per step of a training's evaluations, and the processor's seconds."""
    entry = {**read_hyperparameters(algorithm, Configuration.environment), "n_timesteps": STEPS[algorithm]}
    configuration = Configuration(algorithm=algorithm, env_kwargs=TASK, hyperparameters=entry, seed=seed)
    start = time.process_time()
    with TemporaryDirectory(prefix="learning_curves_") as folder:
        run = train(configuration, Path(folder), vec_env=WAYS[way])
        table = read_evaluations(run.folder / "evaluations.csv")
    steps, rewards = [row.steps for row in table], [row.reward for row in table]
    return {"steps": steps, "reward": rewards, "seconds": time.process_time() - start}


def yardsticks() -> dict[str, float]:
    """Mean reward per step of the valve held shut, held open, and moved by the toss of a coin."""
    generator = np.random.default_rng(0)
    policies = {
        "held shut": lambda: np.zeros(EPISODES, int),
        "held open": lambda: np.ones(EPISODES, int),
        "random": lambda: generator.integers(0, 2, EPISODES),
    }
    found = {}
    for name, act in policies.items():
        environments = StickSlipVecEnv(EPISODES, **TASK)
        environments.reset()
        found[name] = float(np.mean([environments.step(act())[1] for _ in range(1000)]))
    return found


def measure() -> dict[str, Any]:
    """All curves, each kept on disk as it came."""
    curves = json.loads(RESULTS.read_text(encoding="utf-8"))["curves"] if RESULTS.exists() else {}
    found = {"curves": curves, "yardsticks": yardsticks()}
    for algorithm, seed, way in product(ALGORITHMS, SEEDS, WAYS):
        key = f"{algorithm}/{way}/{seed}"
        if key not in curves:
            print(f"measuring {key}", flush=True)
            curves[key] = curve(algorithm, seed, way)
            made_by = machine("torch", "stable-baselines3", "sb3-contrib")
            keep(RESULTS, {"machine": made_by, "steps": STEPS, "task": TASK, **found})
    return found


def rewards(found: dict[str, Any], algorithm: str, way: str) -> np.ndarray:
    """Of every seed and evaluation."""
    return np.array([found["curves"][f"{algorithm}/{way}/{seed}"]["reward"] for seed in SEEDS])


def table(found: dict[str, Any]) -> str:
    yard = found["yardsticks"]
    lines = [
        "| policy | DummyVecEnv | native | largest difference of two curves of one seed |",
        "| --- | ---: | ---: | ---: |",
    ]
    for algorithm in ALGORITHMS:
        curves = {way: rewards(found, algorithm, way) for way in WAYS}
        best = [f"{np.mean(c.max(axis=1)):.4f} ± {np.std(c.max(axis=1), ddof=1):.4f}" for c in curves.values()]
        difference = np.abs(curves["native"] - curves["DummyVecEnv"]).max()
        lines.append(f"| {algorithm} | {best[0]} | {best[1]} | {difference:.0e} |")
    lines += [f"| {name} | {reward:.4f} | {reward:.4f} | |" for name, reward in yard.items()]
    return "\n".join(lines).replace("0e+00", "0")


def draw(found: dict[str, Any]) -> "Figure":
    """A panel for each algorithm: the native curves, and those over a DummyVecEnv as rings around them."""
    with optional_import():
        from matplotlib import pyplot as plt

    with house_style():
        figure, panels = plt.subplots(2, 3, figsize=(PAGE_WIDTH, 4.2), sharey=True, layout="constrained")
        for panel, algorithm in zip(panels.flat, ALGORITHMS, strict=False):
            for seed, colour in zip(SEEDS, OKABE_ITO, strict=False):
                curves = {way: found["curves"][f"{algorithm}/{way}/{seed}"] for way in WAYS}
                for way, style in {"native": "-", "DummyVecEnv": "o"}.items():
                    thousands = np.array(curves[way]["steps"]) / 1000
                    panel.plot(
                        thousands,
                        curves[way]["reward"],
                        style,
                        color=colour,
                        mfc="none",
                        ms=5,
                        label=f"{way}, seed {seed}",
                    )
            panel.axhline(OPTIMUM, lw=0.9, ls="--", color="0.3", label="the best there is")
            panel.axhline(found["yardsticks"]["random"], lw=0.9, ls=":", color="0.3", label="random commands")
            panel.set(title=algorithm, xlabel="thousand steps")
        for panel in panels[:, 0]:
            panel.set(ylabel="mean reward per step", ylim=(-0.05, 1.12))
        *_, empty = panels.flat
        empty.set_axis_off()
        empty.legend(*panels[0, 0].get_legend_handles_labels(), loc="center")
    return figure


def main() -> None:
    """Measure what is missing; then print, write and draw."""
    found = measure()
    made = table(found)
    print(made)
    refresh(PAGE, {"learning": made})
    figure = draw(found)
    save_figure(figure, *(FIGURE.with_suffix(suffix) for suffix in (".png", ".svg")))


if __name__ == "__main__":
    main()
