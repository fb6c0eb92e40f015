"""C2: the crawler of one spring beside the chain of segments that its supplement derives, refined until it converges.

A tube of mass m between foot and payload can be lumped at its two ends. Half at each end keeps the total mass, with
which the whole slides; a third at each keeps the frequency of a body whose foot stands still (Lord Rayleigh, The Theory
of Sound, section 156), since a tube that stretches evenly moves with m / 3 of its mass. Both are one-spring crawlers of
other groups.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...crawler import Groups, Scene, simulate
from ...tasks import random_bits
from .asked import Asked
from .claim import Claim, interval, Number
from .real_body import BODY, body_with, TUBE_MASS
from .sindy import nmse
from .twin_exact import exact_deformation

__all__ = ["MASSES", "REGIMES", "SEGMENTS", "SHARES", "TWIN", "Twin", "claim", "good_up_to", "measure"]

REGIMES = {
    "nominal": Groups(),
    "high damping": Groups(damping_ratio=0.5),
    "aggressive forcing": Groups(duffing=2.0, radial_coupling=0.4, static_friction=0.15, kinetic_friction=0.1),
    "extreme fluid lag": Groups(deborah=3.0),
}
"""The paper's regimes. It gives no numbers; forcing by twice the pressure halves friction and doubles stretch."""
MASSES = (0.02, 0.05, 0.1, 0.2, 0.5)
"""Of the tube, over those of payload and foot."""
SEGMENTS = (2, 4, 8, 16)
_TUBE = TUBE_MASS / (BODY.mass - TUBE_MASS)
TWIN = 8
"""Segments of the chain that one spring is compared with."""
SHARES = {"half at each end": 0.5, "a third at each end": 1.0 / 3.0}
PAPER_NMSE, PAPER_LIMIT = 0.0028, 0.01
_HOLDS, _HOLD, _SAMPLES = 60, 1.0, 20
_TOLERANCE = 1e-8
_error = partial(interval, least=0.0)


@dataclass(frozen=True)
class Twin:
    """NMSE of z and of the foot, in this order along the first axis.

    Attributes
    ----------
    lumped : dict of (regime, share) to (2, masses, seeds) array
        One spring against the chain of 8 segments.
    refined : (2, segments - 1, masses, seeds) array
        Nominal chains against the finest.
    converged : dict of regime to (2, seeds) array
        The chain of 8 segments against the finest, at the largest mass.
    exact : float
        Largest error of z of a linear chain of 8 segments that stands still, against the exponential of its matrix.
    body : dict of share to (2, seeds) array
        NMSE of z of the real body with that share of its own tube at each end, against the chain of 8 segments, and
        the root mean square of the error in natural units.
    """

    lumped: dict[tuple[str, str], NDArray[np.float64]]
    refined: NDArray[np.float64]
    converged: dict[str, NDArray[np.float64]]
    exact: float
    body: dict[str, NDArray[np.float64]]


def measure(asked: Asked) -> Twin:
    """Chains and crawlers of one spring under fair random bits."""
    seeds = list(asked.seeds)
    lumped: dict[tuple[str, str], NDArray[np.float64]] = {
        (regime, share): np.empty((2, len(MASSES), len(seeds))) for regime in REGIMES for share in SHARES
    }
    refined = np.empty((2, len(SEGMENTS) - 1, len(MASSES), len(seeds)))
    converged = {regime: np.empty((2, len(seeds))) for regime in REGIMES}
    for column, seed in enumerate(seeds):
        valve = random_bits(_HOLDS, seed)
        for regime, groups in REGIMES.items():
            for row, mass in enumerate(MASSES):
                true = _chain(groups, mass, TWIN, valve)
                for share, part in SHARES.items():
                    lumped[regime, share][:, row, column] = _errors(_one_spring(groups, mass, part, valve), true)
            converged[regime][:, column] = _errors(true, _chain(groups, MASSES[-1], SEGMENTS[-1], valve))
        for row, mass in enumerate(MASSES):
            true = _chain(Groups(), mass, SEGMENTS[-1], valve)
            for place, segments in enumerate(SEGMENTS[:-1]):
                refined[:, place, row, column] = _errors(_chain(Groups(), mass, segments, valve), true)
    body = {share: np.array([_of_body(seed, part) for seed in seeds]).T for share, part in SHARES.items()}
    return Twin(lumped, refined, converged, _error_of_the_chain(seeds[0]), body)


def claim(twin: Twin) -> Claim:
    """C2, decided at a tube of a twentieth of the mass, by the better way of lumping."""
    at = MASSES.index(0.05)
    worst = {share: max(float(twin.lumped[regime, share][0, at].max()) for regime in REGIMES) for share in SHARES}
    better = min(worst, key=lambda share: worst[share])
    limits = {
        (regime, share): good_up_to(twin.lumped[regime, share][0].max(axis=1)) for share in SHARES for regime in REGIMES
    }
    ratios = {
        (what, regime): _error(_times_less(twin, regime, place))
        for place, what in enumerate(("z", "foot"))
        for regime in REGIMES
    }
    met = worst[better] < PAPER_LIMIT
    up_to = ", ".join(f"{_up_to(limits[regime, better])} ({regime})" for regime in REGIMES)
    return Claim(
        "C2",
        "reproduced" if met else "reproduced in part",
        f"Beside a chain of {TWIN} segments whose tube has a twentieth of the crawler's mass, one spring, the "
        f"tube lumped by {better}, has an NMSE of z of at most {worst[better]:.2g} in all four regimes (the "
        f"paper: {PAPER_NMSE}), and one below {PAPER_LIMIT} up to a tube of {up_to} of that mass.",
        {f"z, worst regime, {share}, tube of {MASSES[at]}": Number(error) for share, error in worst.items()}
        | {
            f"tube up to which z is below {PAPER_LIMIT}, {regime}, {share}": Number(limit)
            for (regime, share), limit in limits.items()
        }
        | {
            f"{what}, error with half over that with a third, {regime}": ratio
            for (what, regime), ratio in ratios.items()
        }
        | {
            f"{what}, nominal, {share}, tube of {mass}": _error(twin.lumped["nominal", share][place, row])
            for share in SHARES
            for row, mass in enumerate(MASSES)
            for place, what in enumerate(("z", "foot"))
        }
        | {
            f"{what}, nominal, chain of {segments} against {SEGMENTS[-1]}, tube of {mass}": _error(
                twin.refined[place, column, row]
            )
            for column, segments in enumerate(SEGMENTS[:-1])
            for row, mass in enumerate(MASSES)
            for place, what in enumerate(("z", "foot"))
        }
        | {
            f"{what}, {regime}, chain of {TWIN} against {SEGMENTS[-1]}, tube of {MASSES[-1]}": _error(errors[place])
            for regime, errors in twin.converged.items()
            for place, what in enumerate(("z", "foot"))
        }
        | {f"z of a linear chain of {TWIN} against its exact solution, largest error": Number(twin.exact, unit="z_c")},
        "stickslip reproduce figS6",
        {"mass of the tube, of payload and foot": Number(_TUBE)}
        | {f"z, {share}": _error(errors[0]) for share, errors in twin.body.items()}
        | {
            f"root mean square error of z, {share}": _error(errors[1] * BODY.scales.length * 1e3, "mm")
            for share, errors in twin.body.items()
        },
        f"{_regimes()}. With a third of the tube at each end the error of z is less than with half "
        f"{_where(ratios, 'z')}, nominally by a factor of {ratios['z', 'nominal']}; that of the foot is less "
        f"{_where(ratios, 'foot')}. Half stays the default of an Actuator: it loses none of the tube's mass, with "
        f"which the whole slides, nor of its weight, and is the chain of one segment (S14).",
    )


def good_up_to(errors: NDArray[np.float64]) -> float:
    """Mass of the tube at which errors, one a mass, first pass the paper's limit: by a power law between neighbours.

    The largest mass where they do not.
    """
    above = np.flatnonzero(errors > PAPER_LIMIT)
    if not above.size:
        return MASSES[-1]
    if not above[0]:
        return 0.0
    ends = slice(above[0] - 1, above[0] + 1)
    return float(np.exp(np.interp(np.log(PAPER_LIMIT), np.log(errors[ends]), np.log(MASSES[ends]))))


def _up_to(limit: float) -> str:
    return f"{limit:.2g}" + (" and more" if limit == MASSES[-1] else "")


def _times_less(twin: Twin, regime: str, place: int) -> NDArray[np.float64]:
    """Error with half of the tube at each end over that with a third: geometric mean over masses, a seed each."""
    half, third = (twin.lumped[regime, share][place] for share in SHARES)
    return np.asarray(np.exp(np.log(half / third).mean(axis=0)))


def _where(ratios: Mapping[tuple[str, str], Number], what: str) -> str:
    """Regimes in which the interval of a ratio lies above 1."""
    better = [regime for regime in REGIMES if (ratios[what, regime].low or 0.0) > 1.0]
    if len(better) == len(REGIMES):
        return "in all regimes"
    return f"for sure in {len(better)} of {len(REGIMES)} regimes" + (f" ({', '.join(better)})" if better else "")


def _regimes() -> str:
    """Groups of each regime, but for those of the default."""
    signs = {"duffing": "Pi1", "damping_ratio": "Pi2", "deborah": "Pi4", "radial_coupling": "Pi5"}
    signs |= {"static_friction": "static friction", "kinetic_friction": "kinetic friction"}
    usual = Groups().to_dict()
    told = [
        f"{regime}: "
        + ", ".join(
            f"{signs[name]} = {value:g}"
            for name, value in groups.to_dict().items()
            if regime == "nominal" or value != usual[name]
            if name in signs
        )
        for regime, groups in REGIMES.items()
    ]
    return "Groups (the paper gives none): " + "; ".join(told)


def _error_of_the_chain(seed: int) -> float:
    """Largest error of z of a linear chain that stands still: the simulator against the exponential of its matrix."""
    groups, valve = Groups(duffing=0.0, radial_coupling=0.0), random_bits(_HOLDS, seed)
    scene = Scene(segments=TWIN, tube_mass=MASSES[-1], anchored=True)
    told = simulate(groups, valve, _HOLD, scene=scene, samples_per_hold=_SAMPLES, tolerance=_TOLERANCE).deformation
    exact = exact_deformation(groups, valve, _HOLD, _SAMPLES, segments=TWIN, tube_mass=MASSES[-1])
    return float(np.abs(told - exact).max())


def _of_body(seed: int, share: float) -> tuple[float, float]:
    """NMSE of z of the real body with a share of its tube at each end, and the root mean square of the error."""
    valve = random_bits(_HOLDS, seed)
    bare, lumped = _bare(), body_with(share)
    true = _chain(bare, _TUBE, TWIN, valve)[0]
    hold = _HOLD * BODY.scales.time / math.sqrt(1.0 + _TUBE) / lumped.scales.time
    told = simulate(lumped.groups, valve, hold, samples_per_hold=_SAMPLES, tolerance=_TOLERANCE).deformation
    return nmse(told, true), float(np.sqrt(np.mean((told - true) ** 2)))


def _bare() -> Groups:
    """Groups of the real body without its tube, of which it has half at each end."""
    groups, unit = BODY.groups, math.sqrt(1.0 + _TUBE)
    return replace(
        groups,
        damping_ratio=groups.damping_ratio * unit,
        deborah=groups.deborah * unit,
        foot_mass_fraction=(BODY.foot_mass - 0.5 * TUBE_MASS) / (BODY.mass - TUBE_MASS),
    )


def _chain(groups: Groups, mass: float, segments: int, valve: NDArray[np.int64]) -> NDArray[np.float64]:
    """Deformation and foot of a chain, (2, samples)."""
    scene = Scene(segments=segments, tube_mass=mass)
    motion = simulate(groups, valve, _HOLD, scene=scene, samples_per_hold=_SAMPLES, tolerance=_TOLERANCE)
    return np.stack([motion.deformation, motion.foot])


def _one_spring(groups: Groups, mass: float, share: float, valve: NDArray[np.int64]) -> NDArray[np.float64]:
    """Deformation and foot of the crawler with a share of the tube at each end, in the units of `groups`."""
    total = 1.0 + 2.0 * share * mass
    unit = math.sqrt(total)  # its unit of time in that of `groups`
    lumped = replace(
        groups,
        damping_ratio=groups.damping_ratio / unit,
        deborah=groups.deborah / unit,
        foot_mass_fraction=(groups.foot_mass_fraction + share * mass) / total,
    )
    motion = simulate(lumped, valve, _HOLD / unit, samples_per_hold=_SAMPLES, tolerance=_TOLERANCE)
    return np.stack([motion.deformation, motion.foot])


def _errors(told: NDArray[np.float64], true: NDArray[np.float64]) -> tuple[float, float]:
    return nmse(told[0], true[0]), nmse(told[1], true[1])
