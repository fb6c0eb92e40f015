"""Work and dissipation of one body over ensembles of inputs and of starts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...crawler import Groups, simulate, State
from ...tasks import random_bits

__all__ = ["Works", "boltzmann_starts", "far_starts", "random_valves", "works_of"]

_Array = NDArray[np.float64]


@dataclass(frozen=True)
class Works:
    """Energies of runs, each (inputs, starts), natural units P_max A_0 z_c.

    Attributes
    ----------
    work : array
        int P dV (equation S28).
    stored, viscous, friction : arrays
        Growth of elastic and kinetic energy, and what elastomer and ground take.
    residual : float
        Largest of abs(work - stored - viscous - friction) in a run, over all that was turned over in it: 0 but for the
        solver's error.
    """

    work: _Array
    stored: _Array
    viscous: _Array
    friction: _Array
    residual: float


def works_of(
    groups: Groups,
    valves: NDArray[np.int64],
    starts: Sequence[State],
    *,
    hold: float,
    scene: Mapping[str, Any] | None = None,
    washout: int = 0,
    tolerance: float = 1e-8,
) -> Works:
    """Energies of every input from every start, between the end of the washout and the end.

    Parameters
    ----------
    groups, hold, scene, tolerance
        As in `simulate`.
    valves : (inputs, holds) array of 0 and 1
    starts : sequence of State
    washout : int
        Holds at the start that do not count.

    Returns
    -------
    Works
    """
    names = ("work", "stored", "viscous_loss", "friction_loss")
    energies = np.zeros((len(names), len(valves), len(starts)))
    residual = 0.0
    for column, start in enumerate(starts):
        asked: dict[str, Any] = {"scene": scene, "initial": start, "tolerance": tolerance}
        whole = simulate(groups, valves, hold, **asked)
        residual = max(residual, float(np.max(np.abs(whole.energy_residual) / whole.energy_scale)))
        before = simulate(groups, valves[:, :washout], hold, **asked) if washout else None
        for row, name in enumerate(names):
            energies[row, :, column] = getattr(whole, name)
            if before is not None:
                energies[row, :, column] -= getattr(before, name)
    work, stored, viscous, friction = energies
    return Works(work, stored, viscous, friction, residual)


def random_valves(inputs: int, holds: int, shut: int = 0) -> NDArray[np.int64]:
    """Fair random bits of seeds 0, 1, ..., the valve shut for so many holds at the end: (inputs, holds + shut)."""
    bits = np.array([random_bits(holds, seed) for seed in range(inputs)])
    return np.pad(bits, ((0, 0), (0, shut)))


def far_starts(count: int) -> list[State]:
    """Starts anywhere in -0.5 to 0.5 of deformation and velocity and 0 to 1 of pressure, the foot at rest."""
    draws = np.random.default_rng(0).random((count, 3)) - (0.5, 0.5, 0.0)
    return [State(float(z), float(v), float(p)) for z, v, p in draws]


def boltzmann_starts(groups: Groups, beta: float, count: int, seed: int) -> list[State]:
    """Starts of an anchored body without pressure at exp(-beta H), H = (1 - r) v^2 / 2 + z^2 / 2 + Pi1 z^4 / 4.

    Exactly, by rejection: of the normal deformations of the linear body one stays with probability
    exp(-beta Pi1 z^4 / 4).
    """
    random = np.random.default_rng(seed)
    kept: list[float] = []
    while len(kept) < count:
        drawn = random.normal(0.0, beta**-0.5, count)
        stays = random.random(count) < np.exp(-0.25 * beta * groups.duffing * drawn**4)
        kept += drawn[stays].tolist()
    velocities = random.normal(0.0, (beta * (1.0 - groups.foot_mass_fraction)) ** -0.5, count)
    return [State(z, float(v)) for z, v in zip(kept, velocities, strict=False)]
