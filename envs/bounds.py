"""Bounds of what an environment tells, where the physics sets any, and the spaces that they make."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import DTypeLike, NDArray

from ..crawler import Scene

__all__ = ["Bounds", "box", "forward", "from_shut_to_open", "unbounded"]

Bounds = tuple[float, float]


def unbounded(_: Scene) -> Bounds:
    """Of what may be anything."""
    return -np.inf, np.inf


def from_shut_to_open(_: Scene) -> Bounds:
    """Of a valve, and of the pressure behind it."""
    return 0.0, 1.0


def forward(scene: Scene) -> Bounds:
    """Of the foot's speed: with a ratchet, or an anchor, it never slides back."""
    return (0.0 if scene.ratchet or scene.anchored else -np.inf), np.inf


def box(bounds: Sequence[Bounds], dtype: DTypeLike) -> spaces.Space[NDArray[Any]]:
    """Space of as many numbers."""
    low, high = np.array(bounds, dtype).T
    space: spaces.Space[Any] = spaces.Box(low, high, dtype=np.dtype(dtype).type)
    return space
