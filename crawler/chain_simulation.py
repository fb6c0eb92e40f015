"""A chain for `simulate`: where it begins, its run, and the energy it stores."""

import numpy as np
from numpy.typing import NDArray

from ..common.validation import finite_array
from .drive import drive
from .model.groups import Groups
from .model.scene import Scene
from .model.state import Body, ChainState
from .model.tube import is_chain, node_masses
from .motion.balance import Store, store_between
from .motion.sampling import BODY_ROWS
from .steps.chain_series import chain_coefficients, chain_order, chain_workspace
from .steps.options import LOG_FULL, Options, Outcome, TaylorChain

__all__ = ["run_chain", "stretches_of"]


def stretches_of(initial: ChainState, scene: Scene) -> NDArray[np.float64]:
    """The stretches D = N d and D' of the segments, shape (2, segments).

    Raises
    ------
    ValueError
        If `initial` has another number of segments than `scene`, is not finite, or stretches massless segments
        unevenly: they all pull alike.
    TypeError
        If the stretches are not arrays of real numbers.
    """
    segments = scene.segments
    stretches = np.empty((2, segments))
    for row, name in zip(stretches, ("segment_deformation", "segment_velocity"), strict=True):
        values = finite_array(f"initial {name}", getattr(initial, name), 1)
        if len(values) != segments:
            raise ValueError(f"initial {name} must have segments = {segments} values, got {len(values)}")
        if not is_chain(scene) and np.ptp(values) > 0.0:
            raise ValueError(f"initial {name} must be the same for all segments where tube_mass is 0, got {values}")
        row[:] = segments * values
    return stretches


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
    """Advance one chain through its schedule; the arrays are those of `drive_chain`, and `stretches` are left alone.

    Returns
    -------
    outcome : Outcome
    finished : int
        Holds completed.
    events : (events, 2) array
        Times and new motions.
    stored : Store
    """
    coefficients = chain_coefficients(groups, scene)
    options = options._replace(order=chain_order(options.order), method=TaylorChain())
    rows = np.empty((BODY_ROWS + 2 * scene.segments, samples.shape[1]))
    capacity = 64 + 4 * len(schedule)
    while True:
        events, workspace = np.empty((capacity, 2)), chain_workspace(groups, scene, stretches)
        outcome, finished = drive(body, coefficients, schedule, hold, options, rows, events, workspace)
        if outcome.status != LOG_FULL:
            samples[:] = rows[:BODY_ROWS]
            segment_samples[:] = rows[BODY_ROWS:].reshape(segment_samples.shape)
            before = _stored(body, stretches, groups, scene)
            after = _stored(outcome.body, workspace.stretches, groups, scene)
            return outcome, finished, events[: outcome.logged], store_between(before, after)
        capacity *= 2


def _stored(body: Body, stretches: NDArray[np.float64], groups: Groups, scene: Scene) -> tuple[float, float]:
    """Kinetic and elastic energy, and potential energy, in units of P_max A_0 z_c."""
    masses = node_masses(groups, scene)
    places, rates = np.cumsum(np.vstack([[body.foot, body.foot_velocity], stretches.T / scene.segments]), axis=0).T
    kinetic = 0.5 * masses @ rates**2
    elastic = np.mean(0.5 * stretches[0] ** 2 + 0.25 * groups.duffing * stretches[0] ** 4)
    return float(kinetic + elastic), float(scene.slope * (masses @ places))
