"""How a small change of the start moves the motion: tangent vectors, carried along the run.

From event to event the change of z and v goes by the `transition` of each step, and the foot follows from the momentum;
an event takes it on by its `saltation`.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ..model.state import Body, Coefficients, STUCK
from ..steps.propagator import Propagator
from ..steps.workspace import CHANGES
from .lyapunov import carry_growth, saltate_growth
from .saltation import Saltation, saltation_of
from .transition import Transition, transition

__all__ = ["carry", "carry_linear", "condition_of", "saltate", "start_changes"]

# Rows of the tangents: changes of z, v, x and w at this instant; a column each for a change of z, v and w at the start.
_DZ, _DV, _DX, _DW = range(CHANGES)
_COLUMNS = 3


def start_changes(workspace: NDArray[np.float64], mode: int) -> None:
    """Write the tangents at the start of a run: a foot at rest has no velocity to be changed."""
    changes = workspace[-CHANGES:]
    changes[:] = 0.0
    changes[_DZ, 0] = changes[_DV, 1] = 1.0
    changes[_DW, 2] = float(mode != STUCK)


def condition_of(workspace: NDArray[np.float64], unit: float) -> float:
    """Largest singular value of the tangents, whose time is in units of `unit`; inf beyond the range of floats."""
    changes = workspace[-CHANGES:, :_COLUMNS].copy()
    changes[[_DV, _DW]] /= unit
    changes[:, 1:] *= unit
    return float(np.linalg.norm(changes, 2)) if np.isfinite(changes).all() else math.inf


@compiled
def carry(body: Body, coefficients: Coefficients, order: int, length: float, series: NDArray[np.float64]) -> None:
    """Carry the tangents over a step.

    Parameters
    ----------
    body : Body
        At the step's start.
    coefficients : Coefficients
    order : int
        Degree of the pressure's polynomial; that of z is one more.
    length : float
        Of the step, up to its event.
    series : array
        The step's workspace; its tangents are moved in place.
    """
    _carry_by(transition(body, coefficients, order, length, series), body, coefficients, length, series)


@compiled
def carry_linear(
    body: Body, coefficients: Coefficients, over: Propagator, length: float, workspace: NDArray[np.float64]
) -> None:
    """Carry the tangents of a linear body by its propagator over the time `length`."""
    _carry_by(Transition(over.z_z, over.z_v, over.v_z, over.v_v), body, coefficients, length, workspace)


@compiled
def _carry_by(
    over: Transition, body: Body, coefficients: Coefficients, length: float, workspace: NDArray[np.float64]
) -> None:
    tangents = workspace[workspace.shape[0] - CHANGES :]
    payload = coefficients.payload_fraction
    for i in range(_COLUMNS):
        z, v = tangents[_DZ, i], tangents[_DV, i]
        moved_z = over.z_z * z + over.z_v * v
        moved_v = over.v_z * z + over.v_v * v
        tangents[_DZ, i], tangents[_DV, i] = moved_z, moved_v
        if body.mode != STUCK:
            w = tangents[_DW, i]
            tangents[_DX, i] += (w + payload * v) * length - payload * (moved_z - z)
            tangents[_DW, i] = w + payload * (v - moved_v)
    carry_growth(over, length, body, coefficients, tangents)


@compiled
def saltate(
    body: Body, mode: int, coefficients: Coefficients, valve: float, time: float, workspace: NDArray[np.float64]
) -> None:
    """Carry the tangents, the last rows of the workspace, across an event; the other arguments are `saltation_of`'s."""
    tangents = workspace[workspace.shape[0] - CHANGES :]
    event = saltation_of(body, mode, coefficients, valve, time)
    for i in range(_COLUMNS):
        _saltate_one(event, tangents[:, i])
    saltate_growth(event, body.mode, coefficients, tangents)


@compiled
def _saltate_one(event: Saltation, change: NDArray[np.float64]) -> None:
    later = event.later_z * change[_DZ] + event.later_v * change[_DV] + event.later_w * change[_DW]
    change[_DV] += event.by_later_v * later
    change[_DW] = 0.0 if event.stops else change[_DW] + event.by_later_w * later
