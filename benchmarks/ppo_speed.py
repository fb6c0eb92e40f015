"""PPO end to end: frames per second over a DummyVecEnv of single environments and over the native batch.

Run ``python benchmarks/ppo_speed.py``. A frame is one step of one environment, acted on and learned from. In one round
every way collects a rollout of 16,384 frames and learns from it: the size of the rollout, of the minibatches and of the
networks is the same for all, and so is the number of gradient steps a frame. Only n_envs differs, and n_steps with it.
Then the environments by themselves, with infos in every step and at the ends of episodes only. All take turns, and a
ratio is that of neighbours in time. Every measurement is kept in ``benchmarks/results/ppo_speed.json`` as it ends, and
a run that was stopped goes on where it stopped; the tables of ``docs/training.md`` are written between their marks.
About 5 minutes of one core.
"""

import json
import os
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

# BLAS reads it as it is imported. What torch may use is set below, where more is measured too.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import gymnasium as gym
import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns

from stickslip.common.extras import optional_import
from stickslip.train import library_threads, StickSlipVecEnv

with optional_import():
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecMonitor

BENCHMARKS = Path(__file__).parent
RESULTS = BENCHMARKS / "results" / "ppo_speed.json"
PAGE = BENCHMARKS.parent / "docs" / "training.md"

ROLLOUT, BATCH, NETWORK = 16_384, 4_096, [64, 64]
ROUNDS = 5
TASKS: dict[str, dict[str, float]] = {"speed": {"memory_weight": 0.0, "dither": 0.0}, "trade": {}}
# Epochs of four minibatches: four are CleanRL's, ten the package's own.
LEARNING = (("speed", 4), ("trade", 4), ("trade", 10))
SIZES = (64, 256, 1024, 4096)
DUMMY, TWO_THREADS = "DummyVecEnv, n = 64", "native, n = 1024, torch on 2 threads"
STEPS = 32  # of a batch in one timing


def dummy(count: int, arguments: dict[str, float]) -> VecEnv:
    return DummyVecEnv([lambda: gym.make("stickslip:StickSlipCrawler-v0", **arguments) for _ in range(count)])


class Learner:
    """PPO over some environments, a rollout and its gradient steps a call."""

    def __init__(self, environments: VecEnv, epochs: int, threads: int = 1) -> None:
        self.threads = threads
        self.updating = 0.0
        self.model = PPO(
            "MlpPolicy",
            VecMonitor(environments),
            n_steps=ROLLOUT // environments.num_envs,
            batch_size=BATCH,
            n_epochs=epochs,
            policy_kwargs={"net_arch": NETWORK},
            seed=0,
            device="cpu",
        )
        self.update = self.model.train
        self.model.train = self._timed_update

    def _timed_update(self) -> None:
        wall, process = time.perf_counter(), time.process_time()
        self.update()
        self.updating += min(time.perf_counter() - wall, time.process_time() - process)

    def __call__(self) -> None:
        """Collect a rollout and learn from it."""
        with library_threads(self.threads):
            self.model.learn(ROLLOUT, reset_num_timesteps=False)


def learning(task: str, epochs: int) -> dict[str, Any]:
    """Quartiles of each way's frames a second and of their ratio to the first, and its share of gradient steps."""
    arguments = TASKS[task]
    ways = {DUMMY: Learner(dummy(64, arguments), epochs)}
    for count in SIZES:
        ways[f"native, n = {count}"] = Learner(StickSlipVecEnv(count, sparse_infos=True, **arguments), epochs)
    if (task, epochs) == LEARNING[0]:
        ways[TWO_THREADS] = Learner(StickSlipVecEnv(1024, sparse_infos=True, **arguments), epochs, threads=2)
    for learner in ways.values():
        learner()  # compiles, fills caches
        learner.updating = 0.0
    seconds = take_turns(ways, ROUNDS)
    found = rates(seconds, dict.fromkeys(ways, ROLLOUT))
    for name, learner in ways.items():
        learner.model.env.close()
        # `take_turns` calls each once more, to see how long it takes.
        calls = len(seconds[name]) + 1
        found[name]["gradient steps"] = learner.updating / calls / float(np.mean(list(seconds[name].values())))
    return found


def stepping(task: str) -> dict[str, Any]:
    """Quartiles of environment steps a second, without a policy."""
    arguments = TASKS[task]
    environments: dict[str, tuple[VecEnv, int]] = {DUMMY: (dummy(64, arguments), 64)}
    for count in SIZES:
        environments[f"native, n = {count}"] = StickSlipVecEnv(count, **arguments), count
        environments[f"native, n = {count}, sparse infos"] = (
            StickSlipVecEnv(count, sparse_infos=True, **arguments),
            count,
        )
    works = {name: stepper(environment) for name, (environment, _) in environments.items()}
    for work in works.values():
        work()
    found = rates(take_turns(works, 3 * ROUNDS), {name: STEPS * count for name, (_, count) in environments.items()})
    for environment, _ in environments.values():
        environment.close()
    return found


def stepper(environment: VecEnv) -> Callable[[], None]:
    actions = np.random.default_rng(0).integers(0, 2, (STEPS, environment.num_envs))
    environment.seed(0)
    environment.reset()

    def work() -> None:
        for row in actions:
            environment.step(row)

    return work


def rates(seconds: Mapping[str, Mapping[int, float]], frames: Mapping[str, int]) -> dict[str, Any]:
    """Frames a second, and as a multiple of the first way's in the same round."""
    first = next(iter(seconds))
    found = {}
    for name, by_round in seconds.items():
        rate = {turn: frames[name] / spent for turn, spent in by_round.items()}
        times = [rate[turn] * seconds[first][turn] / frames[first] for turn in rate if turn in seconds[first]]
        found[name] = {"frames per second": quartiles(list(rate.values())), "times": quartiles(times)}
    return found


def tables(results: Mapping[str, Any]) -> dict[str, str]:
    rows = ["| task | epochs | environments | frames a second | times DummyVecEnv | of which gradient steps |"]
    rows.append("| --- | ---: | --- | ---: | ---: | ---: |")
    for key, found in results["learning"].items():
        task, epochs = key.split("/")
        for name, row in found.items():
            low, middle, high = row["times"]
            rows.append(
                f"| {task} | {epochs} | {name} | {row['frames per second'][1]:,.0f} "
                f"| {middle:.2f} [{low:.2f}, {high:.2f}] | {row['gradient steps']:.0%} |"
            )
    steps = ["| task | environments | steps a second | times DummyVecEnv |", "| --- | --- | ---: | ---: |"]
    for task, found in results["stepping"].items():
        for name, row in found.items():
            low, middle, high = row["times"]
            rate = row["frames per second"][1]
            steps.append(f"| {task} | {name} | {rate:,.0f} | {middle:.2f} [{low:.2f}, {high:.2f}] |")
    return {"ppo": "\n".join(rows), "stepping": "\n".join(steps)}


def measure() -> dict[str, Any]:
    """All results, each kept on disk as it came."""
    found: dict[str, Any] = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    works: dict[tuple[str, str], Callable[[], dict[str, Any]]] = {
        **{("learning", f"{task}/{epochs}"): partial(learning, task, epochs) for task, epochs in LEARNING},
        **{("stepping", task): partial(stepping, task) for task in TASKS},
    }
    for (kind, key), work in works.items():
        if key not in found.setdefault(kind, {}):
            print(f"{kind}, {key}", flush=True)
            found[kind][key] = work()
            found["machine"] = machine("torch", "stable-baselines3")
            found["settings"] = {"rollout": ROLLOUT, "batch_size": BATCH, "net_arch": NETWORK, "rounds": ROUNDS}
            keep(RESULTS, found)
    return found


def main() -> None:
    """Measure what is missing; then print it and write the page."""
    made = tables(measure())
    for table in made.values():
        print(f"\n{table}")
    refresh(PAGE, made)


if __name__ == "__main__":
    main()
