"""Training a policy with Stable-Baselines3."""

from collections.abc import Callable
from dataclasses import asdict, replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

from ..common.extras import optional_import
from ..common.fingerprint import described, refuse_other
from ..common.threads import library_threads
from ..envs import StickSlipCrawlerEnv
from . import verdict
from .algorithms import algorithm_class
from .begun import begin_from, Teacher
from .evaluation import Acting
from .floor import Floor, FloorVecEnv
from .hyperparameters import resolve
from .keeper import EVALUATION_SEED, keep_as_best, Keeper
from .long_runs import of_policy, of_words
from .policies.files import read_policy, WEIGHTS
from .probe import first_rewards
from .run import Configuration, EVEN, FROM_POLICY, Run
from .still import begin_still, hold_still
from .trust import read_pickle, write_pickle
from .vec_env import StickSlipVecEnv
from .verdict import Judging

with optional_import():
    import tensorboard  # noqa: F401  (Stable-Baselines3 logs by it)
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
    from stable_baselines3.common.vec_env import VecEnv, VecMonitor

__all__ = ["load_policy", "train"]

_CONFIGURATION = "stickslip_configuration"
_REWARDS = "stickslip_first_rewards"
_EVALUATIONS = 12


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
    # What the environment or the algorithm refuses, it refuses before the folder is touched.
    rewards = first_rewards(configuration.env_kwargs)
    constructor, evaluating = _constructors(configuration, vec_env)
    environments = _monitored(constructor, configuration, configuration.hyperparameters["n_envs"], configuration.seed)
    try:
        run = _reopened(folder, configuration) if resume else None
        checkpoint = None if run is None else run.latest_checkpoint()
        with library_threads(1):
            if run is None or checkpoint is None:
                model = _begun(configuration, environments, begin)
                vars(model)[_REWARDS] = rewards
            else:
                model = _resumed(run, configuration, checkpoint, environments, rewards, trust=trust)
            vars(model)[_CONFIGURATION] = asdict(configuration)  # SB3 saves every attribute
            if run is None:
                run = Run.create(folder, configuration)
            elif _is_moved(run, configuration):
                run.configure(configuration)
            remaining = configuration.hyperparameters["n_timesteps"] - model.num_timesteps
            if remaining > 0:
                _learn(run, model, evaluating, on_progress, remaining, anew=checkpoint is None)
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


def _constructors(
    configuration: Configuration, vec_env: Callable[..., VecEnv] | None
) -> tuple[Callable[..., VecEnv], Callable[..., VecEnv]]:
    """What makes the environments of the training, and those of its evaluations."""
    if vec_env is not None:
        return vec_env, vec_env
    if configuration.floor is None:
        return partial(StickSlipVecEnv, sparse_infos=True), StickSlipVecEnv
    return partial(FloorVecEnv, floor=Floor(configuration.floor), sparse_infos=True), StickSlipVecEnv


def _monitored(constructor: Callable[..., VecEnv], configuration: Configuration, count: int, seed: int) -> VecEnv:
    environments = VecMonitor(constructor(count, **configuration.env_kwargs))
    environments.seed(seed)
    return environments


def _reopened(folder: Path, configuration: Configuration) -> Run:
    """A run to go on with, which has the same configuration but for its end."""
    run = Run.open(folder)
    total = configuration.hyperparameters["n_timesteps"]
    refuse_other(f"to go on with run {folder}", _kept(run.configuration, total), _described(configuration))
    return run


def _is_moved(run: Run, configuration: Configuration) -> bool:
    """Whether a run is to end elsewhere than it was."""
    ends = (each.hyperparameters.get("n_timesteps") for each in (run.configuration, configuration))
    return len(set(ends)) > 1


def _begun(configuration: Configuration, environments: VecEnv, begin: Teacher | None) -> BaseAlgorithm:
    """A model that has not learned yet, and does at first what the configuration's `start` says."""
    hyperparameters = configuration.hyperparameters
    others = {name: each for name, each in hyperparameters.items() if name not in ("n_envs", "n_timesteps", "policy")}
    model = algorithm_class(configuration.algorithm)(
        hyperparameters["policy"], environments, seed=configuration.seed, device="cpu", **resolve(others)
    )
    if begin is not None:
        begin_from(model, begin, configuration.env_kwargs, seed=configuration.seed)
    elif configuration.start != EVEN:
        begin_still(model, int(configuration.start == "open"))
    return model


def _resumed(
    run: Run, configuration: Configuration, checkpoint: Path, environments: VecEnv, rewards: Any, *, trust: bool
) -> BaseAlgorithm:
    """The model of a checkpoint, if its environment pays as today's does and it has not gone beyond its end."""
    model = _load(configuration, checkpoint, read_pickle(checkpoint, trust=trust, own=True), env=environments)
    refuse_other(
        f"to go on with run {run.folder}, whose environment or reward was another",
        {"first rewards": vars(model).get(_REWARDS)},
        {"first rewards": rewards},
    )
    total = configuration.hyperparameters["n_timesteps"]
    if _is_moved(run, configuration) and total < model.num_timesteps:
        raise ValueError(
            f"n_timesteps must be at least {model.num_timesteps}, which run {run.folder} has done, got {total}"
        )
    if isinstance(model, OffPolicyAlgorithm) and run.replay_buffer.exists():
        model.load_replay_buffer(read_pickle(run.replay_buffer, trust=trust, own=True))
    return model


def _learn(
    run: Run,
    model: BaseAlgorithm,
    evaluating: Callable[..., VecEnv],
    on_progress: Callable[[int], Any],
    steps: int,
    *,
    anew: bool,
) -> None:
    """Train a model for so many steps more, and evaluate and keep it on the way and at the end."""
    configuration = run.configuration
    interval = max(1, configuration.hyperparameters["n_timesteps"] // _EVALUATIONS)
    model.tensorboard_log = str(run.folder / "tensorboard")
    make = partial(_monitored, evaluating, configuration)
    with Keeper(run, make, interval, on_progress, model.num_timesteps) as keeper:
        model.learn(steps, callback=keeper, reset_num_timesteps=anew, tb_log_name=configuration.algorithm)
        keeper.keep()


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
    seeds = range(EVALUATION_SEED, EVALUATION_SEED + judging.seeds)
    length: dict[str, Any] = {"seeds": seeds, "steps": judging.steps, "burn_in": judging.burn_in}
    own = of_policy(policy, arguments, **length).reward.mean()
    still = of_words(["0", "1"], arguments, **length)
    best = int(still[1].reward.mean() > still[0].reward.mean())
    if still[best].reward.mean() <= own:
        return False
    hold_still(model, best)
    means = {name: {"mean": float(each.mean())} for name, each in still[best]._asdict().items()}
    measured = "per step, in one long run a seed, once under way"
    keep_as_best(run, model, {"measured": measured, "seeds": list(seeds), **means})
    return True


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
