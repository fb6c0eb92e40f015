"""The solver behind plain arrays.

A named tuple costs microseconds to carry across the border between Python and compiled code, many times the physics
of a hold; an array costs a fraction of one.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled, merged
from ..crawler.body import Body, NOTHING_YET, Physics, physics
from ..crawler.control import Control, FINISHED, MAX_STEPS, Method, METHODS
from ..crawler.driving import advance_by_method
from ..crawler.groups import Groups
from ..crawler.scene import Scene
from ..crawler.simulation import solver_error
from ..crawler.solvers import AUTO, choose
from .calibration import calibration_commands
from .settings import Settings

__all__ = ["Stepper", "calibration_states", "rest", "stepper_for"]

_BODY = len(Body._fields)
_PHYSICS = len(Physics._fields)


class Stepper(NamedTuple):
    """How one crawler is stepped, and what stays the same from step to step."""

    hold_valve: Callable[..., tuple[int, float]]
    fixed: NDArray[np.float64]  # the fields of `Physics`, then hold, tolerance, order and step budget
    workspace: NDArray[np.float64]
    solver: str


def rest() -> NDArray[np.float64]:
    """State of a crawler at rest: the fields of `Body` in order, shape (7,)."""
    return np.zeros(_BODY)


def stepper_for(groups: Groups, scene: Scene, hold: float, tolerance: float, virtual_nodes: int) -> Stepper:
    """The cheapest way to step a crawler, hold by hold."""
    coefficients = physics(groups, scene)
    solver = choose(AUTO, groups, scene, hold, tolerance)
    control = solver.control(tolerance)
    return Stepper(
        _HOLD_VALVE[type(control.method)],
        np.array([*coefficients, hold, control.tolerance, control.order, control.max_steps]),
        solver.workspace(coefficients, hold, virtual_nodes),
        solver.name,
    )


def calibration_states(settings: Settings) -> NDArray[np.float64]:
    """States of the body under the calibration's commands, from rest, shape (holds, features).

    Raises
    ------
    SolverError
        If the motion diverges.
    """
    _, valves = calibration_commands(settings)
    groups, scene, hold, tolerance = settings.groups, settings.scene, settings.hold, settings.tolerance
    hold_valve, fixed, workspace, solver = stepper_for(groups, scene, hold, tolerance, settings.samples)
    body, observation = rest(), np.empty(5, np.float32)
    samples = np.empty((5, settings.samples))
    states = np.empty((len(valves), settings.features))
    for k, valve in enumerate(valves.tolist()):
        status, elapsed = hold_valve(body, fixed, valve, samples, workspace, observation)
        if status != FINISHED:
            reached = k * hold + elapsed
            raise solver_error(status, reached, float(body[0]), MAX_STEPS, groups, scene, tolerance, solver)
        states[k] = samples[:3].reshape(-1)
    return states


@merged
def _hold_valve(
    method: Method,
    body: NDArray[np.float64],
    fixed: NDArray[np.float64],
    valve: int,
    samples: NDArray[np.float64],
    workspace: NDArray[np.float64],
    observation: NDArray[np.float32],
) -> tuple[int, float]:
    """Advance one crawler by one hold, in place.

    Parameters
    ----------
    method : Method
    body : (7,) array
        From :func:`rest`; updated.
    fixed : array
        From :func:`stepper_for`.
    valve : int
        0 or 1.
    samples : (5, virtual_nodes) array
        Receives z, v, p, x, w.
    workspace : array
        From :func:`stepper_for`.
    observation : (5,) array of float32
        Receives z, v, p, w and the valve.

    Returns
    -------
    status : int
        As in `stickslip.crawler.control`.
    elapsed : float
        Time into the hold that was reached.
    """
    outcome = advance_by_method(
        Body(body[0], body[1], body[2], body[3], body[4], int(body[5]), int(body[6])),
        NOTHING_YET,
        Physics(
            fixed[0],
            fixed[1],
            fixed[2],
            fixed[3],
            fixed[4],
            fixed[5],
            fixed[6],
            fixed[7],
            fixed[8],
            fixed[9] != 0.0,
            fixed[10] != 0.0,
        ),
        float(valve),
        fixed[_PHYSICS],
        Control(fixed[_PHYSICS + 1], int(fixed[_PHYSICS + 2]), int(fixed[_PHYSICS + 3]), False, False, method),
        0.0,
        samples,
        workspace[:0],
        workspace,
    )
    after = outcome.body
    body[0] = after.deformation
    body[1] = after.velocity
    body[2] = after.pressure
    body[3] = after.foot
    body[4] = after.foot_velocity
    body[5] = after.motion
    body[6] = after.slips
    observation[0] = after.deformation
    observation[1] = after.velocity
    observation[2] = after.pressure
    observation[3] = after.foot_velocity
    observation[4] = valve
    return outcome.status, outcome.elapsed


def _holder(method: type[Method]) -> Callable[..., tuple[int, float]]:
    # A method cannot be an argument from Python: it would cost more than the physics.
    @compiled
    def hold_valve(
        body: NDArray[np.float64],
        fixed: NDArray[np.float64],
        valve: int,
        samples: NDArray[np.float64],
        workspace: NDArray[np.float64],
        observation: NDArray[np.float32],
    ) -> tuple[int, float]:
        return _hold_valve(method(), body, fixed, valve, samples, workspace, observation)

    return hold_valve


_HOLD_VALVE = {method: _holder(method) for method in METHODS}
