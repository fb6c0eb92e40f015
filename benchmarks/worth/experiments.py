"""The experiments: each is a stream of keys and of what is to be measured under them.

A key names the experiment first and the tolerance in it. What is measured is plain data, ready for JSON. Everything
but the tolerance, the random bits and flips above all, is the same at every tolerance.
"""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.crawler import Groups, Scene, simulate
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.reservoir import memory_capacity
from stickslip.studies.benchmark import run_benchmark
from stickslip.tasks import body_states, crawler_states, random_bits

from .settings import ALL, name_of, REFERENCE, TOLERANCES

__all__ = ["BODIES", "CHAOTIC", "POLICIES", "RANDOM", "SEEDS", "TASKS", "WORDS"]
__all__ += ["Work", "chaos", "crawling", "fixed_policies", "tasks"]

Work = Iterator[tuple[str, Callable[[], Any]]]
Values = dict[str, list[float]]

SEEDS = range(20)

# The default crawler, whose steps are mostly cut short by the hold and so more accurate than asked for; and one chosen
# to suffer from a loose tolerance: hard spring, hardly damped, ten times the hold.
BODIES: dict[str, dict[str, Any]] = {
    "default": {"groups": None, "hold": 0.5},
    "lively": {"groups": {"duffing": 20.0, "damping_ratio": 0.005}, "hold": 5.0},
}

TASKS = ("memory capacity", "NARMA-2 NRMSE", "NARMA-10 NRMSE", "parity-2 capacity")

WORDS = ("11100", "11110000")
RANDOM = "random bits"
LONG, SHORT = 20_000, 4_000  # holds: of a word, and of each stream of random bits

EPISODE = 1000
POLICIES: dict[str, Callable[[NDArray[np.float32], int], int]] = {
    "open while short": lambda observation, step: int(observation[0] < 0.3),
    "the word 11100": lambda observation, step: int(step % 5 < 3),
}

# Anchored and hardly damped, the body is chaotic under random bits: its largest exponent is about 0.01 to 0.1.
CHAOTIC = (2, 20, 200)  # duffing
CHAOS_SEEDS = range(40)
CHAOS_HOLD, CHAOS_NODES, CHAOS_DELAYS = 0.5, 4, 20
CHAOS_WASHOUT, CHAOS_HOLDS = 6_000, 20_000  # by the washout's end all but the nearest tolerances have parted
PARTED = 0.1  # distance, in standard deviations of the deformation


def tasks() -> Work:
    """Scores of the benchmark's tasks, by seed."""
    for body, tolerance in product(BODIES, ALL):
        yield f"tasks/{body}/{name_of(tolerance)}", partial(_scores, body, tolerance)


def _scores(body: str, tolerance: float) -> Values:
    crawler = partial(crawler_states, **BODIES[body], tolerance=tolerance)
    scores = run_benchmark(tasks=TASKS, reservoirs={"crawler": lambda bits, _: crawler(bits)}, seeds=SEEDS)
    return {task: [score.score for score in scores if score.task == task] for task in TASKS}


def crawling() -> Work:
    """Speed and slips of words, and of random bits by seed."""
    for body, tolerance in product(BODIES, ALL):
        yield f"crawling/{body}/{name_of(tolerance)}", partial(_crawl, body, tolerance)


def _crawl(body: str, tolerance: float) -> dict[str, Values]:
    groups, hold = Groups.of(BODIES[body]["groups"]), BODIES[body]["hold"]
    schedules = {word: np.resize([int(letter) for letter in word], (1, LONG)) for word in WORDS}
    schedules[RANDOM] = np.array([random_bits(SHORT, seed) for seed in SEEDS])
    result = {}
    for name, valve in schedules.items():
        motion = simulate(groups, valve, hold, tolerance=tolerance)
        speed = motion.foot[:, -1] / (valve.shape[1] * hold)
        result[name] = {"speed": speed.tolist(), "slips": motion.slips.tolist()}
    return result


def fixed_policies() -> Work:
    """Return, slips and commands of policies that are the same at every tolerance, by seed of the flips."""
    for body, tolerance in product(BODIES, ALL):
        yield f"fixed policy/{body}/{name_of(tolerance)}", partial(_follow, body, tolerance)


def _follow(body: str, tolerance: float) -> dict[str, dict[str, list[Any]]]:
    environment = StickSlipCrawlerEnv(**BODIES[body], tolerance=tolerance)
    return {name: _episodes(environment, policy) for name, policy in POLICIES.items()}


def _episodes(
    environment: StickSlipCrawlerEnv, policy: Callable[[NDArray[np.float32], int], int]
) -> dict[str, list[Any]]:
    record: dict[str, list[Any]] = {"return": [], "slips": [], "commands": []}
    for seed in SEEDS:
        observation, _ = environment.reset(seed=seed)
        rewards, commands = [], []
        for step in range(EPISODE):
            commands.append(policy(observation, step))
            observation, reward, _, _, info = environment.step(commands[-1])
            rewards.append(reward)
        record["return"].append(float(np.sum(rewards)))
        record["slips"].append(info["slips"])
        record["commands"].append(np.packbits(commands).tobytes().hex())  # the file would be four times as long
    return record


def chaos() -> Work:
    """Statistics of chaotic motion by seed, and when it parts from the reference."""
    for duffing, tolerance in product(CHAOTIC, ALL):
        yield f"chaos/{duffing}/{name_of(tolerance)}", partial(_statistics, duffing, tolerance)


def _statistics(duffing: float, tolerance: float) -> Values:
    groups, scene = Groups(damping_ratio=0.02, duffing=duffing), Scene(anchored=True)
    record: Values = {"mean": [], "variance": [], "memory capacity": [], "parted": []}
    for seed in CHAOS_SEEDS:
        bits = random_bits(CHAOS_HOLDS, seed)
        run = partial(simulate, groups, bits, CHAOS_HOLD, scene=scene, samples_per_hold=CHAOS_NODES)
        motion = run(tolerance=tolerance)
        settled = motion.deformation[CHAOS_WASHOUT * CHAOS_NODES :]
        memory = memory_capacity(body_states(motion), bits, CHAOS_DELAYS, washout=CHAOS_WASHOUT)
        record["mean"].append(float(settled.mean()))
        record["variance"].append(float(settled.var()))
        record["memory capacity"].append(memory.corrected)
        if tolerance in TOLERANCES:
            reference = run(tolerance=REFERENCE).deformation
            record["parted"].append(_parting(motion.time, motion.deformation - reference, reference.std()))
    return record


def _parting(time: NDArray[np.float64], difference: NDArray[np.float64], scale: float) -> float:
    """When two motions are first apart, or the end of the run if they never are."""
    apart = np.abs(difference) > PARTED * scale
    return float(time[np.argmax(apart)] if apart.any() else time[-1])
