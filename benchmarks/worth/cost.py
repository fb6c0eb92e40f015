"""What each tolerance costs, by CPU time, in turns."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np

from stickslip.crawler import Groups, simulate
from stickslip.tasks import random_bits

from .experiments import BODIES, Work
from .settings import ALL, ENVIRONMENT_DEFAULT, name_of, SIMULATE_DEFAULT

__all__ = ["RUNS", "SIMULATE", "STEP", "STEP_WITHOUT_MEMORY", "cost"]

RUNS = ("1", "2")
_ROUNDS = 61
_HOLDS = 400
SIMULATE, STEP, STEP_WITHOUT_MEMORY = "simulate", "step", "step without memory"


class _Job(NamedTuple):
    works: dict[float, Callable[[], object]]  # by tolerance
    units: float  # that one call of a work spans


def cost() -> Work:
    """Microseconds per time unit of `simulate`, and per step of the environment, twice over."""
    for run in RUNS:
        yield f"cost/{run}", _measure


def _measure() -> dict[str, Any]:
    """Quartiles by job, body and tolerance, in microseconds and as ratios to each default in the same round."""
    return {
        job: {body: _by_tolerance(make(arguments)) for body, arguments in BODIES.items()}
        for job, make in {
            SIMULATE: _simulations,
            STEP: _episodes,
            STEP_WITHOUT_MEMORY: partial(_episodes, dither=0.0, memory_weight=0.0),
        }.items()
    }


def _simulations(body: dict[str, Any]) -> _Job:
    groups, hold = Groups.of(body["groups"]), body["hold"]
    bits = random_bits(_HOLDS, 0)
    works = {tolerance: partial(simulate, groups, bits, hold, tolerance=tolerance) for tolerance in ALL}
    return _Job(works, _HOLDS * hold)


def _episodes(body: dict[str, Any], **arguments: float) -> _Job:
    commands = random_bits(_HOLDS, 0).tolist()
    works = {tolerance: _episode(commands, **body, **arguments, tolerance=tolerance) for tolerance in ALL}
    return _Job(works, _HOLDS)


def _episode(commands: list[int], **arguments: Any) -> Callable[[], None]:
    """Steps of an environment as `gym.make` gives it; the reset is short beside them."""
    environment = gym.make("stickslip:StickSlipCrawler-v0", **arguments)

    def work() -> None:
        environment.reset(seed=0)
        for command in commands:
            environment.step(command)

    return work


def _by_tolerance(job: _Job) -> dict[str, dict[str, list[float]]]:
    seconds = dict(zip(job.works, _in_turns(job.works).T, strict=True))
    return {
        name_of(tolerance): {
            "microseconds": _quartiles(1e6 / job.units * mine),
            "times": {
                name_of(default): _quartiles(mine / seconds[default])
                for default in (SIMULATE_DEFAULT, ENVIRONMENT_DEFAULT)
            },
        }
        for tolerance, mine in seconds.items()
    }


def _in_turns(works: dict[float, Callable[[], object]]) -> np.ndarray:
    """CPU seconds, (rounds, tolerances). Every other round runs backward, so that none is always the first."""
    seconds = np.empty((_ROUNDS, len(works)))
    for work in works.values():
        work()  # compiles, fills caches
    for turn, row in enumerate(seconds):
        for column, work in list(enumerate(works.values()))[:: 1 if turn % 2 == 0 else -1]:
            start = time.thread_time()
            work()
            row[column] = time.thread_time() - start
    return seconds


def _quartiles(values: np.ndarray) -> list[float]:
    return [float(value) for value in np.quantile(values, [0.25, 0.5, 0.75])]
