"""Whole runs: a body through its schedule with room for its events, and the energy it stores; or how changes grow."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .drive import drive
from .model.groups import Groups
from .model.scene import Scene
from .model.state import Body, Coefficients, NOTHING_YET
from .motion.balance import Store, store_between, stored_by_chain, stored_by_crawler
from .motion.sampling import BODY_ROWS
from .solvers import Solver
from .stability.chain_growth import start_chain_growth
from .stability.lyapunov import GROWTH_ROWS, start_growth
from .stability.sensitivity import PARAMETERS, QUANTITIES, sensitive_workspace, SensitiveWorkspace
from .stability.tangent import condition_of, start_changes
from .steps.chain_series import chain_coefficients, chain_order, chain_workspace, ChainWorkspace
from .steps.options import AFRESH, FINISHED, LOG_FULL, Options, Outcome, TaylorChain, TaylorSensitive
from .steps.workspace import CHANGES

__all__ = ["run_chain", "run_chain_growth", "run_crawler", "run_growth", "run_sensitive"]


def run_crawler(
    body: Body,
    coefficients: Coefficients,
    unit: float,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    solver: Solver,
) -> tuple[Outcome, int, NDArray[np.float64], Store, float]:
    """Advance any tube that is one body through its schedule, in its own unit of time.

    Parameters
    ----------
    body : Body
    coefficients : Coefficients
        As `as_crawler` has the groups.
    unit : float
        Of time, from `as_crawler`.
    schedule, hold, options
    samples : (5, holds * samples_per_hold) array
        Receives z, v, p, x, w.
    solver : Solver

    Returns
    -------
    outcome : Outcome
    finished : int
        Holds completed.
    events : (events, 2) array
        Times and new motions.
    stored : Store
    condition : float
        As in `Trajectory`; nan unless `options` has the tangents carried.
    """
    start = body
    if unit != 1.0:
        start = body._replace(velocity=body.velocity * unit, foot_velocity=body.foot_velocity * unit)
    workspace = solver.workspace(coefficients, hold / unit, samples.shape[1] // len(schedule))

    def begin() -> NDArray[np.float64]:
        if options.tangents:
            start_changes(workspace, start.mode)
        return workspace

    outcome, finished, events, _ = _run(start, coefficients, schedule, hold / unit, options, samples, begin)
    stored = store_between(stored_by_crawler(start, coefficients), stored_by_crawler(outcome.body, coefficients))
    if unit != 1.0:
        samples[[1, 4]] /= unit
        events[:, 0] *= unit
        outcome = outcome._replace(elapsed=outcome.elapsed * unit)
    condition = condition_of(workspace, unit) if options.tangents else math.nan
    return outcome, finished, events, stored, condition


def run_growth(
    body: Body,
    coefficients: Coefficients,
    unit: float,
    schedule: NDArray[np.float64],
    washout: int,
    hold: float,
    options: Options,
    solver: Solver,
) -> tuple[Outcome, int, NDArray[np.float64]]:
    """Advance any tube that is one body through its schedule, and small changes of it along.

    Parameters
    ----------
    body, coefficients, unit, schedule, hold, options, solver
        As for `run_crawler`; the options have the tangents carried, and no events logged.
    washout : int
        Holds after which the changes begin, in the direction that they have turned to.

    Returns
    -------
    outcome : Outcome
    finished : int
        Holds completed.
    growth : (GROWTH_ROWS, holds - washout) array
        Of `note_growth`, at the end of each hold after the washout.
    """
    start = body._replace(velocity=body.velocity * unit, foot_velocity=body.foot_velocity * unit)
    workspace = solver.workspace(coefficients, hold / unit, 1)
    workspace[-CHANGES:] = 0.0

    def begin() -> None:
        start_growth(coefficients, workspace)

    outcome, finished, growth = _grow(
        start, coefficients, schedule, washout, hold / unit, options, BODY_ROWS, workspace, begin
    )
    return outcome._replace(elapsed=outcome.elapsed * unit), finished, growth


def run_sensitive(
    body: Body,
    coefficients: Coefficients,
    unit: float,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples_per_hold: int,
) -> tuple[Outcome, int, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Advance any tube that is one body through its schedule, and its sensitivities along, in its own unit of time.

    Parameters
    ----------
    body, coefficients, unit, schedule, hold
        As for `run_crawler`.
    options : Options
        Those of Taylor series.
    samples_per_hold : int

    Returns
    -------
    outcome : Outcome
    finished : int
        Holds completed.
    samples : (5 + 5 * parameters, holds * samples_per_hold) array
        Of z, v, p, x and w, and of their derivatives by the parameters, in the body's own unit of time.
    events : (events, 2) array
        Times and new motions, likewise.
    shifts : (events, parameters) array
        Derivatives of the times.
    """
    start = body._replace(velocity=body.velocity * unit, foot_velocity=body.foot_velocity * unit)
    options = options._replace(tangents=True, log=True, method=TaylorSensitive())
    samples = np.empty((BODY_ROWS + QUANTITIES * len(PARAMETERS), len(schedule) * samples_per_hold))
    capacity = 0

    def begin() -> SensitiveWorkspace:
        nonlocal capacity
        capacity = max(2 * capacity, 64 + 4 * len(schedule))
        return sensitive_workspace(options.order, capacity)

    outcome, finished, events, workspace = _run(start, coefficients, schedule, hold / unit, options, samples, begin)
    return outcome, finished, samples, events, workspace.shifts[: len(events)]


def run_chain_growth(
    body: Body,
    stretches: NDArray[np.float64],
    groups: Groups,
    scene: Scene,
    schedule: NDArray[np.float64],
    washout: int,
    hold: float,
    options: Options,
) -> tuple[Outcome, int, NDArray[np.float64]]:
    """Advance one chain through its schedule, and small changes of it along; as `run_chain` and `run_growth`."""
    options = options._replace(order=chain_order(options.order), method=TaylorChain())
    workspace = chain_workspace(groups, scene, stretches)

    def begin() -> None:
        start_chain_growth(workspace)

    rows = BODY_ROWS + 2 * scene.segments
    return _grow(body, chain_coefficients(groups, scene), schedule, washout, hold, options, rows, workspace, begin)


def _grow(
    body: Body,
    coefficients: Coefficients,
    schedule: NDArray[np.float64],
    washout: int,
    hold: float,
    options: Options,
    body_rows: int,
    workspace: Any,
    begin: Callable[[], None],
) -> tuple[Outcome, int, NDArray[np.float64]]:
    """Drive a body twice, through the washout and then through the rest, and `begin` with its changes before each."""
    outcome, finished, growth = Outcome(FINISHED, 0.0, 0, 0, body, NOTHING_YET, AFRESH), 0, np.empty((GROWTH_ROWS, 0))
    for part in (schedule[:washout], schedule[washout:]):
        if outcome.status == FINISHED and len(part):
            begin()
            samples = np.empty((body_rows + GROWTH_ROWS, len(part)))
            left = options._replace(max_steps=options.max_steps - outcome.steps)
            following, done = drive(outcome.body, coefficients, part, hold, left, samples, np.empty((0, 2)), workspace)
            outcome, finished = following._replace(steps=following.steps + outcome.steps), finished + done
            growth = samples[body_rows:]
    return outcome, finished, growth


def run_chain(
    body: Body,
    stretches: NDArray[np.float64],
    groups: Groups,
    scene: Scene,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    segment_samples: NDArray[np.float64],
) -> tuple[Outcome, int, NDArray[np.float64], Store]:
    """Advance one chain through its schedule.

    Parameters
    ----------
    body : Body
        Its deformation and velocity are the means of `stretches`.
    stretches : (2, N) array
        D and D' of the segments, foot first.
    groups, scene, schedule, hold, options
    samples : (5, holds * samples_per_hold) array
        Receives z, v, p, x, w.
    segment_samples : (2, N, holds * samples_per_hold) array
        Receives d and d' of the segments.

    Returns
    -------
    outcome, finished, events, stored
        As for `run_crawler`.
    """
    options = options._replace(order=chain_order(options.order), method=TaylorChain())
    rows = np.empty((BODY_ROWS + 2 * scene.segments, samples.shape[1]))

    def begin() -> ChainWorkspace:
        return chain_workspace(groups, scene, stretches)

    outcome, finished, events, workspace = _run(
        body, chain_coefficients(groups, scene), schedule, hold, options, rows, begin
    )
    samples[:] = rows[:BODY_ROWS]
    segment_samples[:] = rows[BODY_ROWS:].reshape(segment_samples.shape)
    before = stored_by_chain(body, stretches, groups, scene)
    after = stored_by_chain(outcome.body, workspace.stretches, groups, scene)
    return outcome, finished, events, store_between(before, after)


def _run(
    body: Body,
    coefficients: Coefficients,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    begin: Callable[[], Any],
) -> tuple[Outcome, int, NDArray[np.float64], Any]:
    """Drive a body with room for all its events, from the workspace that `begin` gives; return the events and that."""
    capacity = 64 + 4 * len(schedule)
    while True:
        events, workspace = np.empty((capacity, 2)), begin()
        outcome, finished = drive(body, coefficients, schedule, hold, options, samples, events, workspace)
        if outcome.status != LOG_FULL:
            return outcome, finished, events[: outcome.logged], workspace
        capacity *= 2
