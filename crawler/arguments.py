"""What a crawler, or a batch of them, is given to be driven: checked, and row by row."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import number_within
from .batch_simulation import Batch
from .model.columns import chains_of_each
from .model.groups import Groups, groups_of_each
from .model.holds import natural_holds
from .model.scene import Scene
from .model.state import BACKWARD, Body, ChainState, FORWARD, State, STUCK
from .model.tube import stretches_of
from .model.variations import HOLDS

__all__ = ["TOLERANCES", "batch_of", "schedule_of", "start_of"]

TOLERANCES = "[1e-15, 1e-2]"
_RANGES = dict.fromkeys((f"initial {name}" for name in State._fields), "(-inf, inf)") | {"initial pressure": "[0, 1]"}


def batch_of(groups: Any, valve: ArrayLike, hold: Any, scene: Any) -> tuple[Batch, bool, bool]:
    """Who is driven, row by row, whether there is one crawler only, and whether one hold is for all."""
    several = isinstance(scene, Sequence) and not isinstance(scene, str)
    scenes = [Scene.of(one) for one in scene] if several else Scene.of(scene)
    if isinstance(groups, Iterator):  # which is looked at twice
        groups = list(groups)
    holds = natural_holds(hold, groups)
    each, schedule = groups_of_each(groups), schedule_of(valve)
    rows = {
        "groups": None if isinstance(each, Groups) else len(each),
        "valve": None if schedule.ndim == 1 else len(schedule),
        "scene": len(scenes) if isinstance(scenes, list) else None,
        "hold": None if isinstance(holds, float) else len(holds),
    }
    counts = {name: count for name, count in rows.items() if count is not None}
    if len(set(counts.values())) > 1:
        raise ValueError(
            f"{_listed(list(counts))} must have as many rows, got {_listed([str(count) for count in counts.values()])}"
        )
    count = next(iter(counts.values()), 1)
    if count == 0:
        raise ValueError(f"{_listed(list(counts))} must have a row at least, got none")
    if not isinstance(holds, float):
        for i in np.flatnonzero(~(holds > 0.0))[:1].tolist():
            number_within(f"hold of crawler {i}", float(holds[i]), HOLDS)
    if isinstance(scenes, list) and len(segments := {one.segments for one in scenes}) > 1:
        raise ValueError(f"scene must have the same segments in all rows, got {sorted(segments)}")
    scene_of_each = scenes if isinstance(scenes, list) else [scenes] * count
    batch = Batch(
        [each] * count if isinstance(each, Groups) else each,
        scene_of_each,
        np.full(count, holds),
        schedule[np.newaxis].repeat(count, axis=0) if schedule.ndim == 1 else schedule,
        chains_of_each(scene_of_each),
    )
    return batch, not counts, isinstance(holds, float)


def _listed(words: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


def schedule_of(valve: ArrayLike, shapes: Sequence[str] = ("(holds,)", "(batch, holds)")) -> NDArray[Any]:
    """Duty cycles, checked: int8 where whole numbers were given, float64 where floats were.

    The shapes that they may have are those of one dimension, of two and so on.
    """
    allowed_shapes = " or ".join(filter(None, [", ".join(shapes[:-1]), shapes[-1]]))
    try:
        given = np.asarray(valve)
    except ValueError:
        raise ValueError(f"valve must have shape {allowed_shapes}, got rows of different length") from None
    if not 1 <= given.ndim <= len(shapes) or given.size == 0:
        raise ValueError(f"valve must have shape {allowed_shapes} and not be empty, got {given.shape}")
    kind = given.dtype.kind
    allowed = (given >= 0) & (given <= 1) if kind in "biuf" else np.zeros(given.shape, np.bool_)
    if not allowed.all():
        index = tuple(int(i) for i in np.argwhere(~allowed)[0])
        raise ValueError(f"valve must hold only numbers in [0, 1], got {given[index]!r} at index {index}")
    return given.astype(np.float64 if kind == "f" else np.int8)


def start_of(initial: State | ChainState, scene: Scene) -> tuple[Body, NDArray[np.float64]]:
    """The solver's state for the user's, and the stretches of its segments."""
    if not isinstance(initial, tuple) or len(initial) != len(State._fields):
        raise TypeError(f"initial must be a State or a ChainState, got {initial!r}")
    stretches = None
    if isinstance(initial, ChainState):
        stretches = stretches_of(initial, scene)
        z, v = stretches.mean(axis=1).tolist()
        initial = State(z, v, initial.pressure, initial.foot, initial.foot_velocity)
    ranges = zip(_RANGES.items(), initial, strict=True)
    state = State(*(number_within(name, value, interval) for (name, interval), value in ranges))
    slowest = 0.0 if scene.ratchet or scene.anchored else -math.inf
    fastest = 0.0 if scene.anchored else math.inf
    if not slowest <= state.foot_velocity <= fastest:
        raise ValueError(
            f"initial foot_velocity must be in [{slowest:g}, {fastest:g}] in {scene}, got {state.foot_velocity!r}"
        )
    mode = STUCK
    if state.foot_velocity != 0.0:
        mode = FORWARD if state.foot_velocity > 0.0 else BACKWARD
    if stretches is None:
        stretches = np.array([[state.deformation] * scene.segments, [state.velocity] * scene.segments])
    return Body(*state, mode, 0), stretches
