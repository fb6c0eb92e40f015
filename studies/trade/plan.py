"""The plan of a trade, as data: what is asked for, and the independent cells of work that it takes."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any, NamedTuple

from ...common.fingerprint import described
from ...common.validation import known_names, number_within, whole_number
from ...envs.settings import Settings
from ...envs.specification import plain_arguments
from ...train.algorithms import ALGORITHMS
from ...train.hyperparameters import read_hyperparameters
from ...train.probe import first_rewards
from ...train.run import Configuration, ENV_ARGUMENTS, EVEN, FROM_POLICY

__all__ = ["CONDITIONED", "FLOORED", "FULL", "JUDGED", "LIMIT", "OPEN_LOOP", "QUICK", "TRAINED", "Cell", "Trade"]

OPEN_LOOP = "open loop"
LIMIT = "speed limit"
TRAINED = "policy"
CONDITIONED = "conditioned policy"
JUDGED = {TRAINED: "judged policy", CONDITIONED: "judged conditioned policy"}
"""Kinds of judgement, by the kind of what is judged."""

FLOORED = "StickSlipCrawlerMO-v0"
"""Whose entry of a hyperparameter file is for trainings above a floor on speed."""

FULL: Mapping[str, Any] = {
    "weights": (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.45, 0.5, 0.7, 1.0),
    "dithers": (0.1,),
    "seeds": 3,
    "floors": (0.2, 0.7),
    "longest": 16,
    "resolution": 28,
    "judges": 10,
    "holds": 6000,
}
"""What ``stickslip trade`` takes unless said otherwise, and a `Trade` as well but for the floors."""

QUICK: Mapping[str, Any] = {
    **FULL,
    "weights": (0.0, 0.1, 0.2, 1.0),
    "seeds": 1,
    "floors": (),
    "longest": 8,
    "resolution": 16,
    "judges": 4,
    "holds": 3000,
}
"""What a glance takes."""

EPISODE = 1000
"""Steps of the episodes that a training is paid for."""

# The trade says these itself.
_OWN = ("memory_weight", "dither", "randomize")
# What a `Policy` can tell; a recurrent one has a memory of its own.
_POLICY = "MlpPolicy"
# Whose shipped hyperparameters have an entry for floors.
_FLOORED = ("ppo",)


class Cell(NamedTuple):
    """One piece of work, which depends on the trade's settings and on nothing else but policies that others train."""

    kind: str
    dither: float
    weight: float | None = None
    seed: int | None = None
    of: str | None = None
    """What a policy depends on, as a digest: those that it is distilled from."""
    floor: float | None = None
    """On speed, of a policy that was trained for one instead of a weight."""

    @property
    def name(self) -> str:
        """A name that no other cell of a trade has, good for a file."""
        parts = [self.kind.replace(" ", "-"), f"dither-{self.dither!r}"]
        if self.weight is not None:
            parts.append(f"weight-{self.weight!r}")
        if self.seed is not None:
            parts.append(f"seed-{self.seed}")
        if self.of is not None:
            parts.append(f"of-{self.of}")
        if self.floor is not None:
            parts.append(f"floor-{self.floor!r}")
        return "-".join(parts)

    @property
    def judges(self) -> "Cell | None":
        """The cell whose policy this one judges."""
        kind = next((kind for kind, judged in JUDGED.items() if judged == self.kind), None)
        if kind is None:
            return None
        return self._replace(kind=kind, weight=self.weight if kind == TRAINED else None)


@dataclass(frozen=True, kw_only=True)
class Trade:
    """What a front is asked for.

    Parameters
    ----------
    weights : sequence of float, in [0, 1]
        Of memory in the reward. Without dither there is no message, and of them only 0 is taken.
    dithers : sequence of float, in [0, 1/2]
        Probabilities that a command is flipped.
    seeds : int, at least 1
        Trainings at each weight and dither.
    first_seed : int, at least 0
        Of the trainings; the others follow.
    floors : sequence of float, above 0
        On speed: policies are trained as well for memory above each (`stickslip.train.floor.Floor`). They begin as the
        register with the most memory above the floor, of the last three valve states or of those that are seen: from
        even chances a policy learns to walk, and never sees what lies near to rest.
        None are by default, nor where there is no dither.
    env_kwargs : mapping
        Further arguments of the environment, such as ``hold`` and ``groups``. They win over those that the
        hyperparameters bring.
    algorithm : str
        One of `stickslip.train.algorithms.ALGORITHMS`.
    hyperparameters : mapping, optional
        As in `stickslip.train.run.Configuration`; those shipped by default.
    floor_hyperparameters : mapping, optional
        Of the trainings above floors; by default those of an entry of :data:`FLOORED` that is shipped, and where
        `hyperparameters` are given, or there is none, the same as of the others.
    steps : int, optional
        Environment steps of each training, instead of the hyperparameters'.
    conditioned : bool
        Whether one policy for all weights is distilled at each dither from those for one.
    longest : int, at least 1
        Bits of the longest open-loop words.
    resolution : int, in [6, 100]
        Of the grid that the speed limit is found on: see `stickslip.studies.trade.speed_limit`.
    judges : int, at least 2
        Seeds, which no training sees, that everything is judged on.
    holds : int, at least 1000
        Of each run that judges.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range, of the wrong type, or names something twice.
    """

    weights: tuple[float, ...] = FULL["weights"]
    dithers: tuple[float, ...] = FULL["dithers"]
    seeds: int = FULL["seeds"]
    first_seed: int = 0
    floors: tuple[float, ...] = ()
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)
    algorithm: str = "ppo"
    hyperparameters: Mapping[str, Any] | None = None
    floor_hyperparameters: Mapping[str, Any] | None = None
    steps: int | None = None
    conditioned: bool = True
    longest: int = FULL["longest"]
    resolution: int = FULL["resolution"]
    judges: int = FULL["judges"]
    holds: int = FULL["holds"]

    def __post_init__(self) -> None:
        for name, interval in (("weights", "[0, 1]"), ("dithers", "[0, 0.5]"), ("floors", "(0, inf)")):
            object.__setattr__(self, name, _distinct(name, getattr(self, name), interval))
        for name in ("weights", "dithers"):
            if not getattr(self, name):
                raise ValueError(f"{name} must hold one number at least, got {getattr(self, name)}")
        for name, least in (
            ("seeds", 1),
            ("first_seed", 0),
            ("longest", 1),
            ("resolution", 6),
            ("judges", 2),
            ("holds", EPISODE),
        ):
            whole_number(name, getattr(self, name), least)
        known_names("env_kwargs", self.env_kwargs, [name for name in ENV_ARGUMENTS if name not in _OWN])
        entry, floored = self.hyperparameters, self.floor_hyperparameters
        if self.algorithm not in ALGORITHMS:
            raise ValueError(f"algorithm must be one of {list(ALGORITHMS)}, got {self.algorithm!r}")
        if entry is None:
            entry = read_hyperparameters(self.algorithm, Configuration.environment)
            if floored is None and self.algorithm in _FLOORED:
                floored = read_hyperparameters(self.algorithm, FLOORED)
        for name, own in (("hyperparameters", entry), ("floor_hyperparameters", entry if floored is None else floored)):
            kept = dict(own)
            if kept["policy"] != _POLICY:
                raise ValueError(f"{name} must have the policy {_POLICY}, got {kept['policy']!r}")
            if self.steps is not None:
                kept["n_timesteps"] = whole_number("steps", self.steps, 1)
            object.__setattr__(self, name, kept)
        object.__setattr__(self, "env_kwargs", plain_arguments(self.env_kwargs))
        self.world(self.dithers[0])  # what the environment refuses, it refuses here

    def configuration(
        self, dither: float, weight: float | None, seed: int, floor: float | None = None
    ) -> Configuration:
        """The configuration of a training, for a weight or a floor."""
        told = {"dither": dither} if weight is None else {"dither": dither, "memory_weight": weight}
        return Configuration(
            algorithm=self.algorithm,
            env_kwargs={**self.env_kwargs, **told},
            hyperparameters=dict((self.hyperparameters if floor is None else self.floor_hyperparameters) or {}),
            seed=seed,
            start=EVEN if floor is None else FROM_POLICY,
            floor=floor,
        )

    def world(self, dither: float) -> Settings:
        """The environment at a dither, as its settings."""
        return Settings.of(**self.configuration(dither, 0.0, 0).env_kwargs)

    @property
    def settings(self) -> dict[str, Any]:
        """What must be equal for cells to belong together, ready for JSON: all but which of them are asked for."""
        return {
            "env_kwargs": described(self.env_kwargs),
            "algorithm": self.algorithm,
            "hyperparameters": described(self.hyperparameters),
            "floor_hyperparameters": described(self.floor_hyperparameters),
            "longest": self.longest,
            "resolution": self.resolution,
            "judges": self.judges,
            "holds": self.holds,
        }

    def probe(self) -> list[float | str]:
        """What a fixed word earns, rounded: a body or a reward that has changed since is told by it."""
        return first_rewards(self.configuration(0.1, 0.5, 0).env_kwargs)

    def cells(self) -> list[list[Cell]]:
        """The work, in stages: cells of one depend on none of it, and on those of the stages before.

        Returns
        -------
        list of list of Cell
            The longest first.
        """
        making = [Cell(OPEN_LOOP, dither) for dither in self.dithers]
        making += [Cell(LIMIT, dither) for dither in self.dithers]
        making += [cell for dither in self.dithers for cell in self.teachers(dither)]
        making += [cell for dither in self.dithers for cell in self.floored(dither)]
        distilling = []
        if self.conditioned:
            distilling = [self._distilled(dither) for dither in self.dithers if dither > 0]
        judging = []
        for cell in (*distilling, *making):
            if cell.kind == TRAINED:
                judging.append(cell._replace(kind=JUDGED[TRAINED]))
            elif cell.kind == CONDITIONED:
                judging += [cell._replace(kind=JUDGED[CONDITIONED], weight=weight) for weight in self.weights]
        return [making, distilling, judging]

    def teachers(self, dither: float) -> list[Cell]:
        """The trainings for a weight at a dither, of which the policy for all weights is distilled."""
        return [Cell(TRAINED, dither, weight, seed) for seed in self._seeds for weight in self.weights_at(dither)]

    def floored(self, dither: float) -> list[Cell]:
        """The trainings at a dither above the floors on speed."""
        return [
            Cell(TRAINED, dither, seed=seed, floor=floor) for seed in self._seeds for floor in self.floors if dither > 0
        ]

    @property
    def _seeds(self) -> range:
        return range(self.first_seed, self.first_seed + self.seeds)

    def _distilled(self, dither: float) -> Cell:
        return Cell(CONDITIONED, dither, None, self.first_seed, _digest([each.name for each in self.teachers(dither)]))

    def weights_at(self, dither: float) -> tuple[float, ...]:
        """Weights of memory that mean something at a dither."""
        return tuple(weight for weight in self.weights if weight == 0 or dither > 0)


def _digest(names: list[Any]) -> str:
    return sha256(json.dumps(names).encode()).hexdigest()[:8]


def _distinct(name: str, values: Iterable[float], interval: str) -> tuple[float, ...]:
    numbers = tuple(sorted(number_within(name, value, interval) for value in values))
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"{name} must hold no number twice, got {numbers}")
    return numbers
