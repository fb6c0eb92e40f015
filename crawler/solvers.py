"""The solvers by name, and the choice among them."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .closed_form.parts import is_linear, require_linear
from .cost import cheapest_of_each, PREDICTED
from .model.columns import chains_of_each, coefficients_of_each, linear_of_each, units_of
from .model.groups import Groups
from .model.scene import Scene
from .model.state import Coefficients
from .model.tube import is_chain
from .steps.options import ClosedForm, MAX_STEPS, Method, Options, Radau, TAYLOR
from .steps.propagator import tabulate
from .steps.radau import stages_for
from .steps.taylor import order_for
from .steps.workspace import ROWS, WIDTH

__all__ = ["AUTO", "NAMES", "SOLVERS", "Solver", "cheapest", "choose", "choose_for_each", "solvers_for"]

AUTO = "auto"


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
NAMES = tuple(SOLVERS)
"""By the places that stand for them; those of `PREDICTED`, among which "auto" chooses, come first, in their order."""


def choose(name: str, groups: Groups, scene: Scene, hold: float, tolerance: float) -> Solver:
    """Solver of that name, or for "auto" the one predicted to be cheapest of those that keep to the step budget.

    Raises
    ------
    ValueError
        If the solver cannot take the groups or the scene; the message names what is in the way.
    """
    able = solvers_for(groups, scene)
    if name == AUTO:
        name = able[0] if len(able) == 1 else cheapest(groups, scene, hold, tolerance)
    _refuse_unable(name, groups, scene)
    return SOLVERS[name]


def choose_for_each(
    name: str,
    groups: Sequence[Groups],
    scenes: Sequence[Scene],
    coefficients: NDArray[np.float64],
    holds: NDArray[np.float64],
    units: NDArray[np.float64],
    tolerance: float,
) -> NDArray[np.int8]:
    """What `choose` chooses for each of n crawlers, as an index into `NAMES`.

    Parameters
    ----------
    name : str
    groups, scenes : sequences of length n
    coefficients : (11, n) array
        Of each crawler, as `as_crawler` has it, in the columns of `coefficients_of_each`.
    holds, units : (n,) arrays
        Units of time are those of `as_crawler`.
    tolerance : float

    Returns
    -------
    (n,) array of int8

    Raises
    ------
    ValueError
        As `choose`.
    """
    chains = chains_of_each(scenes)
    if name == AUTO:
        choices = cheapest_of_each(coefficients, holds, units, tolerance)
        choices[chains] = NAMES.index("taylor")
        return choices
    unable = chains & (name != "taylor") if name != "closed_form" else chains | ~linear_of_each(coefficients)
    for i in np.flatnonzero(unable)[:1].tolist():
        _refuse_unable(name, groups[i], scenes[i])
    return np.full(len(groups), NAMES.index(name), np.int8)


def _refuse_unable(name: str, groups: Groups, scene: Scene) -> None:
    able = solvers_for(groups, scene)
    if name not in able and is_chain(scene):
        raise ValueError(f"solver must be one of {[AUTO, *able]} for a chain of heavy segments, got {name!r}")
    if name == "closed_form":
        require_linear(groups)


# Crawlers are often alike from one call to the next.
@lru_cache(maxsize=1024)
def cheapest(groups: Groups, scene: Scene, hold: float, tolerance: float) -> str:
    """Name of the solver that "auto" takes, where there is more than one."""
    bodies, scenes, units = units_of([groups], [scene])
    columns = coefficients_of_each(bodies, scenes)
    return PREDICTED[cheapest_of_each(columns, np.array([hold]), units, tolerance)[0]]


def solvers_for(groups: Groups, scene: Scene) -> tuple[str, ...]:
    """Names of the solvers that can take the groups in the scene."""
    if is_chain(scene):
        return ("taylor",)
    return tuple(name for name in SOLVERS if name != "closed_form" or is_linear(groups))
