"""A few numbers behind the pages that name no task: as they are kept, and as they are today, in some seconds.

They were chosen to be cheap, and to change where a threshold, an interval, a reward or an encoding does.
"""

import importlib.util
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium as gym
import memory_reward
import numpy as np
import trust

from stickslip.common.fingerprint import rounded
from stickslip.studies.benchmark import run_benchmark
from stickslip.tasks import BodyReservoir

Found = Iterator[tuple[str, Any, Any]]
"""Names, with what is kept and what is measured today."""

TRUST_CASES = (
    "power: 0.5, 10000 samples, 0.006",
    "power: 0.1, 10000 samples, 0.003",
    "memory: 4 noisy taps, 12 delays, 2000 samples",
    "information: 4 half bits, 2000 samples",
    "over runs: exponential",
)
REWARD_STEPS = 200


def of_trust(kept: Mapping[str, Any]) -> Found:
    """Counts of passes and of intervals that hold the truth, of `docs/trust.md`."""
    cases = trust.cases(1.0)
    for name in TRUST_CASES:
        yield name, _rounded(kept["cases"][name]), _rounded(json.loads(json.dumps(cases[name]())))


def _rounded(case: dict[str, Any]) -> dict[str, Any]:
    return {key: rounded(value) if isinstance(value, float) else value for key, value in case.items()}


def of_reward(kept: Mapping[str, Any]) -> Found:
    """Mean rewards of short episodes, and the capacity of a long run, of `docs/reward.md`."""
    episodes, place = kept["episodes"], kept["lengths"].index(REWARD_STEPS)
    schedule = memory_reward.SCHEDULES[0]
    for name in ("the defaults", "`dither=0.02`", "five groups drawn"):
        envs = gym.make_vec(memory_reward.NAME, episodes, max_episode_steps=None, **memory_reward.CASES[name])
        envs.reset(seed=0)
        steps = memory_reward.commands(schedule, REWARD_STEPS)
        earned = [envs.step(np.full(episodes, command))[4]["memory"] for command in steps]
        yield f"reward of {name}", rounded(kept["cases"][name]["earned"][0][place]), rounded(float(np.mean(earned)))
    settings = gym.make(memory_reward.NAME).unwrapped.settings
    capacity = memory_reward.capacity(settings, settings.groups, schedule, memory_reward.LONG + 10_000)
    yield "capacity of the defaults", rounded(kept["cases"]["the defaults"]["truth"][0]), rounded(capacity)


def of_encodings(kept: Mapping[str, Any]) -> Found:
    """Loss and scores of one seed, of `docs/encodings.md`.

    Mackey-Glass is left out: after so many times the chaos has made of it another series on another computer.
    """
    encodings = _encodings()
    tasks = {name: task for name, task in encodings.CHOSEN.items() if not name.startswith("Mackey-Glass")}
    for row in kept["rows"][: len(encodings.CASES) : 3]:
        encoding, holds = row["encoding"], row["holds"]
        body = BodyReservoir(hold=encodings.SAMPLE_TIME / holds, encoding=encoding, holds_per_sample=holds)
        scores = run_benchmark(
            tasks=tasks, reservoirs={"body": body}, seeds=encodings.SEEDS[:1], length=encodings.LENGTH
        )
        name = f"{encoding} {holds}"
        yield f"loss of {name}", rounded(row["loss"]), rounded(encodings.loss(encoding, holds))
        for score in scores:
            yield f"{score.task} of {name}", rounded(row[score.task][0]), rounded(score.score)


def _encodings() -> ModuleType:
    """The script, whose name is one of Python's own."""
    found = importlib.util.spec_from_file_location("benchmark_of_encodings", Path(__file__).with_name("encodings.py"))
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module
