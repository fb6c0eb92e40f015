"""Where a step ends, and which samples are due by then."""

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, formula
from ..model.state import Body

__all__ = ["BODY_ROWS", "FARTHEST", "end_of_step", "is_near", "moment_of", "record", "sampled_by"]

# No bounded body stretches so far; beyond, a float32 observation and the squares of the motion would soon overflow.
FARTHEST = 1e12
# Rows that a body's samples have.
BODY_ROWS = 5


@compiled
def end_of_step(body: Body, close: float, elapsed: float, length: float, mode: int) -> tuple[float, bool]:
    """Time into the hold that a step of `length` reaches, and whether that is `close`, up to which the valve is kept.

    The last step ends on that itself, so that no sample is lost to the rounding of a sum. None goes beyond.
    """
    last = mode == body.mode and length >= close - elapsed
    return close if last else min(elapsed + length, close), last


@formula
def moment_of(done: float, count: float, hold: float) -> float:
    """Time into the hold of the sample after `done` of `count`."""
    return hold * ((done + 1.0) / count)


@formula
def is_near(body: Body) -> bool:
    """Whether the body is finite, and where a body can be."""
    return abs(body.deformation) + abs(body.velocity) + abs(body.foot_velocity) < FARTHEST


@compiled
def sampled_by(begin: float, hold: float, count: int) -> int:
    """How many of a hold's samples are taken by the time `begin`."""
    done = 0
    while begin > 0.0 and done < count and moment_of(done, count, hold) <= begin:
        done += 1
    return done


@compiled
def record(body: Body, samples: NDArray[np.float64], column: int) -> None:
    """Write z, v, p, x, w into one column."""
    samples[0, column] = body.deformation
    samples[1, column] = body.velocity
    samples[2, column] = body.pressure
    samples[3, column] = body.foot
    samples[4, column] = body.foot_velocity
