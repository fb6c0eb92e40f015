"""Training a policy with Stable-Baselines3."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecEnv

from .hyperparameters import resolve
from .run import atomically, Configuration, Run

__all__ = ["load_policy", "train"]

_ALGORITHMS: dict[str, type[BaseAlgorithm]] = {"ppo": PPO}
_EVALUATIONS = 12
_EVALUATION_SEED = 1_000_000
# Networks this small run fastest on one thread; two would fight the environments for the cores.
_TORCH_THREADS = 1


def train(
    configuration: Configuration,
    folder: Path,
    *,
    resume: bool = False,
    on_progress: Callable[[int], Any] = lambda steps: None,
) -> Run:
    """Train a policy, with periodic evaluation, checkpoints and TensorBoard logs.

    Parameters
    ----------
    configuration : Configuration
    folder : Path
        Where the run is kept.
    resume : bool
        Go on from the last checkpoint in `folder`. The steps after it are done again, with new random numbers.
    on_progress : callable
        Told the number of environment steps done, every so often.

    Returns
    -------
    Run

    Raises
    ------
    ValueError, TypeError
        If an argument of the environment or the algorithm is wrong, if `folder` holds a run and `resume` is not set,
        or if it is set and the run has another configuration.
    OSError
        If the folder cannot be written.
    """
    total = configuration.hyperparameters["n_timesteps"]
    arguments = resolve(
        {
            name: value
            for name, value in configuration.hyperparameters.items()
            if name not in ("n_envs", "n_timesteps", "policy")
        }
    )
    # A wrong argument of the environment is found before the folder is touched.
    environments = _environments(configuration, configuration.hyperparameters["n_envs"], configuration.seed)
    try:
        checkpoint = None
        if resume:
            run = Run.open(folder)
            differences = configuration.differences(run.configuration)
            if differences:
                raise ValueError(f"run {folder} has another configuration: {', '.join(differences)}")
            checkpoint = run.latest_checkpoint()
        with _torch_threads(_TORCH_THREADS):
            algorithm = _ALGORITHMS[configuration.algorithm]
            if checkpoint is None:
                model = algorithm(
                    configuration.hyperparameters["policy"],
                    environments,
                    seed=configuration.seed,
                    device="cpu",
                    **arguments,
                )
                if not resume:
                    run = Run.create(folder, configuration)
            else:
                model = algorithm.load(checkpoint, env=environments, device="cpu")
            model.tensorboard_log = str(folder / "tensorboard")
            remaining = total - model.num_timesteps
            if remaining > 0:
                with _Keeper(run, max(1, total // _EVALUATIONS), on_progress) as keeper:
                    model.learn(
                        remaining,
                        callback=keeper,
                        reset_num_timesteps=checkpoint is None,
                        tb_log_name=configuration.algorithm,
                    )
                    keeper.keep()
            atomically(run.final, model.save)
    finally:
        environments.close()
    return run


def load_policy(run: Run, file: Path | None = None) -> BaseAlgorithm:
    """The policy of a run.

    Parameters
    ----------
    run : Run
    file : Path, optional
        One of its checkpoints; the best policy by default.

    Returns
    -------
    BaseAlgorithm

    Raises
    ------
    ValueError
        If the file is missing or is not a checkpoint of such a configuration.
    """
    file = run.best if file is None else file
    if not file.is_file():
        raise ValueError(f"checkpoint must be a file, got {file}")
    try:
        model = _ALGORITHMS[run.configuration.algorithm].load(file, device="cpu")
    except Exception as error:  # SB3 raises whatever zipfile, pickle or torch do
        raise ValueError(f"checkpoint {file} is not one of {run.configuration.algorithm}: {error}") from None
    environment = gym.make(run.configuration.environment, **run.configuration.env_kwargs)
    spaces = (environment.observation_space, environment.action_space)
    if (model.observation_space, model.action_space) != spaces:
        raise ValueError(
            f"checkpoint {file} is of another configuration: it observes {model.observation_space} and acts in "
            f"{model.action_space}, {run.folder} has {spaces[0]} and {spaces[1]}"
        )
    return model


class _Keeper(BaseCallback):
    """Evaluates the policy from time to time, and keeps it."""

    def __init__(self, run: Run, interval: int, on_progress: Callable[[int], Any]) -> None:
        super().__init__()
        self._run = run
        self._interval = interval
        self._on_progress = on_progress
        self._best = -np.inf
        self._rows: list[str] = []
        self._next = 0
        # Without flips one episode says all; with them it takes several.
        episodes = 8 if run.configuration.env_kwargs.get("dither", None) != 0.0 else 1
        self._environments = _environments(run.configuration, episodes, _EVALUATION_SEED)
        self._table = run.folder / "evaluations.csv"

    def __enter__(self) -> "_Keeper":
        if self._table.exists():
            _, *self._rows = self._table.read_text().splitlines()
            self._best = max((float(row.split(",")[1]) for row in self._rows), default=-np.inf)
        return self

    def __exit__(self, *_: Any) -> None:
        self._environments.close()

    def _on_training_start(self) -> None:
        self._next = self.num_timesteps + self._interval

    def _on_step(self) -> bool:
        self._on_progress(self.num_timesteps)
        return True

    def _on_rollout_start(self) -> None:
        # Here the policy is fresh from an update; it does not change within a rollout.
        if self.num_timesteps >= self._next:
            self._next = self.num_timesteps + self._interval
            self.keep()

    def keep(self) -> None:
        """Evaluate the policy, write down how it did, and save it."""
        self._environments.seed(_EVALUATION_SEED)
        returns, lengths = evaluate_policy(
            self.model, self._environments, n_eval_episodes=self._environments.num_envs, return_episode_rewards=True
        )
        reward = float(np.sum(returns) / np.sum(lengths))
        self.logger.record("eval/mean_reward_per_step", reward)
        self.logger.dump(self.num_timesteps)
        self._rows.append(f"{self.num_timesteps},{reward!r}")
        text = "\n".join(["steps,mean_reward_per_step", *self._rows]) + "\n"
        atomically(self._table, lambda path: path.write_text(text))
        atomically(self._run.checkpoint(self.num_timesteps), self.model.save)
        if reward > self._best:
            self._best = reward
            atomically(self._run.best, self.model.save)


def _environments(configuration: Configuration, count: int, seed: int) -> VecEnv:
    return make_vec_env(configuration.environment, n_envs=count, seed=seed, env_kwargs=configuration.env_kwargs)


@contextmanager
def _torch_threads(count: int) -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(count)
    try:
        yield
    finally:
        torch.set_num_threads(before)
