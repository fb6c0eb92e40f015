"""One step of one crawler, as the formulas of observation, reward and infos see it."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from numpy.typing import NDArray

from ..compiling.compilation import formula
from ..crawler.model.state import Body, Coefficients

__all__ = ["Formula", "Transition", "writer"]


class Transition(NamedTuple):
    """What happened in one hold, in natural units."""

    start: float  # of the foot, before the hold
    body: Body  # after it
    coefficients: Coefficients
    command: int
    valve: int  # after the flip
    valves: int  # this one and those of the holds before, each a bit, the newest lowest
    hold: float
    dither: float
    memory_weight: float
    memory: float  # what the readout earned


Formula = Callable[[Transition], Any]
"""A number told of a transition, in arithmetic that can be compiled: see `stickslip.compiling.compilation.formula`."""


def writer(formulas: Mapping[int, Formula]) -> Callable[[NDArray[Any], Transition], None]:
    """Make a function that writes what formulas give into an array, each at its place, for use in compiled code.

    Compiled code cannot go through a list of functions. So each is bound to its place, and to the one before.
    """
    write: Callable[[NDArray[Any], Transition], None] = _nothing
    for place, expression in formulas.items():
        write = _then(write, place, expression)
    return write


@formula
def _nothing(target: NDArray[Any], transition: Transition) -> None:
    pass


def _then(
    before: Callable[[NDArray[Any], Transition], None], place: int, expression: Formula
) -> Callable[[NDArray[Any], Transition], None]:
    @formula
    def write(target: NDArray[Any], transition: Transition) -> None:
        before(target, transition)
        target[place] = expression(transition)

    return write
