"""The body driven by a sequence of valve states or duty cycles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.sharing import processors
from ..common.validation import number_within, whole_number
from .arguments import batch_of, start_of, TOLERANCES
from .batch.lane_runs import write_in_order
from .batch_simulation import Batch, drive_batch, Driven
from .model.columns import different
from .model.groups import GroupsLike
from .model.scene import Scene
from .model.state import ChainState, FOOT, Ledger, REST, SLIPS, State
from .model.tube import is_chain
from .motion.balance import Balance, balance_each, balance_of, check_balance, Store
from .refusals import solver_error, SolverError, warn_of_slips
from .solvers import AUTO, NAMES, SOLVERS
from .steps.options import FINISHED
from .trajectory import EVENT, Trajectory

__all__ = ["simulate"]

# Fewer short slips than these are those of a body that hardly moves.
_MANY_SLIPS = 100


def simulate(
    groups: GroupsLike | Sequence[GroupsLike],
    valve: ArrayLike,
    hold: float | str | Sequence[float | str] | NDArray[np.float64],
    *,
    scene: Scene | Mapping[str, Any] | Sequence[Scene | Mapping[str, Any] | None] | None = None,
    tolerance: float = 1e-9,
    solver: str = "auto",
    samples_per_hold: int = 1,
    initial: State | ChainState | None = None,
    max_steps: int | None = None,
    condition: bool = False,
    threads: int | None = None,
) -> Trajectory:
    """Drive one crawler, or a batch, by a sequence of valve states or of duty cycles.

    Rows of a batch may differ in groups, valve, hold and scene. Each gives, to the last bit, what it gives alone.

    Parameters
    ----------
    groups : Groups, str, mapping or Actuator, or sequence of them
        Each as in `Groups.of`: one for all, or one a row of the batch.
    valve : (holds,) or (batch, holds) array, in [0, 1]
        Duty cycles, one schedule for all or one a row of the batch: the valve is open for the first ``duty * hold`` of
        each hold and shut for the rest, so that 1 keeps it open throughout and 0 shut. It turns at that very instant,
        and the samples stay where they are.
    hold : float or str, or (batch,) array or sequence of them, in (0, inf)
        Time between duty cycles: one for all or one a row of the batch. A number is in natural units. A text has a
        unit: "20 ms" or "0.02 s" where groups is an `Actuator`, whose t_c says how much natural time that is, or
        "0.5 t_c".
    scene : Scene or mapping, or sequence of them, optional
        Each as in `Scene.of`, on the ground with a ratcheted foot by default: one for all or one a row of the batch, of
        the same number of segments.
    tolerance : float, in [1e-15, 1e-2]
        Largest term neglected from the acceleration's Taylor series in a step, or largest error of deformation, rate
        and force in a step of "radau", natural units. The closed form is exact to rounding whatever the tolerance. A
        foot that nothing holds (no friction, no ratchet) turns round at every swing: that is an event once the foot
        moves the other way faster than 4 tolerances times the payload's share of the mass.
    solver : {"auto", "closed_form", "taylor", "radau"}
        "closed_form" takes groups with duffing = radial_coupling = 0; "taylor" is cheapest for most others, and
        "radau", L-stable, for stiff ones. "auto" takes the one that is predicted to be cheapest.
    samples_per_hold : int, >= 1
        Equally spaced in each hold, the last at its end.
    initial : State or ChainState, optional
        At rest by default; the same for the whole batch. A `State` stretches all segments alike.
    max_steps : int, optional
        Steps that each crawler may take in all; a million and a thousand a hold by default, fewer for long chains.
    condition : bool
        Whether to find `Trajectory.condition`: how far the end moves for a change of the start.
    threads : int, optional
        Most that share a batch; as many as there are processors to run on by default.

    Returns
    -------
    Trajectory
        Arrays (holds * samples_per_hold,), or (batch, holds * samples_per_hold) where any argument is a batch.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of its range or of the wrong type, "closed_form" is asked for of groups that are not
        linear, or `condition` of a chain of heavy segments, or if the samples have no room; the message names it.
    SolverError
        If the motion diverges (it can where Pi5 > 1 and Pi1 = 0) or takes more than `max_steps`; of a batch the message
        names the row.

    Warns
    -----
    EnergyWarning
        If the energies of a run do not add up, by more than the solver's error explains.
    SlipWarning
        If "taylor" counted many slips which are shorter on average than its tolerance: it may make them itself.
    """
    batch, single, shared = batch_of(groups, valve, hold, scene)
    tolerance = number_within("tolerance", tolerance, TOLERANCES)
    if not isinstance(solver, str) or (solver != AUTO and solver not in SOLVERS):
        raise ValueError(f"solver must be one of {[AUTO, *SOLVERS]}, got {solver!r}")
    samples_per_hold = whole_number("samples_per_hold", samples_per_hold, 1)
    if type(condition) is not bool and not isinstance(condition, np.bool_):
        raise TypeError(f"condition must be True or False, got {condition!r}")
    if condition and batch.chains.any():
        raise ValueError(f"condition must be False for a chain of heavy segments, got {condition!r}")
    start = REST if initial is None else initial
    for each in different(batch.scenes):
        body, stretches = start_of(start, each)
    driven = drive_batch(
        batch,
        body,
        stretches,
        solver=solver,
        tolerance=tolerance,
        samples_per_hold=samples_per_hold,
        max_steps=None if max_steps is None else whole_number("max_steps", max_steps, 1),
        condition=bool(condition),
        threads=processors() if threads is None else whole_number("threads", threads, 1),
    )
    runs = driven.runs
    failed = (runs.statuses > FINISHED).nonzero()[0]
    scales, suspects = _balanced(driven, tolerance)
    for i in suspects.tolist():
        if len(failed) == 0 or i < failed[0]:
            balance = _balance_of_one(batch, driven, i, tolerance)
            name, whose = NAMES[driven.solvers[i]], "" if single else f"crawler {i}: "
            check_balance(balance, batch.crawlers[i], batch.scenes[i], tolerance, name, whose)
    if len(failed):
        error = _error(batch, driven, int(failed[0]), tolerance)
        raise error if single else SolverError(f"crawler {failed[0]}: {error}")

    (work, viscous, friction, _), slips = runs.ledgers, runs.bodies[SLIPS].astype(np.int64)
    for i in np.flatnonzero((slips >= _MANY_SLIPS) & (driven.solvers == NAMES.index("taylor"))).tolist():
        kinetic = batch.crawlers[i].kinetic_friction
        length = friction[i] / kinetic / slips[i] if kinetic > 0.0 else math.inf
        if length < tolerance:
            whose = "" if single else f"crawler {i}: "
            warn_of_slips(int(slips[i]), length, tolerance, batch.scenes[i], whose)

    fractions = np.arange(1, samples_per_hold + 1) / samples_per_hold
    grid = (np.arange(batch.schedule.shape[1])[:, np.newaxis] + fractions).ravel()

    def shaped(values: NDArray[Any]) -> Any:
        return values[0] if single else values

    return Trajectory(
        time=grid * batch.holds[0] if shared else grid * batch.holds[:, None],
        deformation=shaped(runs.samples[:, 0]),
        velocity=shaped(runs.samples[:, 1]),
        pressure=shaped(runs.samples[:, 2]),
        foot=shaped(runs.samples[:, 3]),
        foot_velocity=shaped(runs.samples[:, 4]),
        segment_deformation=shaped(driven.parts[:, 0]),
        segment_velocity=shaped(driven.parts[:, 1]),
        valve=shaped(batch.schedule),
        slips=int(slips[0]) if single else slips,
        events=_events(driven),
        work=shaped(work),
        stored=shaped(driven.store.growth),
        viscous_loss=shaped(viscous),
        friction_loss=shaped(friction),
        energy_scale=shaped(scales),
        hold=float(batch.holds[0]) if shared else batch.holds,
        model=_model(batch, driven.solvers),
        groups=batch.crawlers[0] if single else tuple(batch.crawlers),
        scene=batch.scenes[0] if single else tuple(batch.scenes),
        initial=deepcopy(start) if isinstance(start, ChainState) else start,
        condition=(float(driven.conditions[0]) if single else driven.conditions) if condition else None,
    )


def _balanced(driven: Driven, tolerance: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Scales of the energies, and crawlers whose energies may not add up."""
    runs = driven.runs
    errors = tolerance * (driven.solvers != NAMES.index("closed_form"))
    # The rounding of the foot's way, which would take a look at all samples, is left to the suspects.
    scales, suspect = balance_each(runs.ledgers, driven.store, runs.steps, errors)
    return scales, (suspect & (runs.statuses == FINISHED)).nonzero()[0]


def _balance_of_one(batch: Batch, driven: Driven, i: int, tolerance: float) -> Balance:
    runs = driven.runs
    return balance_of(
        Ledger(*runs.ledgers[:, i].tolist()),
        Store(float(driven.store.growth[i]), float(driven.store.size[i])),
        int(runs.steps[i]),
        0.0 if NAMES[driven.solvers[i]] == "closed_form" else tolerance,
        max(abs(float(runs.bodies[FOOT, i])), float(np.abs(runs.samples[i, 3]).max())),
        batch.crawlers[i].kinetic_friction + abs(batch.scenes[i].slope),
    )


def _error(batch: Batch, driven: Driven, i: int, tolerance: float) -> SolverError:
    """Why a crawler has failed."""
    runs = driven.runs
    return solver_error(
        int(runs.statuses[i]),
        float(runs.finished[i] * batch.holds[i] + runs.elapsed[i]),
        float(runs.bodies[0, i]),
        int(runs.steps[i]),
        batch.crawlers[i],
        batch.scenes[i],
        tolerance,
        NAMES[driven.solvers[i]],
        int(runs.bodies[SLIPS, i]),
    )


def _events(driven: Driven) -> NDArray[np.void]:
    """The events of all, crawler by crawler in order of time."""
    counts = driven.runs.events
    ends = counts.cumsum()
    events, places = np.empty(ends[-1], EVENT), ends - counts
    for log in driven.logs:
        write_in_order(log, places, events["time"], events["mode"], events["crawler"])
    return events


def _model(batch: Batch, solvers: NDArray[np.int8]) -> str:
    """What was integrated, and by which solver."""
    kinds = set(zip(map(id, batch.scenes), solvers.tolist(), strict=True))
    scenes = {id(scene): scene for scene in batch.scenes}
    found = {(_where(scenes[scene]), NAMES[solver].replace("_", " ")) for scene, solver in kinds}
    return "; ".join(f"{where}, {name}" for where, name in sorted(found))


def _where(scene: Scene) -> str:
    where = "anchored" if scene.anchored else "on the ground"
    if is_chain(scene):
        return f"chain of {scene.segments} segments, {where}"
    if scene.segments > 1:
        return f"{scene.segments} massless segments as one, {where}"
    if scene.tube_mass > 0.0:
        return f"half the tube's mass at each end, {where}"
    return where
