"""What a map is to hold, checked, and the blocks of cells that it is made of."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...common.fingerprint import described, rounded
from ...common.validation import known_names, whole_number
from ...reservoir.ridge import samples_needed
from ...tasks import BodyReservoir
from .axes import Axis
from .inputs import Inputs
from .measures import DEGREES, MEASURES, Variable

__all__ = ["Block", "Plan", "probe_of"]

# Samples of the motion in a block, of which each takes 40 bytes and the readings as many again.
_MOST_SAMPLES = 1_000_000
_HOLDOUT = 0.5


class Block(NamedTuple):
    """Cells in a row: those from `first` up to `last` along the axis of columns, in one row of the other."""

    row: int
    """0 where there is one axis only."""
    first: int
    last: int


@dataclass(frozen=True)
class Plan:
    """A map that is asked for.

    Attributes
    ----------
    axes : tuple of Axis
        One or two: that of columns last.
    measures : tuple of str
        Of `MEASURES`.
    body : BodyReservoir
        What is varied, and how it is read.
    inputs : Inputs
    holds, washout, delays : int
    seeds : tuple of int

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, or they do not go together; the message names it.
    """

    axes: tuple[Axis, ...]
    measures: tuple[str, ...]
    body: BodyReservoir
    inputs: Inputs
    holds: int
    washout: int
    delays: int
    seeds: tuple[int, ...]

    def __post_init__(self) -> None:
        names = [axis.name for axis in self.axes]
        if len(set(names)) < len(names):
            raise ValueError(f"x and y must vary two numbers, got {names[0]} twice")
        known_names("measures", self.measures, MEASURES)
        if not self.measures or len(set(self.measures)) < len(self.measures):
            raise ValueError(f"measures must name one measure at least and none twice, got {list(self.measures)}")
        whole_number("washout", self.washout, 0)
        whole_number("delays", self.delays, 1)
        whole_number("holds", self.holds, 1)
        for seed in self.seeds:
            whole_number("seeds", seed, 0)
        if not self.seeds or len(set(self.seeds)) < len(self.seeds):
            raise ValueError(f"seeds must hold one at least and none twice, got {list(self.seeds)}")
        reading = [name for name in self.measures if MEASURES[name].of_message]
        if reading:
            self._refuse_what_has_no_message(reading[0])
            self._refuse_too_short(reading[0])

    def _refuse_what_has_no_message(self, measure: str) -> None:
        dithers = next((axis.values for axis in self.axes if axis.name == "dither"), (self.inputs.dither,))
        if min(dithers) == 0.0:
            raise ValueError(
                f"inputs must be flipped with a dither above 0, or there is no message for {measure} to be of, "
                f"got dither 0"
            )

    def _refuse_too_short(self, measure: str) -> None:
        lead = max(self.washout + 2, self.delays)
        if self.holds < (least := lead + samples_needed(self.body.features, _HOLDOUT)):
            raise ValueError(
                f"holds must be at least {least} for {measure} of {self.body.features} features after a washout of "
                f"{self.washout}, got {self.holds}"
            )

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def cells(self) -> int:
        """How many."""
        return int(np.prod(self.shape))

    @cached_property
    def columns(self) -> int:
        """Cells of a block, at most."""
        whole = self.shape[-1]
        samples = self.holds * self.body.samples_per_hold * len(self.seeds)
        return -(-whole // -(-whole // max(1, _MOST_SAMPLES // samples)))

    @property
    def blocks(self) -> list[Block]:
        """Of all cells, each in one."""
        whole = self.shape[-1]
        rows = range(self.cells // whole)
        return [
            Block(row, first, min(first + self.columns, whole))
            for row in rows
            for first in range(0, whole, self.columns)
        ]

    @property
    def variables(self) -> dict[str, Variable]:
        """What the measures tell, by name."""
        return {name: each for measure in self.measures for name, each in MEASURES[measure].variables.items()}

    @property
    def points(self) -> dict[str, Sequence[int]]:
        """Of the further dimensions that a variable may have."""
        return {"delay": range(self.delays), "degree": DEGREES}

    def numbers(self, row: int, column: int) -> dict[str, float]:
        """What varies, in one cell."""
        *others, last = self.axes
        return {axis.name: axis.values[row] for axis in others} | {last.name: last.values[column]}

    @property
    def settings(self) -> dict[str, Any]:
        """What must be equal for two maps to be one, ready for JSON."""
        return {
            "axes": {axis.name: list(axis.values) for axis in self.axes},
            "order": [axis.name for axis in self.axes],
            "measures": list(self.measures),
            "groups": self.body.groups.to_dict(),
            "scene": self.body.scene.to_dict(),
            "hold": self.body.hold,
            "virtual_nodes": self.body.virtual_nodes,
            "readings": list(self.body.readings),
            "tolerance": self.body.tolerance,
            "inputs": {"word": self.inputs.word, "dither": self.inputs.dither},
            "holds": self.holds,
            "washout": self.washout,
            "delays": self.delays,
            "seeds": list(self.seeds),
        }

    def small(self) -> "Plan":
        """The same of one small cell, by which measures that have changed since are told."""
        axes = (Axis("hold", (1.0,)),)
        body = BodyReservoir(hold=1.0, virtual_nodes=2)
        return replace(self, axes=axes, body=body, inputs=Inputs(), holds=300, washout=60, delays=5, seeds=(0,))


def probe_of(found: dict[str, Any]) -> dict[str, Any]:
    """Rounded means of what was measured, as a fingerprint takes them."""
    return {name: described(rounded(float(np.mean(values)))) for name, values in found.items()}
