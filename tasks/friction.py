"""The task that only a body can do: feel the ground's friction while it crawls."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.validation import whole_number
from .reservoirs import Reservoir
from .task import Metric, NRMSE, Solution

__all__ = ["FrictionTask"]

_SLIPPERIEST, _ROUGHEST = 0.05, 0.5
_LEAST_RATIO = 0.4


@dataclass(frozen=True)
class FrictionTask:
    """Tell the ground's friction from the body's states in the last hold of a known gait.

    Static friction is drawn uniformly from [0.05, 0.5] and kinetic friction from 0.4 to 1 times that. On each ground
    the body crawls from rest, and only what its readings say of its own stretch and pressure is read: what tells the
    friction is how it slips. A readout fitted on half of the grounds tells the friction of the others. Chance is an
    NRMSE of 1, which is about what an anchored body or a network scores: the gait alone says nothing of the ground.

    Attributes
    ----------
    which : {"static", "kinetic"}
        The friction to be told.
    word : str
        The gait, of 0 and 1.
    repeats : int, at least 1
        How often the word is repeated.

    Raises
    ------
    TypeError, ValueError
        If an attribute is invalid.
    """

    which: str = "kinetic"
    word: str = "11100"
    repeats: int = 6

    metric: Metric = NRMSE

    def __post_init__(self) -> None:
        if self.which not in ("static", "kinetic"):
            raise ValueError(f"which must be 'static' or 'kinetic', got {self.which!r}")
        if not self.word or set(self.word) - set("01"):
            raise ValueError(f"word must be of 0 and 1 and not empty, got {self.word!r}")
        whole_number("repeats", self.repeats, 1)

    def draw(self, count: int, seed: int) -> NDArray[np.float64]:
        """Static and kinetic friction of so many grounds, shape (count, 2)."""
        random = np.random.default_rng(whole_number("seed", seed, 0))
        static = random.uniform(_SLIPPERIEST, _ROUGHEST, whole_number("length", count, 1))
        return np.stack([static, static * random.uniform(_LEAST_RATIO, 1.0, len(static))], axis=1)

    def attempt(self, reservoir: Reservoir, *, length: int, seed: int, washout: int) -> Solution:
        """Score one reservoir on `length` samples: as many grounds as make up that many with the gait's holds.

        Parameters
        ----------
        reservoir : Reservoir
            Feels the ground if it has `on_grounds`; to another all grounds are alike.
        length : int
            At least so many gaits that half of them are as many as the features.
        seed : int, at least 0
        washout : int
            Of no matter here: every ground is met at rest, and only the gait's last hold is read.

        Returns
        -------
        Solution

        Raises
        ------
        TypeError, ValueError
            If an argument is invalid.
        """
        gait = np.array([float(letter) for letter in self.word * self.repeats])
        grounds = self.draw(whole_number("length", length, 2 * len(gait)) // len(gait), seed)
        felt: Callable[..., NDArray[np.float64]] | None = getattr(reservoir, "on_grounds", None)
        if felt is None:
            states = np.repeat(reservoir(gait, seed)[-1:], len(grounds), axis=0)
        else:
            states = felt(gait, grounds.tolist())[:, -1]
        return self.metric.solve(states, grounds[:, int(self.which == "kinetic")], 0)
