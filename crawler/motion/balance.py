"""Whether the energies of a run add up: work done = energy stored + energy lost, but for the solver's error.

The balance knows nothing of how a run was made. An event that was missed, a foot that moves when it should not and a
wrong step break it by as much as they change the motion.
"""

import warnings
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, formula
from ..model.equations import elastic_energy
from ..model.groups import Groups
from ..model.scene import Scene
from ..model.state import Body, Coefficients, coefficients_of, Ledger
from ..model.tube import node_masses

__all__ = [
    "Balance",
    "EnergyWarning",
    "Store",
    "balance_each",
    "balance_of",
    "check_balance",
    "store_between",
    "stored_by_chain",
    "stored_by_crawler",
]

# A step errs by a part of the tolerance in the force, which acts along the way of that step. Of 25,000 sound runs none
# needed more than 0.02 tolerances and 5 roundings a step (`tests/crawler/test_attack.py`).
_TOLERANCES, _ROUNDINGS = 0.5, 100.0 * float(np.finfo(np.float64).eps)


class EnergyWarning(RuntimeWarning):
    """The energies of a run do not add up: its numbers contradict the conservation of energy."""


class Store(NamedTuple):
    """What a body stores, or each of many, in units of P_max A_0 z_c."""

    growth: Any  # of kinetic, elastic and potential energy
    size: Any  # kinetic and elastic energy at the start and at the end, added


class Balance(NamedTuple):
    """Energies of a run, or of each of many, in units of P_max A_0 z_c."""

    residual: Any  # work less what is stored and lost
    scale: Any  # sum of the sizes of all energies
    allowed: Any  # largest residual that the solver's error explains


def stored_by_crawler(body: Body, coefficients: Coefficients) -> tuple[Any, Any]:
    """Kinetic and elastic energy, and potential energy, of a crawler of one massless segment; of arrays too."""
    r, payload, z = coefficients.foot_fraction, coefficients.payload_fraction, body.deformation
    foot_rate, payload_rate = body.foot_velocity, body.foot_velocity + body.velocity
    kinetic = 0.5 * (r * foot_rate * foot_rate + payload * payload_rate * payload_rate)
    return kinetic + elastic_energy(coefficients, z), coefficients.slope * (body.foot + payload * z)


def stored_by_chain(body: Body, stretches: NDArray[np.float64], groups: Groups, scene: Scene) -> tuple[float, float]:
    """Kinetic and elastic energy, and potential energy, of a chain with those stretches D and D'."""
    masses = node_masses(groups, scene)
    places, rates = np.cumsum(np.vstack([[body.foot, body.foot_velocity], stretches.T / scene.segments]), axis=0).T
    kinetic = 0.5 * masses @ rates**2
    elastic = np.mean(elastic_energy(coefficients_of(groups, scene), stretches[0]))
    return float(kinetic + elastic), float(scene.slope * (masses @ places))


def store_between(before: tuple[Any, Any], after: tuple[Any, Any]) -> Store:
    """What is stored, from (kinetic and elastic, potential) energy at the start and at the end."""
    return Store(sum(after) - sum(before), before[0] + after[0])


def balance_of(ledger: Ledger, store: Store, steps: Any, tolerance: Any, farthest: Any, rubbing: Any) -> Balance:
    """The balance of one run, or of many, whose numbers are then arrays.

    Parameters
    ----------
    ledger : Ledger
    store : Store
    steps : number
        That the run took.
    tolerance : number
        0 for the closed form.
    farthest : number
        Largest distance of the foot from 0, to which the rounding of its way is relative.
    rubbing : number
        Force that does work along that way: kinetic friction and the weight along the slope.
    """
    return _balance(ledger, store, steps, tolerance, farthest, rubbing, _TOLERANCES, _ROUNDINGS)


@formula
def _balance(
    ledger: Ledger,
    store: Store,
    steps: Any,
    tolerance: Any,
    farthest: Any,
    rubbing: Any,
    tolerances: float,
    roundings: float,
) -> Balance:
    """What `balance_of` returns, allowing each step so many tolerances and so much rounding."""
    residual = ledger.work - store.growth - ledger.viscous - ledger.friction
    scale = ledger.flow + store.size
    # A force's error acts on a body whose speed is at most the root of twice its energy over its mass.
    error = tolerances * tolerance * (np.sqrt(scale) + tolerance)
    rounding = roundings * (1.0 + scale + rubbing * farthest)
    return Balance(residual, scale, steps * (error + rounding))


def balance_each(
    ledgers: NDArray[np.float64], store: Store, steps: NDArray[np.int64], tolerances: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Balance many runs, but for the rounding of the foot's way.

    Parameters
    ----------
    ledgers : (4, n) array
        Fields of `Ledger`.
    store : Store
        Of arrays (n,).
    steps, tolerances : (n,) arrays
        As `balance_of` has them.

    Returns
    -------
    scales : (n,) array
        Of each balance.
    suspect : (n,) array of bool
        Whether the residual is larger than allowed, or no number.
    """
    scales, suspect = np.empty(len(steps)), np.empty(len(steps), np.bool_)
    _balance_each(ledgers, store, steps, tolerances, _TOLERANCES, _ROUNDINGS, scales, suspect)
    return scales, suspect


@compiled
def _balance_each(
    ledgers: NDArray[np.float64],
    store: Store,
    steps: NDArray[np.int64],
    errors: NDArray[np.float64],
    tolerances: float,
    roundings: float,
    scales: NDArray[np.float64],
    suspect: NDArray[np.bool_],
) -> None:
    for i in range(len(steps)):
        ledger = Ledger(ledgers[0, i], ledgers[1, i], ledgers[2, i], ledgers[3, i])
        stored = Store(store.growth[i], store.size[i])
        balance = _balance(ledger, stored, steps[i], errors[i], 0.0, 0.0, tolerances, roundings)
        scales[i] = balance.scale
        suspect[i] = not abs(balance.residual) <= balance.allowed


def check_balance(
    balance: Balance, groups: Groups, scene: Scene, tolerance: float, solver: str, whose: str = ""
) -> None:
    """Warn where the energies of a run do not add up.

    Warns
    -----
    EnergyWarning
        If the residual is larger than the solver's error explains, or no number.
    """
    if abs(balance.residual) <= balance.allowed:
        return
    warnings.warn(
        f"{whose}the energies do not add up: {balance.residual:.3g} of the work is neither stored nor lost, where "
        f"{balance.scale:.3g} flowed and solver {solver!r} at tolerance {tolerance:g} explains {balance.allowed:.2g}. "
        f"This result contradicts the conservation of energy: do not use it; try another solver, and report {groups} "
        f"in {scene}",
        EnergyWarning,
        stacklevel=3,
    )
