"""The message, and what a step is worth: the table that single and batched environment compile.

Section 4 of the design: the command is flipped with probability `dither`, and the message is the innovation, what the
command did not tell of the valve. The reward weighs what a step gains in each objective.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ..compiling.compilation import formula
from ..crawler import Scene
from .bounds import Bounds, box, forward, unbounded
from .transition import Formula, Transition

__all__ = ["OBJECTIVES", "Objective", "innovation", "memory", "reward", "reward_space", "speed", "surprise"]


class Objective(NamedTuple):
    """What a policy is to gain, its weight in the reward, and between which bounds it lies."""

    name: str  # of its info too
    formula: Formula
    weight: Formula
    bounds: Callable[[Scene], Bounds]


@formula
def surprise(valve: int, command: int, dither: float) -> float:
    """Innovation e = u - E[u | a] of the valve u given the command a, where E[u | a] = a (1 - eps) + (1 - a) eps."""
    return valve - abs(command - dither)


@formula
def innovation(step: Transition) -> float:
    """Innovation of the step."""
    return surprise(step.valve, step.command, step.dither)


@formula
def speed(step: Transition) -> float:
    """Mean speed of the foot over the hold."""
    return (step.body.foot - step.start) / step.hold


@formula
def memory(step: Transition) -> float:
    """What the memory readout earned; 0 without dither."""
    return step.memory


@formula
def _weight_of_speed(step: Transition) -> float:
    return 1.0 - step.memory_weight


@formula
def _weight_of_memory(step: Transition) -> float:
    return step.memory_weight


OBJECTIVES = (
    Objective("speed", speed, _weight_of_speed, forward),
    Objective("memory", memory, _weight_of_memory, unbounded),
)


def _weighted(objective: Objective) -> Formula:
    weight, gain = objective.weight, objective.formula

    @formula
    def weighted(step: Transition) -> float:
        product: float = weight(step) * gain(step)
        return product

    return weighted


def _sum(terms: Sequence[Formula]) -> Formula:
    *others, last = terms
    if not others:
        return last
    first = _sum(others)

    @formula
    def total(step: Transition) -> float:
        both: float = first(step) + last(step)
        return both

    return total


reward = _sum([_weighted(each) for each in OBJECTIVES])
"""Sum of the objectives by weight, in compiled code."""


def reward_space(scene: Scene) -> spaces.Space[NDArray[np.float64]]:
    """Space of the objectives of a step, in their order."""
    return box([each.bounds(scene) for each in OBJECTIVES], np.float64)
