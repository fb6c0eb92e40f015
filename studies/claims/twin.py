"""C2: the crawler of one spring beside the chain of segments that its supplement derives, refined until it converges.

A tube of mass m between foot and payload can be lumped at its two ends. Half at each end keeps the total mass; a third
at each keeps the frequency of a body whose foot stands still (Lord Rayleigh, The Theory of Sound, section 156), since a
tube that stretches evenly moves with m / 3 of its mass. Both are one-spring crawlers of other groups.
"""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...crawler import Groups, Scene, simulate
from ...tasks import random_bits
from .asked import Asked
from .claim import Claim, interval, Number
from .real_body import BODY, in_millimetres, TUBE_MASS
from .sindy import nmse

__all__ = ["MASSES", "REGIMES", "SEGMENTS", "SHARES", "Twin", "claim", "measure"]

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
_TWIN = 8  # segments of the chain that one spring is compared with
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
    refined : (2, segments - 1, seeds) array
        Chains against the finest, nominal, at the largest mass.
    body : (2, seeds) array
        NMSE of z of the real body, lumped with half of its own tube at each end, against the chain of 8 segments, and
        the root mean square of the error in natural units.
    """

    lumped: dict[tuple[str, str], NDArray[np.float64]]
    refined: NDArray[np.float64]
    body: NDArray[np.float64]


def measure(asked: Asked) -> Twin:
    """Chains and crawlers of one spring under fair random bits."""
    seeds = list(asked.seeds)
    lumped: dict[tuple[str, str], NDArray[np.float64]] = {
        (regime, share): np.empty((2, len(MASSES), len(seeds))) for regime in REGIMES for share in SHARES
    }
    refined = np.empty((2, len(SEGMENTS) - 1, len(seeds)))
    for column, seed in enumerate(seeds):
        valve = random_bits(_HOLDS, seed)
        for regime, groups in REGIMES.items():
            for row, mass in enumerate(MASSES):
                true = _chain(groups, mass, _TWIN, valve)
                for share, part in SHARES.items():
                    lumped[regime, share][:, row, column] = _errors(_one_spring(groups, mass, part, valve), true)
        true = _chain(Groups(), MASSES[-1], SEGMENTS[-1], valve)
        for row, segments in enumerate(SEGMENTS[:-1]):
            refined[:, row, column] = _errors(_chain(Groups(), MASSES[-1], segments, valve), true)
    return Twin(lumped, refined, np.array([_of_body(seed) for seed in seeds]).T)


def claim(twin: Twin) -> Claim:
    """C2, decided at a tube of a twentieth of the mass, by the better way of lumping."""
    at = MASSES.index(0.05)
    worst = {share: max(float(twin.lumped[regime, share][0, at].max()) for regime in REGIMES) for share in SHARES}
    better = min(worst, key=lambda share: worst[share])
    nominal = twin.lumped["nominal", better][0]
    limit = next((mass for mass, error in zip(MASSES, nominal.max(axis=1), strict=True) if error > PAPER_LIMIT), None)
    up_to = f"up to a mass of {MASSES[-1]}" if limit is None else f"below a mass of {limit}"
    ratio = np.median(twin.lumped["nominal", "half at each end"][0] / twin.lumped["nominal", "a third at each end"][0])
    met = worst[better] < PAPER_LIMIT
    return Claim(
        "C2",
        "reproduced" if met else "reproduced in part",
        f"Beside a chain of {_TWIN} segments whose tube has a twentieth of the crawler's mass, one spring has an "
        f"NMSE of z of at most {worst[better]:.2g} in all four regimes, lumped with {better} (the paper: "
        f"{PAPER_NMSE}); in the nominal one it stays below {PAPER_LIMIT} {up_to}. The error with a third at each end "
        f"is {ratio:.1f} times less than with half.",
        {f"z, worst regime, {share}": Number(error) for share, error in worst.items()}
        | {
            f"{what}, nominal, {better}, tube of {mass}": _error(twin.lumped["nominal", better][place, row])
            for row, mass in enumerate(MASSES)
            for place, what in enumerate(("z", "foot"))
        }
        | {
            f"{what}, chain of {segments} against {SEGMENTS[-1]}, tube of {MASSES[-1]}": _error(
                twin.refined[place, row]
            )
            for row, segments in enumerate(SEGMENTS[:-1])
            for place, what in enumerate(("z", "foot"))
        },
        "stickslip reproduce figS6",
        {
            "mass of the tube, of payload and foot": Number(_TUBE),
            "z, half of the tube at each end": Number(float(twin.body[0].max())),
            "root mean square error of z": in_millimetres(float(twin.body[1].max())),
        },
    )


def _of_body(seed: int) -> tuple[float, float]:
    """NMSE of z, and the root mean square of the error."""
    valve = random_bits(_HOLDS, seed)
    bare = _bare()
    true = _chain(bare, _TUBE, _TWIN, valve)[0]
    told = _one_spring(bare, _TUBE, 0.5, valve)[0]
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
