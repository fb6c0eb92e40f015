"""How fast small changes of z and v grow: one vector and one area, carried along the run.

The growth of a vector is that of the first exponent, the growth of an area the sum of both. While the foot sticks the
changes of a body are a plane, of (z, v); a slip lets them out into the space of (z, v, m), m = w + (1 - r) v the
momentum, which stays while the foot slides, and a stop takes the plane that they have become to a plane of (z, v)
again. The area has three components there, that follow the compound matrix (B. S. Ng and W. H. Reid, J. Comput. Phys.
30 (1979) 125): it knows no angle between vectors that could be lost, however stiff the body. Its component in (z, v)
shrinks as the damping does.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, formula
from ..model.equations import mobility_of
from ..model.state import Body, Coefficients, STUCK
from ..steps.workspace import CHANGES
from .saltation import Saltation
from .transition import Transition

__all__ = ["GROWTH_ROWS", "carry_growth", "note_growth", "saltate_growth", "start_growth"]

# Columns of the tangents, after those of `tangent`: a vector (z, v, m) and an area (zv, zm, vm), each with the
# logarithm of what it has been divided by, and then the integral of the divergence and the number of stops.
_VECTOR, _AREA, _COUNTS = 3, 4, 5
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
    z, v = tangents[:2, _VECTOR].tolist()
    if not 0.0 < abs(z) + abs(v) < math.inf:
        z = v = 1.0
    tangents[:] = 0.0
    tangents[:2, _VECTOR] = np.array([z, v]) / math.sqrt(_square(coefficients, z, v))
    tangents[_ZV, _AREA] = 1.0


@compiled
def carry_growth(
    over: Transition, length: float, body: Body, coefficients: Coefficients, tangents: NDArray[np.float64]
) -> None:
    """Carry vector and area over a step of that length: m stays, and z and v change by the transition."""
    _by(over, _VECTOR, _Z, _V, tangents)
    change = -mobility_of(coefficients, body.mode) * coefficients.damping * length
    tangents[_DIVERGENCE, _COUNTS] += change
    if tangents[_ZM, _AREA] == 0.0 and tangents[_VM, _AREA] == 0.0:
        tangents[_LOGARITHM, _AREA] += change
    else:
        tangents[_ZV, _AREA] *= math.exp(change)
        _by(over, _AREA, _ZM, _VM, tangents)
        _rescale(_AREA, tangents)
    _rescale(_VECTOR, tangents)


@compiled
def saltate_growth(event: Saltation, mode: int, coefficients: Coefficients, tangents: NDArray[np.float64]) -> None:
    """Carry vector and area across an event before which the foot is in `mode`."""
    payload = coefficients.payload_fraction
    z, v = tangents[_Z, _VECTOR], tangents[_V, _VECTOR]
    w = tangents[_M, _VECTOR] - payload * v if mode != STUCK else 0.0
    later = event.later_z * z + event.later_v * v + event.later_w * w
    v += event.by_later_v * later
    w += event.by_later_w * later
    tangents[_V, _VECTOR] = v
    tangents[_M, _VECTOR] = 0.0 if event.stops else w + payload * v

    # The wedges of z, v and w with each other and with `later`.
    zv, vw = tangents[_ZV, _AREA], tangents[_VM, _AREA]
    zw = tangents[_ZM, _AREA] - payload * zv if mode != STUCK else 0.0
    z_later = event.later_v * zv + event.later_w * zw
    v_later = event.later_w * vw - event.later_z * zv
    w_later = -event.later_z * zw - event.later_v * vw
    zv += event.by_later_v * z_later
    zw += event.by_later_w * z_later
    vw += event.by_later_w * v_later - event.by_later_v * w_later
    tangents[_ZV, _AREA] = zv
    tangents[_ZM, _AREA] = 0.0 if event.stops else zw + payload * zv
    tangents[_VM, _AREA] = 0.0 if event.stops else vw
    if event.stops:
        tangents[_STOPS, _COUNTS] += 1.0
    _rescale(_VECTOR, tangents)
    _rescale(_AREA, tangents)


@compiled
def note_growth(coefficients: Coefficients, tangents: NDArray[np.float64], into: NDArray[np.float64]) -> None:
    """Write down how far vector and area have grown.

    The vector is measured as a linear body that sticks has it: there every change shrinks by exp(-Pi2 t / (1 - r)),
    without the swings that another measure shows, where Pi2^2 < 1 - r.
    """
    z, v, m = tangents[_Z, _VECTOR], tangents[_V, _VECTOR], tangents[_M, _VECTOR]
    into[0] = tangents[_LOGARITHM, _VECTOR] + 0.5 * math.log(_square(coefficients, z, v) + m * m)
    area = tangents[_ZV, _AREA] ** 2 + tangents[_ZM, _AREA] ** 2 + tangents[_VM, _AREA] ** 2
    into[1] = tangents[_LOGARITHM, _AREA] + 0.5 * math.log(area)
    into[2], into[3] = tangents[_DIVERGENCE, _COUNTS], tangents[_STOPS, _COUNTS]


@formula
def _square(coefficients: Coefficients, z: float, v: float) -> float:
    """Square of the size of a change of z and v."""
    stiffness = mobility_of(coefficients, STUCK)
    decay = 0.5 * stiffness * coefficients.damping
    if decay * decay < stiffness:
        return (v + decay * z) * (v + decay * z) + (stiffness - decay * decay) * z * z
    return v * v + stiffness * z * z


@compiled
def _by(over: Transition, column: int, first: int, second: int, tangents: NDArray[np.float64]) -> None:
    z, v = tangents[first, column], tangents[second, column]
    tangents[first, column] = over.z_z * z + over.z_v * v
    tangents[second, column] = over.v_z * z + over.v_v * v


@compiled
def _rescale(column: int, tangents: NDArray[np.float64]) -> None:
    size = abs(tangents[0, column]) + abs(tangents[1, column]) + abs(tangents[2, column])
    if _SHORT < size < _LONG or size == 0.0:
        return
    for row in range(_LOGARITHM):
        tangents[row, column] /= size
    tangents[_LOGARITHM, column] += math.log(size)
