"""Holds of many crawlers."""

import numpy as np

from ..compilation import compiled
from .body import Body, Ledger, Physics
from .driving import advance_by_method


@compiled
def advance_lanes(
    bodies, coefficients, valves, skipped, begin, end, hold, control, samples, workspaces, statuses, elapsed
):
    """Advance each crawler of a slice by one hold."""
    own = np.empty((5, samples.shape[1]))
    for i in range(begin, end):
        if skipped[i]:
            continue
        c = coefficients
        physics = Physics(
            c[0, i],
            c[1, i],
            c[2, i],
            c[3, i],
            c[4, i],
            c[5, i],
            c[6, i],
            c[7, i],
            c[8, i],
            c[9, i] != 0.0,
            c[10, i] != 0.0,
        )
        outcome = advance_by_method(
            Body(
                bodies[0, i],
                bodies[1, i],
                bodies[2, i],
                bodies[3, i],
                bodies[4, i],
                int(bodies[5, i]),
                int(bodies[6, i]),
            ),
            Ledger(0.0, 0.0, 0.0),
            physics,
            float(valves[i]),
            hold,
            control,
            0.0,
            own,
            np.empty((0, 2)),
            workspaces[i if len(workspaces) > 1 else 0],
        )
        for q in range(3):
            for j in range(samples.shape[1]):
                samples[q, j, i] = own[q, j]
        after = outcome.body
        bodies[0, i] = after.deformation
        bodies[1, i] = after.velocity
        bodies[2, i] = after.pressure
        bodies[3, i] = after.foot
        bodies[4, i] = after.foot_velocity
        bodies[5, i] = after.motion
        bodies[6, i] = after.slips
        statuses[i] = outcome.status
        elapsed[i] = outcome.elapsed
