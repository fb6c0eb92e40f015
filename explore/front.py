"""The front of speed against memory that the package ships, to see a setup among its points."""

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..train.schedules import pareto_front

__all__ = ["edge_of", "front_at"]

_FILE = "front.json"


def front_at(dither: float) -> tuple[float, Mapping[str, Any]]:
    """The front at a dither, or at the nearest that is shipped.

    Parameters
    ----------
    dither : float

    Returns
    -------
    dither : float
        That the front is of.
    front : mapping
        ``open loop``, ``held``, ``policies`` and ``conditioned`` are lists of {"name", "speed", "memory"}; ``limit`` is
        the speed of the fastest policy that is known. All of the default body at hold 0.5.
    """
    shipped = _shipped()
    nearest = min(shipped, key=lambda each: abs(each - dither))
    return nearest, shipped[nearest]


def edge_of(front: Mapping[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Border of what open loop reaches, from (0, most memory) down to (most speed, 0): speeds and memories."""
    points = np.array([(each["speed"], each["memory"]) for each in [*front["open loop"], *front["held"]]])
    speeds, memories = points[pareto_front(points)].T
    return (
        np.concatenate([[0.0], np.repeat(speeds[::-1], 2)]),
        np.concatenate([np.repeat(memories[::-1], 2), [0.0]]),
    )


@cache
def _shipped() -> Mapping[float, Mapping[str, Any]]:
    text = (resources.files("stickslip.explore") / _FILE).read_text(encoding="utf-8")
    return {each["dither"]: each for each in json.loads(text)["fronts"]}
