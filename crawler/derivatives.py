"""How a driven crawler's motion moves with its groups, through slips and stops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import number_within, whole_number
from .arguments import schedule_of, start_of, TOLERANCES
from .batch_simulation import most_steps
from .model.columns import coefficients_of_each, coefficients_of_one, units_of
from .model.groups import Groups, GroupsLike
from .model.scene import Scene
from .model.state import REST, State
from .model.tube import is_chain
from .model.variations import HOLDS
from .motion.sampling import BODY_ROWS
from .refusals import solver_error
from .runs import run_sensitive
from .solvers import SOLVERS
from .stability.sensitivity import PARAMETERS, QUANTITIES
from .steps.options import FINISHED

__all__ = ["PARAMETERS", "Sensitivities", "sensitivities"]

# One for all tolerances: at 1e-6 a series of order 12 is hardly cheaper, and each order takes long to compile.
_ORDER = 20
_CHANNELS = ("deformation", "velocity", "pressure", "foot", "foot_velocity")
_RATES = [_CHANNELS.index(name) for name in _CHANNELS if name.endswith("velocity")]


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """A motion and its derivatives by what it depends on, at the same samples as `simulate` has them.

    Attributes
    ----------
    names : tuple of str
        Of the 8 parameters: the groups in their order, and "hold".
    time : (samples,) array
    deformation, velocity, pressure, foot, foot_velocity, payload : (samples, parameters) array
        Derivatives of the quantity, in natural units, by each parameter. By the hold they are those at the same share
        of the hold, at a time that grows with it.
    motion : dict of str to (samples,) array
        The quantities themselves.
    event_time : (events,) array
        When the foot broke loose, stopped or turned round.
    event_mode : (events,) array of int
        What followed: 0 if it stuck, 1 or -1 if it slid forward or backward.
    event_shift : (events, parameters) array
        Derivatives of `event_time`.
    groups : Groups
    """

    names: tuple[str, ...]
    time: NDArray[np.float64]
    deformation: NDArray[np.float64]
    velocity: NDArray[np.float64]
    pressure: NDArray[np.float64]
    foot: NDArray[np.float64]
    foot_velocity: NDArray[np.float64]
    motion: dict[str, NDArray[np.float64]]
    event_time: NDArray[np.float64]
    event_mode: NDArray[np.int8]
    event_shift: NDArray[np.float64]
    groups: Groups

    @property
    def payload(self) -> NDArray[np.float64]:
        """Derivatives of the payload's position, foot + deformation, (samples, parameters)."""
        payload: NDArray[np.float64] = self.foot + self.deformation
        return payload


def sensitivities(
    groups: GroupsLike,
    valve: ArrayLike,
    hold: float,
    *,
    scene: Scene | Mapping[str, Any] | None = None,
    tolerance: float = 1e-9,
    samples_per_hold: int = 1,
    initial: State | None = None,
    max_steps: int | None = None,
) -> Sensitivities:
    """Derivatives of a crawler's motion by its groups and by the length of its holds, through every event.

    They ride in the Taylor series of the motion, and jump at slips and stops by what the parameter does to the event's
    time: where a parameter makes or unmakes a slip the motion has a kink, and the derivative is that of one side.

    Parameters
    ----------
    groups : Groups, str, mapping or Actuator
        As in `Groups.of`.
    valve : (holds,) array, in [0, 1]
        Duty cycles, as for `simulate`.
    hold : float, in (0, inf)
    scene : Scene or mapping, optional
        Any but a chain of heavy segments.
    tolerance : float, in [1e-15, 1e-2]
        As for `simulate`; of a sensitivity the series errs by up to 64 times as much, relative to it.
    samples_per_hold : int, >= 1
    initial : State, optional
        At rest by default; it does not move with the parameters.
    max_steps : int, optional
        As for `simulate`.

    Returns
    -------
    Sensitivities

    Raises
    ------
    ValueError, TypeError
        If an argument is out of its range or of the wrong type; the message names it.
    SolverError
        As `simulate`.
    """
    body, ground = Groups.of(groups), Scene.of(scene)
    schedule = schedule_of(valve, ("(holds,)",)).astype(np.float64)
    hold = number_within("hold", hold, HOLDS)
    tolerance = number_within("tolerance", tolerance, TOLERANCES)
    each = whole_number("samples_per_hold", samples_per_hold, 1)
    if is_chain(ground):
        raise ValueError(f"scene must be no chain of heavy segments, got {ground}")
    start, _ = start_of(REST if initial is None else initial, ground)
    bodies, grounds, units = units_of([body], [ground])
    unit = float(units[0])
    budget = most_steps(len(schedule), 1) if max_steps is None else whole_number("max_steps", max_steps, 1)
    options = SOLVERS["taylor"].options(tolerance, max_steps=budget)._replace(order=_ORDER)
    coefficients = coefficients_of_one(coefficients_of_each(bodies, grounds), 0)
    outcome, finished, samples, events, shifts = run_sensitive(start, coefficients, unit, schedule, hold, options, each)
    if outcome.status != FINISHED:
        time = finished * hold + outcome.elapsed * unit
        z, slips = outcome.body.deformation, int(outcome.body.slips)
        raise solver_error(outcome.status, time, z, outcome.steps, body, ground, tolerance, "taylor", slips)

    samples[_RATES] /= unit
    moved = samples[BODY_ROWS:].reshape(QUANTITIES, len(PARAMETERS), -1)
    moved[_RATES] /= unit
    by_own = _own_units(unit)
    moved *= by_own[:, np.newaxis]
    fractions = np.arange(1, each + 1) / each
    return Sensitivities(
        names=PARAMETERS,
        time=(np.arange(len(schedule))[:, np.newaxis] + fractions).ravel() * hold,
        **{name: np.ascontiguousarray(moved[i].T) for i, name in enumerate(_CHANNELS)},
        motion={name: samples[i] for i, name in enumerate(_CHANNELS)},
        event_time=events[:, 0] * unit,
        event_mode=events[:, 1].astype(np.int8),
        event_shift=shifts * unit * by_own,
        groups=body,
    )


def _own_units(unit: float) -> NDArray[np.float64]:
    """Derivatives of a crawler's own parameters, see `as_crawler`, by those of the groups and the hold."""
    mass = unit * unit
    changed = {"damping_ratio": 1.0 / unit, "deborah": 1.0 / unit, "foot_mass_fraction": 1.0 / mass, "hold": 1.0 / unit}
    return np.array([changed.get(name, 1.0) for name in PARAMETERS])
