"""The solver behind plain arrays.

A named tuple costs microseconds to carry across the border between Python and compiled code, many times the physics
of a hold; an array costs a fraction of one.
"""

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled
from ..crawler.advance import advance, Control, control_for
from ..crawler.body import Body, Ledger, Physics, physics
from ..crawler.groups import Groups
from ..crawler.scene import Scene

__all__ = ["hold_valve", "rest", "settings"]

_BODY = len(Body._fields)
_PHYSICS = len(Physics._fields)


def rest() -> NDArray[np.float64]:
    """State of a crawler at rest: the fields of `Body` in order, shape (7,)."""
    return np.zeros(_BODY)


def settings(groups: Groups, scene: Scene, hold: float, tolerance: float) -> NDArray[np.float64]:
    """What stays the same from step to step: the fields of `Physics`, then hold, tolerance, order and step budget."""
    control = control_for(tolerance)
    return np.array([*physics(groups, scene), hold, control.tolerance, control.order, control.max_steps])


@compiled
def hold_valve(
    body: NDArray[np.float64],
    fixed: NDArray[np.float64],
    valve: int,
    samples: NDArray[np.float64],
    series: NDArray[np.float64],
    observation: NDArray[np.float32],
) -> tuple[int, float]:
    """Advance one crawler by one hold, in place.

    Parameters
    ----------
    body : (7,) array
        From :func:`rest`; updated.
    fixed : array
        From :func:`settings`.
    valve : int
        0 or 1.
    samples : (5, virtual_nodes) array
        Receives z, v, p, x, w.
    series : (ROWS, WIDTH) array
        Scratch.
    observation : (5,) array of float32
        Receives z, v, p, w and the valve.

    Returns
    -------
    status : int
        As in `stickslip.crawler.advance`.
    elapsed : float
        Time into the hold that was reached.
    """
    outcome = advance(
        Body(body[0], body[1], body[2], body[3], body[4], int(body[5]), int(body[6])),
        Ledger(0.0, 0.0, 0.0),
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
        Control(fixed[_PHYSICS + 1], int(fixed[_PHYSICS + 2]), int(fixed[_PHYSICS + 3]), False, False),
        0.0,
        samples,
        np.empty((0, 2)),
        series,
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
