"""What is kept of a training while it goes on: evaluations, checkpoints, and the best policy."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from ..common.extras import optional_import
from .evaluations import best_of, Evaluation, read_evaluations, write_evaluations
from .floor import Floor
from .hyperparameters import entropy_schedule
from .policies.files import write_policy
from .policies.from_model import policy_of
from .run import Run
from .trust import write_pickle

with optional_import():
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
    from stable_baselines3.common.vec_env import VecEnv

__all__ = ["EVALUATION_SEED", "Keeper", "keep_as_best"]

EVALUATION_SEED = 1_000_000
"""The first seed of the episodes that a training is judged by on its way."""
_EPISODES = 32


def keep_as_best(run: Run, model: BaseAlgorithm, scores: dict[str, Any]) -> None:
    """Let a model be the best policy of a run, in every form in which it is kept."""
    write_pickle(run.best, model.save)
    # A recurrent policy, or one of a network or of environments of the user's own, has no such form.
    with suppress(ValueError):
        write_policy(policy_of(model, run.configuration, scores), run.best_policy)


class Keeper(BaseCallback):
    """Evaluates the policy from time to time, and keeps it."""

    def __init__(
        self,
        run: Run,
        make: Callable[[int, int], VecEnv],
        interval: int,
        on_progress: Callable[[int], Any],
        done: int,
    ) -> None:
        super().__init__()
        self._done = done
        self._run = run
        self._interval = interval
        self._on_progress = on_progress
        self._best = -np.inf
        self._rows: list[Evaluation] = []
        self._next = 0
        # Without flips and draws one episode says all; with them it takes many, for what the readout earns is noisy.
        arguments = run.configuration.env_kwargs
        episodes = 1 if arguments.get("dither") == 0.0 and not arguments.get("randomize") else _EPISODES
        self._environments = make(episodes, EVALUATION_SEED)
        self._table = run.folder / "evaluations.csv"
        self._entropy = entropy_schedule(run.configuration.hyperparameters)

    def __enter__(self) -> "Keeper":
        if self._table.exists():
            # What was evaluated after the last checkpoint will be evaluated again.
            self._rows = [row for row in read_evaluations(self._table) if row.steps <= self._done]
            if self._rows and self._run.best.exists():
                self._best = best_of(self._rows).reward
        return self

    def __exit__(self, *_: Any) -> None:
        self._environments.close()

    def _on_training_start(self) -> None:
        self._next = self.num_timesteps + self._interval
        # Its row is the last that is written of an evaluation: where a crash came before it, some of the rest may lack.
        if self._done and self._done not in (row.steps for row in self._rows):
            self.keep()

    def _on_step(self) -> bool:
        self._on_progress(self.num_timesteps)
        return True

    def _on_rollout_end(self) -> None:
        if self._entropy is not None:
            done = self.num_timesteps / self._run.configuration.hyperparameters["n_timesteps"]
            vars(self.model)["ent_coef"] = self._entropy(max(0.0, 1.0 - done))

    def _on_rollout_start(self) -> None:
        # Here the policy is fresh from an update; it does not change within a rollout.
        if self.num_timesteps >= self._next:
            self._next = self.num_timesteps + self._interval
            self.keep()

    def keep(self) -> None:
        """Evaluate the policy, write down how it did, and save it."""
        self._environments.seed(EVALUATION_SEED)
        terms: list[tuple[float, float]] = []

        def note(inside: dict[str, Any], _: dict[str, Any]) -> None:
            terms.append(tuple(inside["info"].get(name, np.nan) for name in ("speed", "memory")))

        returns, lengths = evaluate_policy(
            self.model,
            self._environments,
            n_eval_episodes=self._environments.num_envs,
            callback=note,
            return_episode_rewards=True,
        )
        reward = float(np.sum(returns) / np.sum(lengths))
        speed, memory = np.mean(terms, axis=0).tolist()
        floor = self._run.configuration.floor
        if floor is not None:
            reward = Floor(floor).utility(speed, memory)
        evaluation = Evaluation(self.num_timesteps, reward, speed, memory)
        self.logger.record("eval/mean_reward_per_step", reward)
        self.logger.record("eval/mean_speed", evaluation.speed)
        self.logger.record("eval/mean_memory", evaluation.memory)
        self.logger.dump(self.num_timesteps)
        # In this order a crash between two of them loses none of the others' meaning.
        if isinstance(self.model, OffPolicyAlgorithm):
            write_pickle(self._run.replay_buffer, self.model.save_replay_buffer)
        write_pickle(self._run.checkpoint(self.num_timesteps), self.model.save)
        if reward > self._best:
            self._best = reward
            keep_as_best(self._run, self.model, self._scores(evaluation))
        self._rows.append(evaluation)
        write_evaluations(self._table, self._rows)

    def _scores(self, evaluation: Evaluation) -> dict[str, Any]:
        """An evaluation as a policy's file tells it; what the environments did not tell is left out."""
        seeds = range(EVALUATION_SEED, EVALUATION_SEED + self._environments.num_envs)
        means = {name: {"mean": value} for name, value in evaluation._asdict().items() if name != "steps"}
        told = {name: value for name, value in means.items() if np.isfinite(value["mean"])}
        return {"measured": "per step, in one episode a seed", "seeds": list(seeds), **told}
