"""Open-loop valve schedules: words repeated for ever, the yardstick of every policy."""

from collections.abc import Iterator
from inspect import signature
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.validation import number_within, whole_number
from ..crawler import GroupsLike, Scene, simulate
from ..envs.settings import Settings
from ..reservoir import memory_capacity, MemoryCapacity, target_series
from ..reservoir.targets import target_of
from ..tasks import body_states, dithered, innovation

__all__ = ["Performance", "measured_under", "necklaces", "pareto_front", "performance", "performances", "repeat"]


class Performance(NamedTuple):
    """What a sequence of valve states came to."""

    speed: float
    """Mean speed of the foot, z_c / t_c."""
    memory: MemoryCapacity | None
    """Held-out memory capacity for the flips; None where there were none."""


def performances(
    commands: NDArray[np.int64],
    valves: NDArray[np.int64],
    *,
    dither: float,
    groups: GroupsLike,
    hold: float,
    scene: Scene,
    delays: int = 20,
    virtual_nodes: int = 4,
    tolerance: float = 1e-6,
    target: str = "memory",
    target_order: int = 2,
) -> list[Performance]:
    """Speed and memory of crawlers whose valves were commanded, and flipped, like this: all of them move as one batch.

    Parameters
    ----------
    commands, valves : (schedules, holds) arrays of 0 and 1
        What was asked for, and what came of it. With dither the memory is held out on the second half of them.
    dither : float, in [0, 1/2]
        Probability with which they differ.
    groups, hold, scene, tolerance
        As in `simulate`, the same for all.
    delays, virtual_nodes, target, target_order
        As in the environment: the memory is the capacity for the target.

    Returns
    -------
    list of Performance
        One a schedule.
    """
    motions = simulate(groups, valves, hold, scene=scene, tolerance=tolerance, samples_per_hold=virtual_nodes)
    speeds = (motions.foot[:, -1] / (valves.shape[1] * hold)).tolist()
    if number_within("dither", dither, "[0, 0.5]") == 0.0:
        return [Performance(speed, None) for speed in speeds]
    aim = target, target_order, dither
    read_out = 1 if target_of(*aim).single else delays
    return [
        Performance(speed, memory_capacity(states, target_series(innovation(valve, command, dither), *aim), read_out))
        for speed, states, valve, command in zip(speeds, body_states(motions), valves, commands, strict=True)
    ]


_CONDITIONS = [name for name, each in signature(performances).parameters.items() if each.kind is each.KEYWORD_ONLY]


def measured_under(settings: Settings) -> dict[str, Any]:
    """What `performances` takes besides commands and valves, as an environment has it; its groups are not drawn."""
    return {name: getattr(settings, name) for name in _CONDITIONS}


def performance(command: NDArray[np.int64], valve: NDArray[np.int64], **settings: Any) -> Performance:
    """Speed and memory of one crawler: see `performances`.

    Parameters
    ----------
    command, valve : (holds,) arrays of 0 and 1
    **settings
        As for `performances`.

    Returns
    -------
    Performance
    """
    [result] = performances(np.asarray(command)[None], np.asarray(valve)[None], **settings)
    return result


def repeat(word: str, holds: int, *, dither: float = 0.0, seed: int = 0) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Command that repeats a word such as "11100", and the valve states that come of it.

    Raises
    ------
    ValueError
        If the word is empty or has other letters than 0 and 1.
    """
    if not word or set(word) - {"0", "1"}:
        raise ValueError(f"word must be made of 0 and 1, got {word!r}")
    command = np.resize(np.array([int(letter) for letter in word]), whole_number("holds", holds, 1))
    return command, dithered(command, dither, seed)


def necklaces(longest: int) -> Iterator[str]:
    """Words of 0 and 1 up to a length, one for each schedule: no rotation and no repetition of a shorter one.

    Parameters
    ----------
    longest : int, >= 1

    Yields
    ------
    str
        The Lyndon word of its necklace, written with the ones in front.
    """
    for length in range(1, whole_number("longest", longest, 1) + 1):
        for letters in product("10", repeat=length):
            word = "".join(letters)
            if all(word > word[shift:] + word[:shift] for shift in range(1, length)):
                yield word


def pareto_front(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Which points no other beats in both coordinates.

    Parameters
    ----------
    points : (n, 2) array
        More is better.

    Returns
    -------
    (m,) array of int
        Indices, by the first coordinate, falling.
    """
    front: list[int] = []
    for index in np.lexsort((-points[:, 1], -points[:, 0])):
        if not front or points[index, 1] > points[front[-1], 1]:
            front.append(int(index))
    return np.array(front, dtype=np.int64)
