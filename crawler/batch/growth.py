"""Small changes of several crawlers at once, carried over the step that each has taken.

A change of z and v goes through a step by its Taylor series, about the same instant as the motion's: of the linearised
equations dz' = dv, dv' = -mobility (K dz + 2 Pi2 dv), whose stiffness K = `stiffness_at` has a series too. Where these
do not reach as far as the motion's, in a body that has all but come to rest, and across an event, a lane's changes are
carried as the single crawler's are.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.arithmetic import fma, Series, sum_of_products, where
from ...compiling.compilation import compiled
from ...compiling.tracing import unrolled_in_lanes
from ...compiling.vectors import LANES
from ..model.columns import body_of, coefficients_at
from ..model.equations import mobility_of, stiffness_at
from ..model.state import Body
from ..stability.lyapunov import (
    AREA,
    carried,
    carry_growth,
    COUNTS,
    is_handy,
    note_growth,
    Plane,
    rescale_growth,
    saltate_growth,
    VECTOR,
)
from ..stability.saltation import saltation_of
from ..stability.transition import Transition, transition
from ..steps.taylor_series import value
from ..steps.workspace import CHANGES, LENGTH, P, STEP, Z
from .step import BEFORE, COEFFICIENTS, HOLD, lane_of, MOTION, STATE, TANGENTS, VALVE

__all__ = [
    "Growth",
    "grow_alone",
    "grow_lanes",
    "load_changes",
    "note_alone",
    "rescale_alone",
    "saltate_alone",
    "write_changes",
]

# Error of a change's series, relative to the change, in tolerances. A motion fainter than the inverse of this takes
# steps longer than a change allows.
_ALLOWANCE = 64.0


class Growth(NamedTuple):
    """Small changes of n crawlers, and what is written down of them."""

    changes: NDArray[np.float64]  # (n, CHANGES, columns): the tangents of `stability.lyapunov`, updated
    marks: NDArray[np.int64]  # (holds,): where to write at the end of each hold; nowhere if negative
    grown: NDArray[np.float64]  # (n, GROWTH_ROWS, marks): what `note_growth` notes


def _transition_series(order: int, pull: Sequence[Any], braking: Any, dz: Any, dv: Any) -> tuple[list[Any], list[Any]]:
    """Coefficients of a change of z and v whose rates are dz' = dv, dv' = pull dz + braking dv."""
    z, v = [dz], [dv]
    for n in range(order + 1):
        by_newest = sorted(range(n + 1), key=lambda i: max(i + 0.5, n - i))
        total = sum_of_products([pull[i] for i in by_newest], [z[n - i] for i in by_newest])
        z.append(v[n] * (1.0 / (n + 1)))
        v.append(fma(braking, v[n], total) * (1.0 / (n + 1)))
    return z, v


def _power(x: Any, n: int) -> Any:
    if n == 1:
        return x
    half = _power(x, n // 2)
    return half * half * x if n % 2 else half * half


def _grow(order: int, rows: Any, tolerance: Any) -> tuple[dict[int, list[Any]], list[Any]]:
    """Vector and area, see `stability.lyapunov`, after the step that has been taken.

    Truths: the lanes whose series reach to the end of the step, which are the ones that are written; and those whose
    vector and area are of a handy length.
    """
    before, coefficients = lane_of(rows, BEFORE)
    length = rows[STEP][LENGTH]
    mobility = mobility_of(coefficients, before.mode)
    gap = before.pressure - rows[HOLD][VALVE]
    pressure = [before.pressure]
    for n in range(1, order + 1):
        gap = gap * (coefficients.lag_rate * (-1.0 / n))
        pressure.append(gap)
    series: list[Any] = [Series(rows[Z][n] for n in range(order + 1)), Series(pressure)]
    pull: Any = stiffness_at(coefficients, *series) * (mobility * -1.0)
    braking = mobility * (coefficients.damping * -1.0)

    square, power = length * length, _power(length, order)
    # Changes of v are as large as those of z times the frequency, of which this is the square, 1 at least.
    swing = (abs(pull[0]) + abs(pull[1]) * length + abs(pull[2]) * square).larger(1.0)
    allowed = tolerance * _ALLOWANCE
    entries: list[Any] = []
    sound: Any = None
    for start, scale in (((1.0, 0.0), swing), ((0.0, 1.0), 1.0)):
        dz, dv = _transition_series(order, pull, braking, *start)
        entries.append([value(row, length, square) for row in (dz, dv)])
        # Two, because every second term may be zero.
        for error in (abs(dv[order]) * power, abs(dv[order + 1]) * (power * length)):
            small = error * error <= allowed * allowed * scale
            sound = small if sound is None else sound & small
    (z_z, v_z), (z_v, v_v) = entries

    def number(row: int, column: int) -> Any:
        return rows[TANGENTS + row][column]

    plane = Plane(
        number(0, VECTOR),
        number(1, VECTOR),
        number(0, AREA),
        number(1, AREA),
        number(2, AREA),
        number(3, AREA),
        number(0, COUNTS),
    )
    after = carried(plane, Transition(z_z, z_v, v_z, v_v), length, before.mode, coefficients)
    handy = is_handy(after.z, after.v, number(2, VECTOR)) & is_handy(after.zv, after.zm, after.vm)
    after = Plane(*(where(sound, new, old) for new, old in zip(after, plane, strict=True)))
    written = [
        [after.z, after.zv, after.divergence],
        [after.v, after.zm, number(1, COUNTS)],
        [number(2, VECTOR), after.vm],
        [number(3, VECTOR), after.logarithm],
    ]
    # The columns before the vector are of no matter.
    return {TANGENTS + row: [*others[:1] * VECTOR, *others] for row, others in enumerate(written)}, [sound, handy]


grow_lanes = unrolled_in_lanes(_grow, LANES, 2)


@compiled
def load_changes(changes: NDArray[np.float64], lanes: NDArray[np.float64], lane: int) -> None:
    """Put a crawler's changes, of shape (CHANGES, columns), into its lane."""
    for row in range(CHANGES):
        for column in range(changes.shape[1]):
            lanes[TANGENTS + row, column, lane] = changes[row, column]


@compiled
def write_changes(lanes: NDArray[np.float64], lane: int, changes: NDArray[np.float64]) -> None:
    """Write down the changes in a lane."""
    for row in range(CHANGES):
        for column in range(changes.shape[1]):
            changes[row, column] = lanes[TANGENTS + row, column, lane]


@compiled
def grow_alone(order: int, lanes: NDArray[np.float64], lane: int, series: NDArray[np.float64]) -> None:
    """Carry a lane's changes over the step that it has taken, as `advance` would."""
    coefficients = coefficients_at(lanes[COEFFICIENTS], lane)
    before, length = body_of(lanes[BEFORE], lane), lanes[STEP, LENGTH, lane]
    gap = before.pressure - lanes[HOLD, VALVE, lane]
    series[P, 0] = before.pressure
    for n in range(order + 1):
        series[Z, n] = lanes[Z, n, lane]
        if n > 0:
            gap *= coefficients.lag_rate * (-1.0 / n)
            series[P, n] = gap
    series[Z, order + 1] = lanes[Z, order + 1, lane]
    over = transition(before, coefficients, order, length, series)
    carry_growth(over, length, before, coefficients, lanes[TANGENTS : TANGENTS + CHANGES, :, lane])


@compiled
def rescale_alone(lanes: NDArray[np.float64], lane: int) -> None:
    """Bring a lane's changes to a handy length."""
    rescale_growth(lanes[TANGENTS : TANGENTS + CHANGES, :, lane])


@compiled
def saltate_alone(time: float, lanes: NDArray[np.float64], lane: int) -> None:
    """Carry a lane's changes across the event at whose time in the run its step has ended."""
    coefficients = coefficients_at(lanes[COEFFICIENTS], lane)
    after, mode = body_of(lanes[STATE], lane), int(lanes[BEFORE, MOTION, lane])
    ended = Body(after.deformation, after.velocity, after.pressure, after.foot, after.foot_velocity, mode, after.slips)
    event = saltation_of(ended, after.mode, coefficients, lanes[HOLD, VALVE, lane], time)
    saltate_growth(event, mode, coefficients, lanes[TANGENTS : TANGENTS + CHANGES, :, lane])


@compiled
def note_alone(lanes: NDArray[np.float64], lane: int, into: NDArray[np.float64]) -> None:
    """Write down how far a lane's changes have grown."""
    note_growth(coefficients_at(lanes[COEFFICIENTS], lane), lanes[TANGENTS : TANGENTS + CHANGES, :, lane], into)
