"""Policies trained at each tolerance, and what they are worth in a world without error.

Imports torch; the other experiments do not need it.
"""

import time
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from stickslip.common.extras import optional_import
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.run import Configuration
from stickslip.train.training import load_policy, train

from .experiments import Work
from .settings import name_of

with optional_import():
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.evaluation import evaluate_policy

__all__ = ["JUDGE", "LESSONS", "TRAINED_AT", "TRAINING_SEEDS", "trained_policies"]

TRAINED_AT = (1e-2, 1e-3, 1e-6, 1e-9)
TRAINING_SEEDS = range(3)
JUDGE = 1e-12
# The speed task without flips, where one episode says all, and a trade that pays best for holding the valve open.
LESSONS: dict[str, dict[str, Any]] = {
    "speed": {"memory_weight": 0.0, "dither": 0.0},
    "trade": {"memory_weight": 0.5},
}
EPISODES = {"speed": 1, "trade": 10}
_EPISODE_SEED = 2_000_000  # apart from those of the periodic evaluations that chose the best policy


def trained_policies() -> Work:
    """Reward per step of the best policy of a training: where it was trained, and where it is judged."""
    for seed, lesson, tolerance in product(TRAINING_SEEDS, LESSONS, TRAINED_AT):
        yield f"trained/{lesson}/{name_of(tolerance)}/{seed}", partial(_learn, lesson, tolerance, seed)


def _learn(lesson: str, tolerance: float, seed: int) -> dict[str, float]:
    configuration = Configuration(
        env_kwargs={**LESSONS[lesson], "tolerance": tolerance},
        hyperparameters=read_hyperparameters("ppo", Configuration.environment),
        seed=seed,
    )
    start = time.process_time()
    with TemporaryDirectory(prefix="accuracy_worth_") as folder:
        policy = load_policy(train(configuration, Path(folder)), trust=True)
    seconds = time.process_time() - start
    return {
        "judged": _reward_per_step(policy, lesson, {**configuration.env_kwargs, "tolerance": JUDGE}),
        "as trained": _reward_per_step(policy, lesson, configuration.env_kwargs),
        "seconds": seconds,
    }


def _reward_per_step(policy: BaseAlgorithm, lesson: str, env_kwargs: dict[str, Any]) -> float:
    environments = make_vec_env(
        Configuration.environment,
        n_envs=EPISODES[lesson],
        seed=_EPISODE_SEED,
        env_kwargs=env_kwargs,
    )
    returns, lengths = evaluate_policy(
        policy, environments, n_eval_episodes=EPISODES[lesson], return_episode_rewards=True
    )
    environments.close()
    return float(np.sum(returns) / np.sum(lengths))
