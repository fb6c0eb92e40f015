"""What a batch is given, one for all or one for each, and checked."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import ArrayLike, NDArray

from ..common.validation import whole_number
from ..crawler import Groups
from ..crawler.model.groups import groups_of_each
from ..crawler.model.holds import natural_holds
from .settings import HOLDS

__all__ = [
    "autoreset_mode_of",
    "commands_of",
    "generators_of",
    "groups_of",
    "hold_of_all",
    "mask_of",
    "option_of_each",
    "seeds_of",
    "shown_of",
]


def commands_of(actions: ArrayLike, count: int) -> NDArray[np.int64]:
    """Actions of each sub-environment."""
    try:
        commands = np.asarray(actions)
    except ValueError:  # rows of different lengths
        raise ValueError(f"actions must have shape ({count},), got {actions!r}") from None
    if commands.shape != (count,):
        raise ValueError(f"actions must have shape ({count},), got {commands.shape}")
    if commands.dtype.kind not in "biu":
        raise TypeError(f"actions must be whole numbers, got an array of {commands.dtype}")
    bits = commands.astype(np.bool_).astype(np.int64)
    allowed = commands == bits
    if np.count_nonzero(allowed) < count:
        i = int(np.argmin(allowed))
        raise ValueError(f"actions must be 0 or 1, got {commands[i]} for sub-environment {i}")
    return bits


def mask_of(mask: Any, count: int) -> NDArray[np.bool_]:
    """Sub-environments to reset."""
    if mask is None:
        return np.ones(count, np.bool_)
    if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
        raise TypeError(f"reset_mask must be an array of bool, got {mask!r}")
    if mask.shape != (count,):
        raise ValueError(f"reset_mask must have shape ({count},), got {mask.shape}")
    if not mask.any():
        raise ValueError("reset_mask must name one sub-environment at least, got none")
    return mask


def seeds_of(seed: int | Sequence[int | None] | None, count: int) -> list[int | None]:
    """Seed of each sub-environment."""
    if seed is None:
        return [None] * count
    if isinstance(seed, Sequence):
        seeds = [each if each is None else whole_number("seed", each, 0) for each in seed]
        if len(seeds) != count:
            raise ValueError(f"seed must be one number or {count} of them, got {len(seeds)}")
        return seeds
    first = whole_number("seed", seed, 0)
    return [first + i for i in range(count)]


def groups_of(choice: Any, count: int) -> list[Groups]:
    """Groups of each sub-environment."""
    groups = groups_of_each(choice)
    if isinstance(groups, Groups):
        return [groups] * count
    if len(groups) != count:
        raise ValueError(f"groups must be one choice or num_envs = {count} of them, got {len(groups)}")
    return groups


def hold_of_all(hold: Any, groups: Any) -> Any:
    """The hold of all sub-environments, natural where it was given in seconds of their actuators."""
    if not isinstance(hold, str):
        return hold
    natural = natural_holds(hold, groups, HOLDS)
    if not isinstance(natural, float):
        raise ValueError(
            f"hold must be as many t_c for each sub-environment, got {hold!r}, which is {natural.min():.6g} t_c of one "
            f"actuator and {natural.max():.6g} t_c of another: give it in t_c, or one environment for each"
        )
    return natural


def option_of_each(name: str, value: Any, count: int) -> Sequence[Any]:
    """An option of each sub-environment."""
    if isinstance(value, np.ndarray) and value.ndim > 0:
        value = value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str):
        if len(value) != count:
            raise ValueError(f"{name} must be one choice or num_envs = {count} of them, got {len(value)}")
        return value
    return [value] * count


def generators_of(value: Any, count: int) -> Sequence[np.random.Generator]:
    """Generators of each sub-environment."""
    if isinstance(value, np.random.Generator):
        return value.spawn(count)
    several = value if isinstance(value, Sequence) else ()
    if not several or not all(isinstance(each, np.random.Generator) for each in several):
        raise TypeError(f"np_random must be a numpy.random.Generator or num_envs = {count} of them, got {value!r}")
    if len(several) != count or len({id(each.bit_generator) for each in several}) < count:
        # Two threads that draw from one would get its numbers in no order.
        raise ValueError(f"np_random must be num_envs = {count} generators that share no state, got {value!r}")
    return several


def shown_of(rendered: Any, count: int) -> list[int]:
    """Sub-environments to draw."""
    if rendered is None:
        return list(range(count))
    if not isinstance(rendered, Sequence | np.ndarray):
        raise TypeError(f"rendered must be a sequence of sub-environments, got {rendered!r}")
    if len(rendered) == 0:
        raise ValueError(f"rendered must name one sub-environment at least, got {rendered!r}")
    return [whole_number("rendered", i, 0, count - 1) for i in rendered]


def autoreset_mode_of(mode: str | AutoresetMode) -> AutoresetMode:
    """What follows the end of an episode."""
    try:
        return AutoresetMode(mode)
    except ValueError:
        allowed = [each.value for each in AutoresetMode]
        raise ValueError(f"autoreset_mode must be one of {allowed}, got {mode!r}") from None
