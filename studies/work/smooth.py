"""A crawler whose friction is smooth: Coulomb's law regularised, by a plain Runge-Kutta method without events.

The foot feels k tanh(w / width) against its velocity w, which is Coulomb's kinetic friction k sign(w) with the jump at
rest drawn out: it creeps where the crawler's foot sticks, nothing ever starts or stops, and the equations are those of
smooth mechanics. As the width falls, motions come to those of a foot that may slide back and whose static friction is
no more than its kinetic one (V. Acary and B. Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008,
section 1.1). A static friction above the kinetic one has no such limit: what decides then is the history, not the
velocity.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...crawler import Groups, State
from .ensembles import Works

__all__ = ["smooth_works"]

_Array = NDArray[np.float64]
_STEP, _RESOLVED = 0.025, 0.3  # longest step, and longest over the time in which friction stops a creeping foot


def smooth_works(
    groups: Groups,
    valves: NDArray[np.int64],
    starts: Sequence[State],
    *,
    hold: float,
    width: float,
    washout: int = 0,
) -> Works:
    """Energies of every input from every start, between the end of the washout and the end.

    Parameters
    ----------
    groups : Groups
        Its static friction is not used.
    valves : (inputs, holds) array of 0 and 1
    starts : sequence of State
        Deformation, velocity and pressure; the foot is at rest.
    hold : float, > 0
        Natural time.
    width : float, > 0
        Velocity of the foot over which friction changes its sign, z_c / t_c.
    washout : int
        Holds at the start that do not count.

    Returns
    -------
    Works
    """
    lanes = len(valves) * len(starts)
    opened = np.repeat(valves.T.astype(np.float64), len(starts), axis=1)
    # Deformation, its rate, the foot's velocity, and the work, the viscous loss and the loss to friction so far.
    state = np.zeros((6, lanes))
    *state[:2], pressure = np.tile(np.array([start[:3] for start in starts]).T, len(valves))
    before, stored = state[3:].copy(), _energy(groups, state)
    for place, valve in enumerate(opened):
        if place == washout:
            before, stored = state[3:].copy(), _energy(groups, state)
        pressure = _hold(groups, width, state, pressure, valve, hold)
    work, viscous, friction = state[3:] - before
    grown = _energy(groups, state) - stored
    turned_over = np.abs(work) + viscous + friction + np.abs(grown)
    residual = np.abs(work - grown - viscous - friction) / np.maximum(turned_over, np.finfo(float).tiny)
    shape = len(valves), len(starts)
    return Works(
        work=work.reshape(shape),
        stored=grown.reshape(shape),
        viscous=viscous.reshape(shape),
        friction=friction.reshape(shape),
        residual=float(residual.max()),
    )


def _hold(groups: Groups, width: float, state: _Array, pressure: _Array, valve: _Array, hold: float) -> _Array:
    """Move the state through a hold by the classical method of order four; the pressure, returned, is exact."""
    stopping = width * groups.foot_mass_fraction / max(groups.kinetic_friction, 1e-9)
    steps = int(np.ceil(hold / min(_STEP, _RESOLVED * stopping)))
    step = hold / steps
    half = np.exp(-0.5 * step / groups.deborah)
    gap = pressure - valve
    rates, sum_of_rates = np.empty_like(state), np.empty_like(state)
    for _ in range(steps):
        middle = gap * half
        here = state
        sum_of_rates[:] = 0.0
        for share, ahead, at in ((1.0, 0.5, gap), (2.0, 0.5, middle), (2.0, 1.0, middle), (1.0, 0.0, middle * half)):
            _rates(groups, width, here, valve + at, rates)
            sum_of_rates += share * rates
            here = state + (ahead * step) * rates
        state += (step / 6.0) * sum_of_rates
        gap = middle * half
    return np.asarray(valve + gap)


def _rates(groups: Groups, width: float, state: _Array, pressure: _Array, rates: _Array) -> None:
    """Write equations 1, 8 and 9 with smooth friction, and what work and losses grow by."""
    z, v, foot = state[:3]
    share = groups.foot_mass_fraction
    push = pressure * (1.0 + groups.radial_coupling * z)
    drag = (2.0 * groups.damping_ratio) * v
    friction = groups.kinetic_friction * np.tanh(foot / width)
    force = push - z * (1.0 + groups.duffing * z * z) - drag
    rates[0] = v
    rates[2] = (force + friction) / -share
    rates[1] = force / (1.0 - share) - rates[2]
    rates[3] = push * v
    rates[4] = drag * v
    rates[5] = friction * foot


def _energy(groups: Groups, state: _Array) -> _Array:
    """Elastic and kinetic."""
    z, v, foot = state[:3]
    share = groups.foot_mass_fraction
    elastic = 0.5 * z * z * (1.0 + 0.5 * groups.duffing * z * z)
    return np.asarray(elastic + 0.5 * share * foot**2 + 0.5 * (1.0 - share) * (foot + v) ** 2)
