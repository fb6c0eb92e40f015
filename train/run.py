"""A training run on disk: what was asked for, its checkpoints and its best policy."""

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from inspect import signature
from pathlib import Path
from typing import Any

from ..common.extras import optional_import
from ..common.files import write_text
from ..common.validation import known_names, number_within, whole_number
from ..envs.settings import Settings
from ..envs.specification import plain_arguments
from .algorithms import ALGORITHMS

with optional_import():
    import yaml

__all__ = ["EVEN", "FROM_POLICY", "STARTS", "Configuration", "Run"]

_CHECKPOINT = re.compile(r"(\d+)_steps\.zip")
ENV_ARGUMENTS = tuple(signature(Settings.of).parameters)
ENVIRONMENTS = ("StickSlipCrawler-v0",)
EVEN = "even"
FROM_POLICY = "policy"
STARTS = (EVEN, "open", "shut", FROM_POLICY)
"""What a policy does before it has learned: chances are even, or the valve is mostly held open, or shut, or it does as
another policy does."""
_LARGEST_SEED = 2**32 - 1
_KEPT = (
    "configuration.yml",
    "checkpoints",
    "best.zip",
    "best.safetensors",
    "best.json",
    "final.zip",
    "evaluations.csv",
    "replay_buffer.pkl",
    "report.json",
    "report.md",
)


@dataclass(frozen=True)
class Configuration:
    """What fixes a training run.

    Parameters
    ----------
    algorithm : str
        One of `stickslip.train.algorithms.ALGORITHMS`.
    environment : {"StickSlipCrawler-v0"}
    env_kwargs : dict
        Its arguments; kept as JSON holds them.
    hyperparameters : dict
        As in a file of rl-baselines3-zoo's form, `n_envs`, `n_timesteps` and `policy` among them. If they have
        `env_kwargs`, these go over to those above, which win.
    seed : int, >= 0
    start : {"even", "open", "shut", "policy"}
        What the policy does before it has learned: one of :data:`STARTS`. Where rewards have several local optima, as
        between rest and walk, it decides which is found.
    floor : float, >= 0, optional
        Speed below which memory is worth less: what is learned is the utility of a `stickslip.train.floor.Floor`
        instead of the weighted reward.

    Raises
    ------
    ValueError, TypeError
        If the algorithm, the environment or the start is unknown, or the seed is not a whole number >= 0.
    """

    algorithm: str = "ppo"
    environment: str = "StickSlipCrawler-v0"
    env_kwargs: dict[str, Any] = field(default_factory=dict)
    hyperparameters: dict[str, Any] = field(default_factory=dict)
    seed: int = 0
    start: str = EVEN
    floor: float | None = None

    def __post_init__(self) -> None:
        if self.algorithm not in ALGORITHMS:
            raise ValueError(f"algorithm must be one of {list(ALGORITHMS)}, got {self.algorithm!r}")
        if self.environment not in ENVIRONMENTS:
            raise ValueError(f"environment must be one of {list(ENVIRONMENTS)}, got {self.environment!r}")
        if self.start not in STARTS:
            raise ValueError(f"start must be one of {list(STARTS)}, got {self.start!r}")
        if self.floor is not None:
            object.__setattr__(self, "floor", number_within("floor", self.floor, "[0, inf)"))
        whole_number("seed", self.seed, 0, _LARGEST_SEED)
        for name in ("env_kwargs", "hyperparameters"):
            if not isinstance(getattr(self, name), Mapping):
                raise TypeError(f"{name} must be a mapping, got {getattr(self, name)!r}")
        hyperparameters = dict(self.hyperparameters)
        env_kwargs = {**hyperparameters.pop("env_kwargs", {}), **self.env_kwargs}
        known_names("env_kwargs", env_kwargs, ENV_ARGUMENTS)
        object.__setattr__(self, "env_kwargs", plain_arguments(env_kwargs))
        object.__setattr__(self, "hyperparameters", hyperparameters)


class Run:
    """The folder of one training run.

    Holds ``configuration.yml``, ``checkpoints/<steps>_steps.zip``, ``best.zip`` (of the periodic evaluations),
    ``final.zip``, ``evaluations.csv`` and ``tensorboard/``; of a policy without memory ``best.safetensors`` and
    ``best.json``, which are the best policy's as `stickslip.train.policies` keeps it; ``report.json`` and
    ``report.md``, of the best policy beside what needs no training; and of an off-policy algorithm
    ``replay_buffer.pkl``. Every file appears whole or not at all.

    Parameters
    ----------
    folder : Path
    configuration : Configuration
    """

    def __init__(self, folder: Path, configuration: Configuration) -> None:
        self.folder = folder
        self.configuration = configuration

    @classmethod
    def create(cls, folder: Path, configuration: Configuration) -> "Run":
        """Make the folder of a new run.

        Raises
        ------
        ValueError
            If it holds a run already.
        OSError
            If it cannot be written.
        """
        if any((folder / name).exists() for name in _KEPT):
            raise ValueError(f"output {folder} holds a run already; resume it or name another folder")
        (folder / "checkpoints").mkdir(parents=True, exist_ok=True)
        run = cls(folder, configuration)
        run.configure(configuration)
        return run

    @classmethod
    def open(cls, folder: Path) -> "Run":
        """Open the folder of an earlier run.

        Raises
        ------
        ValueError
            If there is no run in it.
        """
        file = folder / "configuration.yml"
        if not file.is_file():
            raise ValueError(f"run must be a folder with a configuration.yml in it, got {folder}")
        try:
            written = yaml.safe_load(file.read_text(encoding="utf-8"))
        except (yaml.YAMLError, UnicodeDecodeError):
            raise ValueError(f"run {folder}: configuration.yml must be YAML") from None
        known = {each.name for each in fields(Configuration)}
        if not isinstance(written, dict) or set(written) != known:
            raise ValueError(f"run {folder}: configuration.yml must set {sorted(known)}, got {written!r}")
        return cls(folder, Configuration(**written))

    def configure(self, configuration: Configuration) -> None:
        """Have the folder say that the run is of this configuration.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        self.configuration = configuration
        text = yaml.safe_dump(asdict(configuration), sort_keys=False)
        write_text(self.folder / "configuration.yml", text)

    @property
    def best(self) -> Path:
        """Where the best policy of the periodic evaluations is kept."""
        return self.folder / "best.zip"

    @property
    def best_policy(self) -> Path:
        """Where the best policy is kept as plain numbers, without the suffixes of its two files."""
        return self.folder / "best"

    @property
    def replay_buffer(self) -> Path:
        """Where the transitions that an off-policy algorithm learns from are kept, as of the last checkpoint."""
        return self.folder / "replay_buffer.pkl"

    @property
    def final(self) -> Path:
        """Where the policy at the end of the training is kept."""
        return self.folder / "final.zip"

    def checkpoint(self, steps: int) -> Path:
        """Where the state of the training after `steps` steps is kept."""
        return self.folder / "checkpoints" / f"{steps}_steps.zip"

    def latest_checkpoint(self) -> Path | None:
        """The checkpoint with most steps, if there is any."""
        found = {}
        for path in (self.folder / "checkpoints").iterdir():
            match = _CHECKPOINT.fullmatch(path.name)
            if match:
                found[int(match[1])] = path
        return found[max(found)] if found else None
