"""What a policy sees of a step: the table that single and batched environment compile."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ..compiling.compilation import formula
from ..crawler import Scene
from .bounds import Bounds, box, forward, from_shut_to_open, unbounded
from .transition import Transition, writer

__all__ = ["OBSERVATION", "VALVES", "Component", "observation_space", "observe", "seen_at_rest", "valves_seen"]


class Component(NamedTuple):
    """One number of the observation, 0 of a crawler at rest with its valve shut."""

    name: str
    formula: Callable[..., Any]  # of a `Transition`
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
def _valve(step: Transition, age: int) -> float:
    return step.valves >> age & 1


OBSERVATION = (
    Component("deformation", _deformation, unbounded),
    Component("velocity", _velocity, unbounded),
    Component("pressure", _pressure, from_shut_to_open),
    Component("foot_velocity", _foot_velocity, forward),
)
"""In the order that a policy sees; `StickSlipCrawlerEnv` documents each."""

VALVES = Component("valve", _valve, from_shut_to_open)
"""What follows, for each of the last valve states, newest first; its formula takes the age too, 0 of the newest."""

_write_body = writer({place: each.formula for place, each in enumerate(OBSERVATION)})
_FIRST_VALVE = len(OBSERVATION)


@formula
def observe(target: NDArray[np.float32], step: Transition) -> None:
    """Write the observation of a transition into an array, in compiled code."""
    _write_body(target, step)
    target[_FIRST_VALVE] = _valve(step, 0)  # apart, since most often it is the only one
    for age in range(1, len(target) - _FIRST_VALVE):
        target[_FIRST_VALVE + age] = _valve(step, age)


@formula
def valves_seen(observation: NDArray[np.float32]) -> np.int64:
    """Valve states that an observation shows, as `Transition.valves` has them."""
    valves = np.int64(0)
    for age in range(len(observation) - _FIRST_VALVE):
        valves |= np.int64(observation[_FIRST_VALVE + age]) << np.int64(age)
    return valves


def observation_space(scene: Scene, valve_history: int) -> spaces.Space[NDArray[np.float32]]:
    """Space of the observations in a scene, with so many valve states."""
    seen = *OBSERVATION, *[VALVES] * valve_history
    return box([each.bounds(scene) for each in seen], np.float32)


def seen_at_rest(valve_history: int, *count: int) -> NDArray[np.float32]:
    """Observations of crawlers at rest whose valves were shut, of shape (*count, observation)."""
    return np.zeros((*count, _FIRST_VALVE + valve_history), np.float32)
