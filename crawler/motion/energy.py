"""The energies that pass through a crawler in a step."""

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import formula, merged
from ..model.state import Body, Coefficients, Ledger
from ..steps.options import Method
from ..steps.taylor_series import write_energies
from ..steps.workspace import STEP, VISCOUS, WORK

__all__ = ["account", "posted"]


@merged
def account(
    ledger: Ledger,
    before: Body,
    after: Body,
    coefficients: Coefficients,
    method: Method,
    length: float,
    series: NDArray[np.float64],
) -> Ledger:
    """Add one step's energies: int p (1 + Pi5 z) v dt (equation S28), int 2 Pi2 v^2 dt, and drag times distance."""
    inputs = (length, coefficients.radial_coupling)
    write_energies(method, inputs, series)
    return posted(ledger, before, after, coefficients, series[STEP, WORK], coefficients.damping * series[STEP, VISCOUS])


@formula
def posted(
    ledger: Ledger, before: Body, after: Body, coefficients: Coefficients, work: float, viscous: float
) -> Ledger:
    """Add a step's work and heat, and what follows from the way that the foot and the centre of mass have gone."""
    way = after.foot - before.foot
    friction = coefficients.kinetic_friction * abs(way)
    rise = coefficients.slope * (way + coefficients.payload_fraction * (after.deformation - before.deformation))
    return Ledger(
        ledger.work + work,
        ledger.viscous + viscous,
        ledger.friction + friction,
        ledger.flow + (abs(work) + abs(viscous) + friction + abs(rise)),
    )
