"""What measurements cannot tell of a body, in sentences."""

import numpy as np
from numpy.typing import NDArray

from .identification import Identification

__all__ = ["hidden_friction", "what_is_not_told"]

_ALIKE = 0.95  # share of the static friction above which the kinetic one hides it
_UNKNOWN = 0.5  # a relative standard error above this is told
_NAMED = 0.2  # share of a direction above which a parameter is named with it


def hidden_friction(found: Identification) -> tuple[str, ...]:
    """A sentence where the static friction may be next to the kinetic one."""
    intervals = found.interval()
    if "static_friction" not in intervals:
        return ()
    low, high = intervals["static_friction"]
    if found.body.kinetic_friction < _ALIKE * low:
        return ()
    return (
        f"static_friction may be within 5% of kinetic_friction: a foot that breaks loose then hardly jumps, and the "
        f"data tell it no better than {low:.3g} to {high:.3g}",
    )


def what_is_not_told(
    names: tuple[str, ...], errors: NDArray[np.float64], directions: NDArray[np.float64]
) -> tuple[str, ...]:
    """A sentence for each direction in which the fit may move by more than half of the guess."""
    told = []
    for error, direction in zip(errors.tolist(), directions, strict=True):
        if error > _UNKNOWN:
            order = np.argsort(-np.abs(direction))
            sign = np.sign(direction[order[0]])
            parts = [
                f"{'up' if direction[i] * sign > 0 else 'down'} in {names[i]} by {abs(direction[i]):.2g} of the guess"
                for i in order
                if abs(direction[i]) > _NAMED
            ]
            told.append(
                f"the data hardly tell a body from one {' and '.join(parts)}: the standard error along this is "
                f"{min(error, 1e9):.2g} of the guess"
            )
    return tuple(told)
