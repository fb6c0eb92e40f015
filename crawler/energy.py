"""The energies that pass through a crawler in a step."""

import numpy as np
from numpy.typing import NDArray

from ..compilation import merged
from .body import Body, Ledger, Physics
from .control import Method
from .recurrence import write_energies
from .workspace import STEP, VISCOUS, WORK

__all__ = ["account"]


@merged
def account(
    ledger: Ledger,
    before: Body,
    after: Body,
    physics: Physics,
    method: Method,
    length: float,
    series: NDArray[np.float64],
) -> Ledger:
    """Add one step's energies: int p (1 + Pi5 z) v dt (equation S28), int 2 Pi2 v^2 dt, and drag times distance."""
    inputs = (length, physics.radial_coupling)
    write_energies(method, inputs, series)
    return Ledger(
        ledger.work + series[STEP, WORK],
        ledger.viscous + physics.damping * series[STEP, VISCOUS],
        ledger.friction + physics.kinetic_friction * abs(after.foot - before.foot),
    )
