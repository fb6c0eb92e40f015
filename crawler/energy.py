"""The energies that pass through a crawler in a step."""

import numpy as np
from numpy.typing import NDArray

from ..compilation import merged
from .body import Body, Ledger, Physics
from .recurrence import write_energies
from .workspace import STEP, VISCOUS, WORK

__all__ = ["account"]


@merged
def account(
    ledger: Ledger,
    before: Body,
    after: Body,
    physics: Physics,
    order: int,
    length: float,
    series: NDArray[np.float64],
) -> Ledger:
    """Add one step's energies: int p (1 + Pi5 z) v dt (equation S28), int 2 Pi2 v^2 dt, and drag times distance."""
    inputs = (length, physics.radial_coupling)
    if order == 8:
        write_energies(8, inputs, series)
    elif order <= 12:  # a collocation's polynomials are of any degree up to this, and padded with zeros
        write_energies(12, inputs, series)
    elif order == 16:
        write_energies(16, inputs, series)
    else:
        write_energies(20, inputs, series)
    return Ledger(
        ledger.work + series[STEP, WORK],
        ledger.viscous + physics.damping * series[STEP, VISCOUS],
        ledger.friction + physics.kinetic_friction * abs(after.foot - before.foot),
    )
