"""How fast small changes of z and v grow: one vector and one area, carried along the run.

The growth of a vector is that of the first exponent, the growth of an area the sum of both. While the foot sticks the
changes of a body are a plane, of (z, v); a slip lets them out into the space of (z, v, m), m = w + (1 - r) v the
momentum, which stays while the foot slides, and a stop takes the plane that they have become to a plane of (z, v)
again. The area has three components there, that follow the compound matrix (B. S. Ng and W. H. Reid, J. Comput. Phys.
30 (1979) 125): it knows no angle between vectors that could be lost, however stiff the body. Its component in (z, v)
shrinks as the damping does.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.arithmetic import exp, where
from ...compiling.compilation import compiled, formula
from ..model.equations import mobility_of
from ..model.state import Body, Coefficients, STUCK
from ..steps.workspace import CHANGES
from .saltation import Saltation
from .transition import Transition

__all__ = [
    "AREA",
    "COUNTS",
    "GROWTH_ROWS",
    "VECTOR",
    "Plane",
    "carried",
    "carry_growth",
    "is_handy",
    "note_growth",
    "rescale_growth",
    "saltate_growth",
    "start_growth",
]

# Columns of the tangents, after those of `tangent`: a vector (z, v, m) and an area (zv, zm, vm), each with the
# logarithm of what it has been divided by, and then the integral of the divergence and the number of stops.
VECTOR, AREA, COUNTS = 3, 4, 5
_Z, _V, _M, _LOGARITHM = range(4)
_ZV, _ZM, _VM = range(3)
_DIVERGENCE, _STOPS = range(2)
GROWTH_ROWS = 4
"""Rows of `note_growth`: the logarithms of vector and area, the integral of the divergence, and the stops."""
# Within these a vector is left as it is.
_SHORT, _LONG = 1e-60, 1e60


def start_growth(coefficients: Coefficients, workspace: NDArray[np.float64]) -> None:
    """Begin with a change of the direction that is there, and of no momentum; with any where there is none."""
    tangents = workspace[-CHANGES:]
    z, v = tangents[:2, VECTOR].tolist()
    size = max(abs(z), abs(v))
    if not 0.0 < size < math.inf:
        z = v = 1.0
    elif size < _SHORT:  # not even whose square is above 0
        z, v = z / size, v / size
    tangents[:] = 0.0
    tangents[:2, VECTOR] = np.array([z, v]) / math.sqrt(_square(coefficients, z, v))
    tangents[_ZV, AREA] = 1.0


class Plane(NamedTuple):
    """What a step changes of vector and area."""

    z: float  # of the vector
    v: float
    zv: float  # of the area
    zm: float
    vm: float
    logarithm: float  # of what the area has been divided by
    divergence: float  # its integral


@formula
def carried(plane: Plane, over: Transition, length: float, mode: int, coefficients: Coefficients) -> Plane:
    """Vector and area after a step of that length: m stays, and z and v change by the transition."""
    z_z, z_v, v_z, v_v = over
    change = -1.0 * (mobility_of(coefficients, mode) * coefficients.damping * length)
    # The area of a foot that sticks shrinks as the divergence says, with no error of the transition's.
    flat = (plane.zm == 0.0) & (plane.vm == 0.0)
    return Plane(
        z_z * plane.z + z_v * plane.v,
        v_z * plane.z + v_v * plane.v,
        plane.zv * where(flat, 1.0, exp(change)),
        z_z * plane.zm + z_v * plane.vm,
        v_z * plane.zm + v_v * plane.vm,
        plane.logarithm + where(flat, change, 0.0),
        plane.divergence + change,
    )


@compiled
def carry_growth(
    over: Transition, length: float, body: Body, coefficients: Coefficients, tangents: NDArray[np.float64]
) -> None:
    """Carry vector and area over a step: see `carried`."""
    before = Plane(
        tangents[_Z, VECTOR],
        tangents[_V, VECTOR],
        tangents[_ZV, AREA],
        tangents[_ZM, AREA],
        tangents[_VM, AREA],
        tangents[_LOGARITHM, AREA],
        tangents[_DIVERGENCE, COUNTS],
    )
    after = carried(before, over, length, body.mode, coefficients)
    tangents[_Z, VECTOR], tangents[_V, VECTOR] = after.z, after.v
    tangents[_ZV, AREA], tangents[_ZM, AREA], tangents[_VM, AREA] = after.zv, after.zm, after.vm
    tangents[_LOGARITHM, AREA], tangents[_DIVERGENCE, COUNTS] = after.logarithm, after.divergence
    rescale_growth(tangents)


@compiled
def saltate_growth(event: Saltation, mode: int, coefficients: Coefficients, tangents: NDArray[np.float64]) -> None:
    """Carry vector and area across an event before which the foot is in `mode`."""
    payload = coefficients.payload_fraction
    z, v = tangents[_Z, VECTOR], tangents[_V, VECTOR]
    w = tangents[_M, VECTOR] - payload * v if mode != STUCK else 0.0
    later = event.later_z * z + event.later_v * v + event.later_w * w
    v += event.by_later_v * later
    w += event.by_later_w * later
    tangents[_V, VECTOR] = v
    tangents[_M, VECTOR] = 0.0 if event.stops else w + payload * v

    # The wedges of z, v and w with each other and with `later`.
    zv, vw = tangents[_ZV, AREA], tangents[_VM, AREA]
    zw = tangents[_ZM, AREA] - payload * zv if mode != STUCK else 0.0
    z_later = event.later_v * zv + event.later_w * zw
    v_later = event.later_w * vw - event.later_z * zv
    w_later = -event.later_z * zw - event.later_v * vw
    zv += event.by_later_v * z_later
    zw += event.by_later_w * z_later
    vw += event.by_later_w * v_later - event.by_later_v * w_later
    tangents[_ZV, AREA] = zv
    tangents[_ZM, AREA] = 0.0 if event.stops else zw + payload * zv
    tangents[_VM, AREA] = 0.0 if event.stops else vw
    if event.stops:
        tangents[_STOPS, COUNTS] += 1.0
    rescale_growth(tangents)


@compiled
def note_growth(coefficients: Coefficients, tangents: NDArray[np.float64], into: NDArray[np.float64]) -> None:
    """Write down how far vector and area have grown.

    The vector is measured as a linear body that sticks has it: there every change shrinks by exp(-Pi2 t / (1 - r)),
    without the swings that another measure shows, where Pi2^2 < 1 - r.
    """
    z, v, m = tangents[_Z, VECTOR], tangents[_V, VECTOR], tangents[_M, VECTOR]
    into[0] = tangents[_LOGARITHM, VECTOR] + 0.5 * math.log(_square(coefficients, z, v) + m * m)
    area = tangents[_ZV, AREA] ** 2 + tangents[_ZM, AREA] ** 2 + tangents[_VM, AREA] ** 2
    into[1] = tangents[_LOGARITHM, AREA] + 0.5 * math.log(area)
    into[2], into[3] = tangents[_DIVERGENCE, COUNTS], tangents[_STOPS, COUNTS]


@formula
def _square(coefficients: Coefficients, z: float, v: float) -> float:
    """Square of the size of a change of z and v."""
    stiffness = mobility_of(coefficients, STUCK)
    decay = 0.5 * stiffness * coefficients.damping
    if decay * decay < stiffness:
        return (v + decay * z) * (v + decay * z) + (stiffness - decay * decay) * z * z
    return v * v + stiffness * z * z


@formula
def is_handy(x: float, y: float, z: float) -> bool:
    """Whether vector or area can be left as long as it is."""
    size = abs(x) + abs(y) + abs(z)
    return ((size > _SHORT) & (size < _LONG)) | (size == 0.0)


@compiled
def rescale_growth(tangents: NDArray[np.float64]) -> None:
    """Bring vector and area to a handy length, and note by how much."""
    _rescale(VECTOR, tangents)
    _rescale(AREA, tangents)


@compiled
def _rescale(column: int, tangents: NDArray[np.float64]) -> None:
    x, y, z = tangents[0, column], tangents[1, column], tangents[2, column]
    if is_handy(x, y, z):
        return
    size = abs(x) + abs(y) + abs(z)
    for row in range(_LOGARITHM):
        tangents[row, column] /= size
    tangents[_LOGARITHM, column] += math.log(size)
