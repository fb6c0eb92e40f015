"""Hyperparameter files in the form of rl-baselines3-zoo."""

import ast
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any

from ...common.extras import optional_import

with optional_import():
    import yaml

__all__ = ["entropy_schedule", "linear_schedule", "read_hyperparameters", "resolve"]

_REQUIRED = ("n_envs", "n_timesteps", "policy")
# What a run sets itself.
_RESERVED = ("env", "seed", "device", "tensorboard_log", "verbose")
# Whatever a file may set that SB3 takes as a function of the remaining progress.
_SCHEDULES = ("learning_rate", "clip_range", "clip_range_vf")
# What it takes as a number alone; a training sets it anew before each update.
_ENTROPY = "ent_coef"


def read_hyperparameters(algorithm: str, environment: str, file: Path | None = None) -> dict[str, Any]:
    """The entry of an environment, as written.

    Parameters
    ----------
    algorithm : str
        One of `stickslip.train.algorithms.ALGORITHMS`.
    environment : str
        The environment's id.
    file : Path, optional
        A YAML file of your own; the package's `train/hyperparameters/<algorithm>.yml` by default.

    Returns
    -------
    dict
        With `n_envs`, `n_timesteps` and `policy` at least. `env_kwargs`, if there are any, are the environment's
        arguments where nobody says otherwise, as a mapping.

    Raises
    ------
    ValueError
        If the file is not YAML, lacks the environment, or its entry lacks one of those three, or its `env_kwargs` are
        no mapping.
    OSError
        If the file cannot be read.
    """
    if file is None:
        text = (resources.files(__package__) / f"{algorithm}.yml").read_text(encoding="utf-8")
        source = f"train/hyperparameters/{algorithm}.yml"
    else:
        source = str(file)
        try:
            text = file.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            raise ValueError(f"hyperparameters file {source} must be YAML, it is not text") from None
    try:
        entries = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(f"hyperparameters file {source} must be YAML: {' '.join(str(error).split())}") from None
    if not isinstance(entries, dict) or not isinstance(entries.get(environment), dict):
        found = sorted(entries) if isinstance(entries, dict) else entries
        raise ValueError(f"hyperparameters file {source} must have an entry {environment}, it has {found!r}")
    entry: dict[str, Any] = entries[environment]
    for name in _REQUIRED:
        if name not in entry:
            raise ValueError(
                f"hyperparameters file {source} must set {name} for {environment}, it sets {sorted(entry)}"
            )
    for name in ("n_envs", "n_timesteps"):
        value = entry[name]
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not 1 <= value < 1e15
            or value != int(value)
        ):
            raise ValueError(f"hyperparameters file {source}: {name} must be a whole number >= 1, got {value!r}")
        entry[name] = int(value)
    if "env_kwargs" in entry:
        entry["env_kwargs"] = _mapping("env_kwargs", entry["env_kwargs"])
    return entry


def resolve(hyperparameters: dict[str, Any]) -> dict[str, Any]:
    """Turn what YAML cannot say, ``lin_0.001`` and ``dict(net_arch=[64, 64])``, into what SB3 takes.

    Parameters
    ----------
    hyperparameters : dict
        As written in a file, without `n_envs`, `n_timesteps` and `policy`.

    Returns
    -------
    dict
        Keyword arguments of the algorithm.

    Raises
    ------
    ValueError
        If a schedule or a dict cannot be understood.
    """
    resolved = {name: _number(value) for name, value in hyperparameters.items()}
    for name in _RESERVED:
        if name in resolved:
            raise ValueError(f"hyperparameters must not set {name}: the run sets it")
    for name in _SCHEDULES:
        if isinstance(resolved.get(name), str):
            resolved[name] = _schedule(name, resolved[name])
    if (falling := entropy_schedule(resolved)) is not None:
        resolved[_ENTROPY] = falling(1.0)
    if "policy_kwargs" in resolved:
        resolved["policy_kwargs"] = _mapping("policy_kwargs", resolved["policy_kwargs"])
    return resolved


def entropy_schedule(hyperparameters: dict[str, Any]) -> Callable[[float], float] | None:
    """Schedule of ``ent_coef``, which SB3 takes as a number alone.

    Parameters
    ----------
    hyperparameters : dict
        As written in a file.

    Returns
    -------
    callable or None
        From the progress that remains, from 1 to 0, to the coefficient; None where it is a number, or not set.

    Raises
    ------
    ValueError
        If it is neither a number nor a schedule.
    """
    value = _number(hyperparameters.get(_ENTROPY))
    return _schedule(_ENTROPY, value) if isinstance(value, str) else None


def linear_schedule(start: float) -> Callable[[float], float]:
    """`start` times the progress that remains, from 1 down to 0."""
    return lambda remaining: remaining * start


def _number(value: Any) -> Any:
    """`value`, or the number it is written as: YAML takes 1e-4, without a point, for a string."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _schedule(name: str, text: str) -> Callable[[float], float]:
    prefix, _, number = text.partition("_")
    try:
        value = float(number)
    except ValueError:
        value = -1.0
    if prefix != "lin" or not 0.0 < value < float("inf"):
        raise ValueError(f"{name} must be a number or lin_<number>, got {text!r}")
    return linear_schedule(value)


def _mapping(name: str, value: Any) -> dict[str, Any]:
    """A mapping, or the keywords of a written call of dict; literals only, so that a file cannot run code."""
    if isinstance(value, dict):
        return value
    try:
        call = ast.parse(value, mode="eval").body
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "dict" and not call.args:
            return {str(keyword.arg): ast.literal_eval(keyword.value) for keyword in call.keywords}
    except (SyntaxError, TypeError, ValueError):
        pass
    raise ValueError(f"{name} must be a mapping or dict(key=literal, ...), got {value!r}")
