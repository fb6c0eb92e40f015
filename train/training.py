"""Training a policy with Stable-Baselines3."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..common.extras import optional_import
from ..common.fingerprint import described, refuse_other
from ..common.threads import library_threads
from ..envs import StickSlipCrawlerEnv
from . import verdict
from .algorithms import algorithm_class
from .begun import begin_from, Teacher
from .evaluation import Acting
from .evaluations import best_of, Evaluation, read_evaluations, write_evaluations
from .floor import Floor, FloorVecEnv
from .hyperparameters import entropy_schedule, resolve
from .long_runs import of_policy, of_words
from .policies.files import read_policy, WEIGHTS, write_policy
from .policies.from_model import policy_of
from .probe import first_rewards
from .run import Configuration, EVEN, FROM_POLICY, Run
from .still import begin_still, hold_still
from .trust import read_pickle, write_pickle
from .vec_env import StickSlipVecEnv
from .verdict import Judging

with optional_import():
    import tensorboard  # noqa: F401  (Stable-Baselines3 logs by it)
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
    from stable_baselines3.common.vec_env import VecEnv, VecMonitor

__all__ = ["load_policy", "train"]

_CONFIGURATION = "stickslip_configuration"
_REWARDS = "stickslip_first_rewards"
_EVALUATIONS = 12
_EPISODES = 32
_EVALUATION_SEED = 1_000_000


def train(
    configuration: Configuration,
    folder: Path,
    *,
    resume: bool = False,
    trust: bool = False,
    on_progress: Callable[[int], Any] = lambda steps: None,
    vec_env: Callable[..., VecEnv] | None = None,
    judging: Judging | None = None,
    or_still: bool = True,
    begin: Teacher | None = None,
) -> Run:
    """Train a policy, with periodic evaluation, checkpoints and TensorBoard logs, and judge it.

    The best policy of the evaluations is kept, and compared, on fresh seeds over long runs, with the valve held open,
    held shut and the best word: ``report.json`` and ``report.md`` say what came of it, and that the training failed
    where one of these has more reward. Where the configuration has a floor on speed, no reward decides, and nothing is
    judged.

    Parameters
    ----------
    configuration : Configuration
    folder : Path
        Where the run is kept.
    resume : bool
        Go on from the last checkpoint in `folder`. The steps after it are done again, with new random numbers. A
        configuration with another ``n_timesteps`` moves the end of the run: schedules then go over the new total.
    trust : bool
        Whether to resume what this user did not write on this machine: its checkpoints are unpickled, and run what
        their writer likes.
    on_progress : callable
        Told the number of environment steps done, every so often.
    vec_env : callable
        Makes the environments, for the training and for its evaluations, from their number and
        `configuration.env_kwargs`; a `StickSlipVecEnv` by default. Speed and memory stand in ``evaluations.csv`` where
        its infos tell them at every step. Where they show anything else than the environment does, the policy is not
        judged.
    judging : Judging, optional
        How the best policy is judged at the end; `stickslip.train.verdict.STANDARD` by default.
    or_still : bool
        Whether a policy that holds the valve open or shut is kept instead of the best, where it earns more on the seeds
        of the evaluations over runs as long.
    begin : callable, optional
        Where a configuration's `start` is "policy", what its network learns to do before it is paid: see
        `stickslip.train.begun.begin_from`.

    Returns
    -------
    Run

    Raises
    ------
    ValueError, TypeError
        If an argument of the environment or the algorithm is wrong, if `folder` holds a run and `resume` is not set,
        or if it is set and the run has another configuration, has done more steps than asked for, or is another's and
        not trusted.
    OSError
        If the folder cannot be written.
    """
    judging = verdict.STANDARD if judging is None else judging
    if not resume and (begin is not None) != (configuration.start == FROM_POLICY):
        raise ValueError(f"begin must be a policy where start is {FROM_POLICY!r}, and there alone")
    total = configuration.hyperparameters["n_timesteps"]
    arguments = resolve(
        {
            name: value
            for name, value in configuration.hyperparameters.items()
            if name not in ("n_envs", "n_timesteps", "policy")
        }
    )
    # What the environment or the algorithm refuses, it refuses before the folder is touched.
    rewards = first_rewards(configuration.env_kwargs)

    def make(count: int, seed: int, constructor: Callable[..., VecEnv]) -> VecEnv:
        environments = VecMonitor(constructor(count, **configuration.env_kwargs))
        environments.seed(seed)
        return environments

    if vec_env is not None:
        constructor: Callable[..., VecEnv] = vec_env
    elif configuration.floor is None:
        constructor = partial(StickSlipVecEnv, sparse_infos=True)
    else:
        constructor = partial(FloorVecEnv, floor=Floor(configuration.floor), sparse_infos=True)
    environments = make(configuration.hyperparameters["n_envs"], configuration.seed, constructor)
    try:
        checkpoint = None
        if resume:
            run = Run.open(folder)
            moved = total != run.configuration.hyperparameters.get("n_timesteps")
            refuse_other(f"to go on with run {folder}", _kept(run.configuration, total), _described(configuration))
            checkpoint = run.latest_checkpoint()
        with library_threads(1):
            if checkpoint is None:
                model = algorithm_class(configuration.algorithm)(
                    configuration.hyperparameters["policy"],
                    environments,
                    seed=configuration.seed,
                    device="cpu",
                    **arguments,
                )
                if begin is not None:
                    begin_from(model, begin, configuration.env_kwargs, seed=configuration.seed)
                elif configuration.start != EVEN:
                    begin_still(model, int(configuration.start == "open"))
                vars(model)[_CONFIGURATION] = asdict(configuration)  # SB3 saves every attribute
                vars(model)[_REWARDS] = rewards
                if not resume:
                    run = Run.create(folder, configuration)
            else:
                model = _load(
                    configuration, checkpoint, read_pickle(checkpoint, trust=trust, own=True), env=environments
                )
                refuse_other(
                    f"to go on with run {folder}, whose environment or reward was another",
                    {"first rewards": vars(model).get(_REWARDS)},
                    {"first rewards": rewards},
                )
                if moved and total < model.num_timesteps:
                    raise ValueError(
                        f"n_timesteps must be at least {model.num_timesteps}, which run {folder} has done, got {total}"
                    )
                vars(model)[_CONFIGURATION] = asdict(configuration)
                if isinstance(model, OffPolicyAlgorithm) and run.replay_buffer.exists():
                    model.load_replay_buffer(read_pickle(run.replay_buffer, trust=trust, own=True))
            if resume and moved:
                run.configure(configuration)
            model.tensorboard_log = str(folder / "tensorboard")
            remaining = total - model.num_timesteps
            if remaining > 0:
                evaluating = partial(make, constructor=StickSlipVecEnv if vec_env is None else vec_env)
                interval = max(1, total // _EVALUATIONS)
                with _Keeper(run, evaluating, interval, on_progress, model.num_timesteps) as keeper:
                    model.learn(
                        remaining,
                        callback=keeper,
                        reset_num_timesteps=checkpoint is None,
                        tb_log_name=configuration.algorithm,
                    )
                    keeper.keep()
            write_pickle(run.final, model.save)
            if configuration.floor is None and (remaining > 0 or not (folder / verdict.REPORT).exists()):
                _judge(run, model, judging, or_still=or_still, trust=trust)
    finally:
        environments.close()
    return run


def load_policy(run: Run, file: Path | None = None, *, trust: bool = False) -> BaseAlgorithm:
    """A model of a run, from a zip of Stable-Baselines3's; `read_policy` reads the best one without running its code.

    Parameters
    ----------
    run : Run
    file : Path, optional
        One of its checkpoints; the best policy by default.
    trust : bool
        Whether to read it at all: it is unpickled, and runs what its writer likes.

    Returns
    -------
    BaseAlgorithm

    Raises
    ------
    ValueError
        If the file is missing, is not trusted or is not a checkpoint of such a configuration.
    """
    file = run.best if file is None else file
    if not file.is_file():
        raise ValueError(f"checkpoint must be a file, got {file}")
    return _load(run.configuration, file, read_pickle(file, trust=trust))


def _best_of_own(run: Run, trust: bool) -> "Acting | None":
    """The best policy of a run, of plain numbers if it has such a form; None if it sees something else than is shown.

    What is plain may be read whoever wrote it; a zip must be this user's, or trusted.
    """
    if run.best_policy.with_name(run.best_policy.name + WEIGHTS).exists():
        return read_policy(run.best_policy)
    model = _load(run.configuration, run.best, read_pickle(run.best, trust=trust, own=True))
    shown = StickSlipCrawlerEnv(**run.configuration.env_kwargs).observation_space
    return model if model.observation_space == shown else None


def _keep_still_if_better(run: Run, policy: Acting, model: BaseAlgorithm, judging: Judging) -> bool:
    """Let the best policy of a run be the valve held still, where that earns more on the seeds of the evaluations.

    The model, of which nothing else is needed any more, becomes that policy.

    Returns
    -------
    bool
        Whether the valve is held still now.
    """
    arguments = run.configuration.env_kwargs
    seeds = range(_EVALUATION_SEED, _EVALUATION_SEED + judging.seeds)
    length: dict[str, Any] = {"seeds": seeds, "steps": judging.steps, "burn_in": judging.burn_in}
    own = of_policy(policy, arguments, **length).reward.mean()
    still = of_words(["0", "1"], arguments, **length)
    best = int(still[1].reward.mean() > still[0].reward.mean())
    if still[best].reward.mean() <= own:
        return False
    hold_still(model, best)
    means = {name: {"mean": float(each.mean())} for name, each in still[best]._asdict().items()}
    measured = "per step, in one long run a seed, once under way"
    _keep_as_best(run, model, {"measured": measured, "seeds": list(seeds), **means})
    return True


def _keep_as_best(run: Run, model: BaseAlgorithm, scores: dict[str, Any]) -> None:
    """Let a model be the best policy of a run, in every form in which it is kept."""
    write_pickle(run.best, model.save)
    # A recurrent policy, or one of a network or of environments of the user's own, has no such form.
    with suppress(ValueError):
        write_policy(policy_of(model, run.configuration, scores), run.best_policy)


def _judge(run: Run, model: BaseAlgorithm, judging: Judging, *, or_still: bool, trust: bool) -> None:
    """Write down what the best policy of a run came to beside what needs no training."""
    policy = _best_of_own(run, trust)
    if policy is not None and or_still and _keep_still_if_better(run, policy, model, judging):
        policy = _best_of_own(run, trust)
    if policy is not None:
        verdict.write_verdict(verdict.judge(policy, run.configuration.env_kwargs, judging), run.folder)


def _load(configuration: Configuration, file: Path, content: BytesIO, env: VecEnv | None = None) -> BaseAlgorithm:
    """A model from a file's content, if it was trained in the environment that the configuration names."""
    try:
        model = algorithm_class(configuration.algorithm).load(content, env=env, device="cpu")
        trained_as = Configuration(**vars(model)[_CONFIGURATION])
    except Exception as error:  # SB3 raises whatever zipfile, pickle or torch do
        reason = " ".join(str(error).split())[:200]
        raise ValueError(f"checkpoint {file} is not one of {configuration.algorithm}: {reason}") from None
    # Other seeds and hyperparameters may be compared in one environment; another environment is another task.
    same_training = replace(trained_as, seed=configuration.seed, hyperparameters=configuration.hyperparameters)
    refuse_other(f"as in checkpoint {file}", _described(same_training), _described(configuration))
    return model


def _described(configuration: Configuration) -> dict[str, Any]:
    return {name: described(value) for name, value in asdict(configuration).items()}


def _kept(configuration: Configuration, total: int) -> dict[str, Any]:
    """Description of the configuration of a run whose end may be moved."""
    kept = replace(configuration, hyperparameters={**configuration.hyperparameters, "n_timesteps": total})
    return _described(kept)


class _Keeper(BaseCallback):
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
        self._environments = make(episodes, _EVALUATION_SEED)
        self._table = run.folder / "evaluations.csv"
        self._entropy = entropy_schedule(run.configuration.hyperparameters)

    def __enter__(self) -> "_Keeper":
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
        self._environments.seed(_EVALUATION_SEED)
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
            _keep_as_best(self._run, self.model, self._scores(evaluation))
        self._rows.append(evaluation)
        write_evaluations(self._table, self._rows)

    def _scores(self, evaluation: Evaluation) -> dict[str, Any]:
        """An evaluation as a policy's file tells it; what the environments did not tell is left out."""
        seeds = range(_EVALUATION_SEED, _EVALUATION_SEED + self._environments.num_envs)
        means = {name: {"mean": value} for name, value in evaluation._asdict().items() if name != "steps"}
        told = {name: value for name, value in means.items() if np.isfinite(value["mean"])}
        return {"measured": "per step, in one episode a seed", "seeds": list(seeds), **told}
