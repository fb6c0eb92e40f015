"""The solvers by name, and the choice among them."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .advance import advance
from .body import Physics
from .closed_form import tabulate
from .driving import driver
from .groups import Groups
from .linear import advance_linear, is_linear, require_linear
from .workspace import ROWS, WIDTH

__all__ = ["AUTO", "SOLVERS", "Solver", "choose", "solvers_for"]

AUTO = "auto"


class Solver(NamedTuple):
    """One way to drive a crawler."""

    name: str
    drive: Callable[..., Any]
    workspace: Callable[[Physics, float, int], NDArray[np.float64]]  # of a crawler, a hold and samples in a hold


def _series(_physics: Physics, _hold: float, _samples_per_hold: int) -> NDArray[np.float64]:
    return np.empty((ROWS, WIDTH))


SOLVERS = {
    solver.name: solver
    for solver in (
        Solver("closed_form", driver(advance_linear), tabulate),
        Solver("taylor", driver(advance), _series),
    )
}


def choose(name: str, groups: Groups) -> Solver:
    """Solver of that name, or for "auto" the cheapest that meets the tolerance.

    Raises
    ------
    ValueError
        If the solver cannot take the groups; the message names the one in the way.
    """
    if name == AUTO:
        name = "closed_form" if is_linear(groups) else "taylor"
    if name == "closed_form":
        require_linear(groups)
    return SOLVERS[name]


def solvers_for(groups: Groups) -> tuple[str, ...]:
    """Names of the solvers that can take the groups."""
    return tuple(name for name in SOLVERS if name != "closed_form" or is_linear(groups))
