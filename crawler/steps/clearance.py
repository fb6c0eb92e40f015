"""How far a body is from its next event, by which the error of a step is judged."""

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ..model.equations import foot_velocity_at, force, is_free
from ..model.state import Body, Coefficients, STUCK
from .radau_table import TABLES
from .workspace import STAGE_F, STAGE_V

__all__ = ["clearance", "widest_clearance"]

_NODES = TABLES.nodes


@compiled
def clearance(body: Body, coefficients: Coefficients) -> float:
    """How far a grip is from breaking, in force, or a slip from stopping, in the rate of the body.

    A free foot that slides goes on alike whether it turns round or not.
    """
    if body.mode == STUCK:
        return _grip(coefficients, force(coefficients, body.deformation, body.velocity, body.pressure))
    if is_free(coefficients):
        return np.inf
    return abs(body.foot_velocity) / coefficients.payload_fraction


@compiled
def _grip(coefficients: Coefficients, pull: float) -> float:
    """How far the grip of a resting foot is from breaking under the force `pull`; negative beyond."""
    pull += coefficients.foot_fraction * coefficients.slope
    return coefficients.static_friction + (pull if coefficients.ratchet else -abs(pull))


@compiled
def widest_clearance(
    body: Body, coefficients: Coefficients, method: int, stages: int, length: float, series: NDArray[np.float64]
) -> float:
    """The largest clearance in the step that has been solved."""
    widest = clearance(body, coefficients)
    for i in range(1, stages + 1):
        if body.mode == STUCK:
            here = _grip(coefficients, series[STAGE_F, i])
        else:
            speed = foot_velocity_at(body, coefficients, series[STAGE_V, i], _NODES[method, i] * length)
            here = abs(speed) / coefficients.payload_fraction
        widest = max(widest, here)
    return widest
