"""The solvers by name, and the choice among them."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .closed_form.loop import is_linear, require_linear
from .cost import predicted_cost, predicted_steps
from .model.groups import Groups
from .model.scene import Scene
from .model.state import Coefficients
from .model.tube import is_chain
from .steps.options import ClosedForm, MAX_STEPS, Method, Options, Radau, STEPS_A_HOLD, TAYLOR
from .steps.propagator import tabulate
from .steps.radau import stages_for
from .steps.taylor import order_for
from .steps.workspace import ROWS, WIDTH

__all__ = ["AUTO", "SOLVERS", "Solver", "choose", "solvers_for"]

AUTO = "auto"
# Steps counted over steps predicted, which few exceed.
_DOUBT = 2.0


class Solver(NamedTuple):
    """One way to drive a crawler."""

    name: str
    method: Callable[[int], Method]  # of an order
    workspace: Callable[[Coefficients, float, int], NDArray[np.float64]]  # of a crawler, a hold and samples in a hold
    order_for: Callable[[float], int]  # of a tolerance

    def options(
        self,
        tolerance: float,
        *,
        energy: bool = False,
        log: bool = False,
        tangents: bool = False,
        max_steps: int = MAX_STEPS,
    ) -> Options:
        """Settings that integrate to `tolerance`, with the order that makes it cheapest."""
        order = self.order_for(tolerance)
        return Options(tolerance, order, max_steps, energy, log, tangents, self.method(order))


def _series(_coefficients: Coefficients, _hold: float, _samples_per_hold: int) -> NDArray[np.float64]:
    return np.empty((ROWS, WIDTH))


SOLVERS = {
    solver.name: solver
    for solver in (
        Solver("closed_form", lambda _order: ClosedForm(), tabulate, lambda _tolerance: 0),
        Solver("taylor", lambda order: TAYLOR[order](), _series, order_for),
        Solver("radau", lambda _order: Radau(), _series, stages_for),
    )
}


def choose(name: str, groups: Groups, scene: Scene, hold: float, tolerance: float) -> Solver:
    """Solver of that name, or for "auto" the one predicted to be cheapest of those that keep to the step budget.

    Raises
    ------
    ValueError
        If the solver cannot take the groups or the scene; the message names what is in the way.
    """
    able = solvers_for(groups, scene)
    if name == AUTO:
        name = able[0] if len(able) == 1 else _cheapest(able, groups, scene, hold, tolerance)
    if name not in able and is_chain(scene):
        raise ValueError(f"solver must be one of {[AUTO, *able]} for a chain of heavy segments, got {name!r}")
    if name == "closed_form":
        require_linear(groups)
    return SOLVERS[name]


def _cheapest(able: tuple[str, ...], groups: Groups, scene: Scene, hold: float, tolerance: float) -> str:
    case = groups, scene, hold, tolerance
    steps = {name: hold * predicted_steps(name, *case) for name in able}
    cost = {name: predicted_cost(name, *case) for name in able}
    cheapest = min(able, key=cost.__getitem__)
    if steps[cheapest] > STEPS_A_HOLD:
        # Rather dear than not finished, where another surely finishes.
        return min(able, key=lambda name: (steps[name] * _DOUBT > STEPS_A_HOLD, cost[name]))
    return cheapest


def solvers_for(groups: Groups, scene: Scene) -> tuple[str, ...]:
    """Names of the solvers that can take the groups in the scene."""
    if is_chain(scene):
        return ("taylor",)
    return tuple(name for name in SOLVERS if name != "closed_form" or is_linear(groups))
