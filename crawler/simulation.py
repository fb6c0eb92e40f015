"""The body driven by a sequence of valve states or duty cycles."""

import math
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import number_within, whole_number
from .chain_simulation import run_chain, stretches_of
from .crawler_simulation import run_crawler
from .model.groups import Groups, groups_of_each, GroupsLike
from .model.scene import Scene
from .model.state import BACKWARD, Body, ChainState, FORWARD, Ledger, REST, State, STUCK
from .model.tube import is_chain
from .model.variations import HOLDS
from .motion.balance import balance_of, check_balance
from .refusals import solver_error, SolverError
from .solvers import AUTO, choose, Solver, SOLVERS
from .steps.options import FINISHED, MAX_STEPS, STEPS_A_HOLD
from .trajectory import EVENT, Trajectory

__all__ = ["TOLERANCES", "simulate"]

TOLERANCES = "[1e-15, 1e-2]"
# The budget is one of work: a chain of many segments may take fewer steps.
_SEGMENTS_A_STEP = 10


def simulate(
    groups: GroupsLike | Sequence[GroupsLike],
    valve: ArrayLike,
    hold: float,
    *,
    scene: Scene | Mapping[str, Any] | None = None,
    tolerance: float = 1e-9,
    solver: str = "auto",
    samples_per_hold: int = 1,
    initial: State | ChainState | None = None,
    max_steps: int | None = None,
    condition: bool = False,
) -> Trajectory:
    """Drive one crawler, or a batch, by a sequence of valve states or of duty cycles.

    Parameters
    ----------
    groups : Groups, str, mapping or Actuator, or sequence of them
        Each as in `Groups.of`: one for all, or one a row of the batch.
    valve : (holds,) or (batch, holds) array, in [0, 1]
        Duty cycles, one schedule for all or one a row of the batch: the valve is open for the first ``duty * hold`` of
        each hold and shut for the rest, so that 1 keeps it open throughout and 0 shut. It turns at that very instant,
        and the samples stay where they are.
    hold : float, in (0, inf)
        Time between duty cycles, natural units.
    scene : Scene or mapping, optional
        As in `Scene.of`; on the ground with a ratcheted foot by default.
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

    Returns
    -------
    Trajectory
        Arrays (holds * samples_per_hold,), or (batch, holds * samples_per_hold) where groups or valve is a batch.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of its range or of the wrong type, "closed_form" is asked for of groups that are not
        linear, or `condition` of a chain of heavy segments; the message names it.
    SolverError
        If the motion diverges (it can where Pi5 > 1 and Pi1 = 0) or takes more than `max_steps`; of a batch the message
        names the row.

    Warns
    -----
    EnergyWarning
        If the energies of a run do not add up, by more than the solver's error explains.
    """
    scene = Scene.of(scene)
    hold = number_within("hold", hold, HOLDS)
    tolerance = number_within("tolerance", tolerance, TOLERANCES)
    if solver != AUTO and solver not in SOLVERS:
        raise ValueError(f"solver must be one of {[AUTO, *SOLVERS]}, got {solver!r}")
    samples_per_hold = whole_number("samples_per_hold", samples_per_hold, 1)
    if type(condition) is not bool and not isinstance(condition, np.bool_):
        raise TypeError(f"condition must be True or False, got {condition!r}")
    if condition and is_chain(scene):
        raise ValueError(f"condition must be False for a chain of heavy segments, got {condition!r}")
    crawlers, schedule, single = _batch(groups, valve)
    start = REST if initial is None else initial
    body, stretches = _start(start, scene)

    batch, holds = schedule.shape
    budget = (MAX_STEPS + STEPS_A_HOLD * holds) // max(1, scene.segments // _SEGMENTS_A_STEP)
    if max_steps is not None:
        budget = whole_number("max_steps", max_steps, 1)
    samples = np.empty((batch, 5, holds * samples_per_hold))
    parts = np.empty((batch, 2, scene.segments, samples.shape[2]) if is_chain(scene) else 0)
    finals: list[Body] = []
    ledgers: list[Ledger] = []
    logs: list[NDArray[np.void]] = []
    solvers = [choose(solver, groups_of, scene, hold, tolerance) for groups_of in crawlers]
    grown, scales, conditions = np.empty(batch), np.empty(batch), np.empty(batch)
    for member, (groups_of, by) in enumerate(zip(crawlers, solvers, strict=True)):
        options = by.options(tolerance, energy=True, log=True, tangents=bool(condition), max_steps=budget)
        row = schedule[member].astype(np.float64), hold, options, samples[member]
        if is_chain(scene):
            outcome, finished, events, store = run_chain(body, stretches, groups_of, scene, *row, parts[member])
        else:
            run = run_crawler(body, groups_of, scene, *row, by)
            outcome, finished, events, store, conditions[member] = run
        if outcome.status != FINISHED:
            reached = finished * hold + outcome.elapsed
            deformation, steps = outcome.body.deformation, outcome.steps
            error = solver_error(
                outcome.status, reached, deformation, steps, groups_of, scene, tolerance, by.name, outcome.body.slips
            )
            raise error if single else SolverError(f"crawler {member}: {error}")
        finals.append(outcome.body)
        ledgers.append(outcome.ledger)
        grown[member] = store.growth
        exact = by.name == "closed_form"
        balance = balance_of(
            outcome.ledger,
            store,
            outcome.steps,
            0.0 if exact else tolerance,
            max(abs(body.foot), float(np.abs(samples[member, 3]).max())),
            groups_of.kinetic_friction + abs(scene.slope),
        )
        check_balance(balance, groups_of, scene, tolerance, by.name, "" if single else f"crawler {member}: ")
        scales[member] = balance.scale
        log = np.empty(len(events), EVENT)
        log["time"], log["mode"], log["crawler"] = events[:, 0], events[:, 1], member
        logs.append(log)

    if not is_chain(scene):
        parts = samples[:, :2, None]
        if scene.segments > 1:
            parts = np.repeat(parts / scene.segments, scene.segments, axis=2)
    fractions = np.arange(1, samples_per_hold + 1) / samples_per_hold
    work, viscous, friction, _ = np.array(ledgers).reshape(batch, 4).T
    slips = np.array([after.slips for after in finals], dtype=np.int64)

    def shaped(values: NDArray[Any]) -> Any:
        return values[0] if single else values

    return Trajectory(
        time=(np.arange(holds)[:, None] + fractions).ravel() * hold,
        deformation=shaped(samples[:, 0]),
        velocity=shaped(samples[:, 1]),
        pressure=shaped(samples[:, 2]),
        foot=shaped(samples[:, 3]),
        foot_velocity=shaped(samples[:, 4]),
        segment_deformation=shaped(parts[:, 0]),
        segment_velocity=shaped(parts[:, 1]),
        valve=shaped(schedule),
        slips=int(slips[0]) if single else slips,
        events=np.concatenate(logs),
        work=shaped(work),
        stored=shaped(grown),
        viscous_loss=shaped(viscous),
        friction_loss=shaped(friction),
        energy_scale=shaped(scales),
        hold=hold,
        model=_model(scene, solvers),
        groups=crawlers[0] if single else tuple(crawlers),
        initial=deepcopy(start),
        condition=(float(conditions[0]) if single else conditions) if condition else None,
    )


def _batch(groups: GroupsLike | Sequence[GroupsLike], valve: ArrayLike) -> tuple[list[Groups], NDArray[Any], bool]:
    """Groups and schedules row by row, and whether there is one crawler only."""
    try:
        given = np.asarray(valve)
    except ValueError:
        raise ValueError("valve must have shape (holds,) or (batch, holds), got rows of different length") from None
    if given.ndim not in (1, 2) or given.size == 0:
        raise ValueError(f"valve must have shape (holds,) or (batch, holds) and not be empty, got {given.shape}")
    kind = given.dtype.kind
    wrong = np.argwhere(~((given >= 0) & (given <= 1))) if kind in "biuf" else np.zeros((1, given.ndim), int)
    if len(wrong):
        index = tuple(int(i) for i in wrong[0])
        raise ValueError(f"valve must hold only numbers in [0, 1], got {given[index]!r} at index {index}")
    schedule = given.astype(np.float64 if kind == "f" else np.int8)
    each = groups_of_each(groups)
    single = isinstance(each, Groups)
    crawlers = [each] if isinstance(each, Groups) else each
    if schedule.ndim == 1:
        return crawlers, np.broadcast_to(schedule, (len(crawlers), len(schedule))).copy(), single
    if single:
        return crawlers * len(schedule), schedule, False
    if len(crawlers) != len(schedule):
        raise ValueError(f"groups and valve must have as many rows, got {len(crawlers)} and {len(schedule)}")
    return crawlers, schedule, False


def _start(initial: State | ChainState, scene: Scene) -> tuple[Body, NDArray[np.float64]]:
    """The solver's state for the user's, and the stretches of its segments."""
    if not isinstance(initial, tuple) or len(initial) != len(State._fields):
        raise TypeError(f"initial must be a State or a ChainState, got {initial!r}")
    stretches = None
    if isinstance(initial, ChainState):
        stretches = stretches_of(initial, scene)
        z, v = stretches.mean(axis=1).tolist()
        initial = State(z, v, initial.pressure, initial.foot, initial.foot_velocity)
    ranges = dict.fromkeys(State._fields, "(-inf, inf)") | {"pressure": "[0, 1]"}
    state = State(
        *(number_within(f"initial {name}", value, ranges[name]) for name, value in zip(ranges, initial, strict=True))
    )
    slowest = 0.0 if scene.ratchet or scene.anchored else -math.inf
    fastest = 0.0 if scene.anchored else math.inf
    if not slowest <= state.foot_velocity <= fastest:
        raise ValueError(
            f"initial foot_velocity must be in [{slowest:g}, {fastest:g}] in {scene}, got {state.foot_velocity!r}"
        )
    mode = STUCK
    if state.foot_velocity != 0.0:
        mode = FORWARD if state.foot_velocity > 0.0 else BACKWARD
    if stretches is None:
        stretches = np.repeat([[state.deformation], [state.velocity]], scene.segments, axis=1)
    return Body(*state, mode, 0), stretches


def _model(scene: Scene, solvers: list[Solver]) -> str:
    """What was integrated, and by which solver."""
    where = "anchored" if scene.anchored else "on the ground"
    if is_chain(scene):
        where = f"chain of {scene.segments} segments, {where}"
    elif scene.segments > 1:
        where = f"{scene.segments} massless segments as one, {where}"
    elif scene.tube_mass > 0.0:
        where = f"half the tube's mass at each end, {where}"
    names = sorted({solver.name.replace("_", " ") for solver in solvers})
    return "; ".join(f"{where}, {name}" for name in names)
