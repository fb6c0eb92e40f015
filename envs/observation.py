"""What a policy sees of a step: the table that single and batched environment compile."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ..compiling.compilation import formula
from ..crawler import Scene
from .transition import Formula, Transition, writer

__all__ = ["OBSERVATION", "Component", "observation_space", "observe", "seen_at_rest"]

Bounds = tuple[float, float]


class Component(NamedTuple):
    """One number of the observation, 0 of a crawler at rest with its valve shut."""

    name: str
    formula: Formula
    bounds: Callable[[Scene], Bounds]


@formula
def _deformation(step: Transition) -> float:
    return step.body.deformation


@formula
def _velocity(step: Transition) -> float:
    return step.body.velocity


@formula
def _pressure(step: Transition) -> float:
    return step.body.pressure


@formula
def _foot_velocity(step: Transition) -> float:
    return step.body.foot_velocity


@formula
def _valve(step: Transition) -> float:
    return step.valve


def _unbounded(_: Scene) -> Bounds:
    return -np.inf, np.inf


def _from_shut_to_open(_: Scene) -> Bounds:
    return 0.0, 1.0


def _of_the_foot(scene: Scene) -> Bounds:
    return (0.0 if scene.ratchet or scene.anchored else -np.inf), np.inf


OBSERVATION = (
    Component("deformation", _deformation, _unbounded),
    Component("velocity", _velocity, _unbounded),
    Component("pressure", _pressure, _from_shut_to_open),
    Component("foot_velocity", _foot_velocity, _of_the_foot),
    Component("valve", _valve, _from_shut_to_open),
)
"""In the order that a policy sees; `StickSlipCrawlerEnv` documents each."""

observe = writer([each.formula for each in OBSERVATION])
"""Write the observation of a transition into an array, in compiled code."""


def observation_space(scene: Scene) -> spaces.Space[NDArray[np.float32]]:
    """Space of the observations in a scene."""
    low, high = np.array([each.bounds(scene) for each in OBSERVATION], np.float32).T
    space: spaces.Space[Any] = spaces.Box(low, high)
    return space


def seen_at_rest(*count: int) -> NDArray[np.float32]:
    """Observations of crawlers at rest with their valves shut, of shape (*count, len(OBSERVATION))."""
    return np.zeros((*count, len(OBSERVATION)), np.float32)
