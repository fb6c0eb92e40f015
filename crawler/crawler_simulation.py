"""A crawler of one body for `simulate`: its run, and the energy it stores."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .drive import drive
from .model.groups import Groups
from .model.scene import Scene
from .model.state import Body, Coefficients, coefficients_of
from .model.tube import as_crawler
from .motion.balance import Store, store_between
from .motion.tangent import condition_of, start_changes
from .solvers import Solver
from .steps.options import LOG_FULL, Options, Outcome

__all__ = ["run_crawler", "stored_by"]


def run_crawler(
    body: Body,
    groups: Groups,
    scene: Scene,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    solver: Solver,
) -> tuple[Outcome, int, NDArray[np.float64], Store, float]:
    """Advance any tube that is one body through its schedule, in its own unit of time.

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
    groups, scene, unit = as_crawler(groups, scene)
    start = body._replace(velocity=body.velocity * unit, foot_velocity=body.foot_velocity * unit)
    coefficients = coefficients_of(groups, scene)
    workspace = solver.workspace(coefficients, hold / unit, samples.shape[1] // len(schedule))
    capacity = 64 + 4 * len(schedule)
    while True:
        events = np.empty((capacity, 2))
        start_changes(workspace, start.mode)
        outcome, finished = drive(start, coefficients, schedule, hold / unit, options, samples, events, workspace)
        if outcome.status != LOG_FULL:
            break
        capacity *= 2
    stored = store_between(stored_by(start, coefficients), stored_by(outcome.body, coefficients))
    events = events[: outcome.logged]
    if unit != 1.0:
        samples[[1, 4]] /= unit
        events[:, 0] *= unit
        outcome = outcome._replace(elapsed=outcome.elapsed * unit)
    condition = condition_of(workspace, unit) if options.tangents else math.nan
    return outcome, finished, events, stored, condition


def stored_by(body: Body, coefficients: Coefficients) -> tuple[Any, Any]:
    """Kinetic and elastic energy, and potential energy, in units of P_max A_0 z_c; of arrays too."""
    r, payload, z = coefficients.foot_fraction, coefficients.payload_fraction, body.deformation
    foot_rate, payload_rate = body.foot_velocity, body.foot_velocity + body.velocity
    kinetic = 0.5 * (r * foot_rate * foot_rate + payload * payload_rate * payload_rate)
    elastic = 0.5 * z * z * (1.0 + 0.5 * coefficients.duffing * z * z)
    return kinetic + elastic, coefficients.slope * (body.foot + payload * z)
