"""Where looking at the valve gains most: closed against open loop over bodies, holds and dithers.

The closed loop is the simplest, registers of a few bits, whose front is found as that of open-loop schedules is. So a
place on the map takes seconds, and says the least that a policy can gain.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from ...common.jobs import as_done
from ...common.validation import whole_number
from ...reservoir.bootstrap import Estimate
from .hypervolume import hypervolume
from .judgement import jackknifed, joined, Judgement
from .open_loop import open_loop_front
from .registers import best_registers

__all__ = ["Place", "richest"]


@dataclass(frozen=True, eq=False)
class Place:
    """One set of conditions.

    Attributes
    ----------
    env_kwargs : mapping
        The conditions.
    open_loop, registers : Judgement
        Their fronts.
    """

    env_kwargs: Mapping[str, Any]
    open_loop: Judgement
    registers: Judgement

    @property
    def added(self) -> Estimate:
        """Hypervolume that registers add to that of the open-loop front, from (0, 0), and its interval."""
        schedules = len(self.open_loop.names)
        return jackknifed(
            lambda points: hypervolume(points) - hypervolume(points[:schedules]), joined(self.open_loop, self.registers)
        )

    @property
    def gain(self) -> Estimate:
        """Share by which registers enlarge the hypervolume of the open-loop front, from (0, 0), and its interval."""
        schedules = len(self.open_loop.names)
        return jackknifed(
            lambda points: hypervolume(points) / hypervolume(points[:schedules]) - 1.0,
            joined(self.open_loop, self.registers),
        )


def richest(
    places: Sequence[Mapping[str, Any]],
    *,
    longest: int = 11,
    bits: int = 3,
    seeds: int = 5,
    holds: int = 4000,
    screening_holds: int = 500,
    processes: int = 1,
) -> Iterator[tuple[int, Place]]:
    """Compare open and closed loop at each of several places.

    Parameters
    ----------
    places : sequence of mapping
        Each as for `conditions`, with dither.
    longest, bits, seeds, holds, screening_holds
        As in `open_loop_front` and `best_registers`.
    processes : int, >= 1
        That share the places.

    Yields
    ------
    index : int
        Of the place.
    place : Place
        As soon as it is there.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.
    """
    whole_number("processes", processes, 1)
    runs: dict[str, Any] = {"seeds": seeds, "holds": holds, "screening_holds": screening_holds, "threads": 1}
    work = partial(_compared, longest=longest, bits=bits, **runs)
    yield from as_done(work, list(places), processes=processes)


def _compared(place: Mapping[str, Any], *, longest: int, bits: int, **settings: Any) -> Place:
    open_loop = open_loop_front(longest=longest, **settings, **place)
    registers = best_registers(bits, **settings, **place)
    return Place(place, open_loop.front, registers.front)
