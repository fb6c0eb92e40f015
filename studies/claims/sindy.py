"""Accelerations of the crawler by sparse regression on polynomials, as the paper does it (C6 to C9), with PySINDy.

F / (1 - r) is the payload's acceleration while the foot sticks and while it slides: a cubic in z, v and p. The foot's
acceleration, and with it z'', jumps when the foot breaks loose or stops: no polynomial does.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.preprocessing import PolynomialFeatures

from ...common.extras import optional_import
from ...crawler import Groups, Scene, simulate, Trajectory
from ...crawler.model.equations import force
from ...crawler.model.state import coefficients_of
from ...reservoir import nrmse
from ...tasks import random_bits
from ..identification.regression import payload_law

with optional_import():
    import pysindy

__all__ = ["METHODS", "TARGETS", "Fit", "Setting", "accelerations", "errors_of", "fit", "foretold", "library", "nmse"]

_Array = NDArray[np.float64]

Target = Literal["payload", "foot", "deformation"]
TARGETS: tuple[Target, ...] = ("payload", "foot", "deformation")
"""Whose acceleration is regressed."""

_force: Any = force  # a formula, of arrays as of numbers
_SUPPORT = 0.4  # half the length of the weak form's bumps, natural time
_MODELS = 20  # of an ensemble
_TOLERANCE = 1e-10
_LARGEST = 10.0  # natural units that a run is kept within


@dataclass(frozen=True)
class Setting:
    """One way to regress.

    Parameters
    ----------
    target : {"payload", "foot", "deformation"}
    degree : int
        Of the polynomials in z, v and p.
    rates : bool
        Whether max(0, p') and sign(p') are in the library, as in the paper's Fig. 5.
    centred : bool
        Whether z is measured from its mean: the paper's removal of pre-strain.
    method : {"stlsq", "ensemble", "weak"}
        Sequentially thresholded least squares of the exact acceleration, the median of such fits to bootstrapped
        samples, or all terms in weak form, for which no acceleration is measured.
    threshold : float
        Below which a coefficient is dropped.
    noise : float
        Standard deviation of the errors, of that of the channel.
    step : float
        Between samples, natural time.
    offset : float
        From which z is measured where it is not centred.
    """

    target: Target = "foot"
    degree: int = 3
    rates: bool = False
    centred: bool = False
    method: str = "stlsq"
    threshold: float = 0.05
    noise: float = 0.0
    step: float = 0.02
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Fit:
    """What a regression comes to.

    Attributes
    ----------
    setting : Setting
    origin : float
        From which z was measured.
    coefficients : (terms,) array
        Of the library's polynomials, then of max(0, p') and sign(p') if it has these.
    terms : dict of str to float
        Those other than 0, by the name of the term.
    nmse : float
        Of one step, on a run that was not seen.
    told, true : (samples,) arrays
        The acceleration in that run.
    """

    setting: Setting
    origin: float
    coefficients: _Array
    terms: dict[str, float]
    nmse: float
    told: _Array
    true: _Array


def accelerations(groups: Groups, motion: Trajectory) -> dict[Target, _Array]:
    """Exact accelerations of payload, foot and deformation at the samples, on level ground with a ratcheted foot."""
    r = groups.foot_mass_fraction
    pull = _force(coefficients_of(groups, Scene()), motion.deformation, motion.velocity, motion.pressure)
    payload = pull / (1.0 - r)
    foot = np.where(motion.foot_velocity > 0.0, -(pull + groups.kinetic_friction) / r, 0.0)
    return {"payload": payload, "foot": foot, "deformation": payload - foot}


def _states(motion: Trajectory) -> _Array:
    """Deformation, velocity and pressure, (samples, 3): what the paper regresses on."""
    return np.stack([motion.deformation, motion.velocity, motion.pressure], axis=1)


@cache
def library(degree: int) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """Names of the polynomial terms up to a degree, and their powers of z, v and p: (terms, 3)."""
    terms = PolynomialFeatures(degree).fit(np.zeros((1, 3)))
    return tuple(terms.get_feature_names_out(["z", "v", "p"])), terms.powers_


def fit(setting: Setting, groups: Groups, *, hold: float = 1.0, holds: int = 200, seed: int = 0) -> Fit:
    """Regress on one run under fair random bits, and foretell the acceleration in another.

    Parameters
    ----------
    setting : Setting
    groups : Groups
        Of a crawler on level ground with a ratcheted foot.
    hold : float
    holds : int
        Of either run.
    seed : int
        The valve's and the errors'.

    Returns
    -------
    Fit
    """
    generator = np.random.default_rng([seed, 1])
    count = round(hold / setting.step)
    names, _ = library(setting.degree)
    runs = [
        simulate(groups, random_bits(holds, [seed, part]), hold, samples_per_hold=count, tolerance=_TOLERANCE)
        for part in range(2)
    ]
    origin = setting.offset
    exact, terms = [], []
    for run in runs:
        measured = _states(run)
        measured = measured + setting.noise * measured.std(axis=0) * generator.standard_normal(measured.shape)
        if run is runs[0] and setting.centred:
            origin = float(measured[:, 0].mean())
        terms.append(_terms(setting, origin, measured, np.repeat(run.valve, count), groups.deborah))
        exact.append(accelerations(groups, run)[setting.target])
    names += ("max(0, p')", "sign(p')") if setting.rates else ()
    known = _velocity(runs[0], setting.target) if setting.method == "weak" else exact[0]
    known = known + setting.noise * known.std() * generator.standard_normal(known.size)
    found = _METHODS[setting.method](setting, terms[0], known, generator)
    kept = {name: float(value) for name, value in zip(names, found, strict=True) if value != 0.0}
    told = terms[1] @ found
    return Fit(setting, origin, found, kept, nmse(told, exact[1]), told, exact[1])


def foretold(
    deformations: Sequence[Fit], feet: Sequence[Fit], valves: ArrayLike, deborah: float, hold: float = 1.0
) -> tuple[_Array, _Array]:
    """Whole runs from rest, by what regressions have found of z'' and of the foot's acceleration.

    By the classical Runge-Kutta method, the pressure given in closed form, as many steps a hold as there were samples.
    z, z' and the foot's velocity are kept within ten natural units: where they get there, the polynomial has run away.

    Parameters
    ----------
    deformations, feet : sequences of Fit
        Of equal settings but for the target; one of each a run.
    valves : (runs, holds) array_like
    deborah : float
        Pi4.
    hold : float

    Returns
    -------
    deformation, foot : (runs, samples) arrays
    """
    setting = deformations[0].setting
    count = round(hold / setting.step)
    step = hold / count
    origins = np.array([fit.origin for fit in deformations])
    coefficients = np.stack([[fit.coefficients for fit in fits] for fits in (deformations, feet)])
    open_or_not = np.asarray(valves, dtype=np.float64)
    z, v, w, p, x = np.zeros((5, len(deformations)))

    def rates(z: _Array, v: _Array, p: _Array, valve: _Array) -> _Array:
        terms = _terms(setting, origins, np.stack([z, v, p], axis=1), valve, deborah)
        found: _Array = np.einsum("kij,ij->ki", coefficients, terms)
        return found

    def kept(values: _Array) -> _Array:
        return np.clip(values, -_LARGEST, _LARGEST)

    found = []
    half, whole = (float(np.exp(-share * step / deborah)) for share in (0.5, 1.0))
    for valve in np.repeat(open_or_not.T, count, axis=0):
        middle, end = (valve + (p - valve) * left for left in (half, whole))
        a1, b1 = rates(z, v, p, valve)
        a2, b2 = rates(z + 0.5 * step * v, v + 0.5 * step * a1, middle, valve)
        a3, b3 = rates(z + 0.5 * step * v + 0.25 * step**2 * a1, v + 0.5 * step * a2, middle, valve)
        a4, b4 = rates(z + step * v + 0.5 * step**2 * a2, v + step * a3, end, valve)
        x = x + step * w + step**2 / 6.0 * (b1 + b2 + b3)
        w = kept(w + step / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4))
        z = kept(z + step * v + step**2 / 6.0 * (a1 + a2 + a3))
        v = kept(v + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4))
        p = end
        found.append((z, x))
    deformation, foot = np.array(found).transpose(1, 2, 0)
    return deformation, foot


def errors_of(way: Setting, groups: Groups, seeds: Sequence[int], *, holds: int = 200) -> dict[str, _Array]:
    """NMSE of what one way of regressing tells of runs that it has not seen, (seeds,) each.

    Parameters
    ----------
    way : Setting
        Whose target does not matter.
    groups : Groups
    seeds : sequence of int
    holds : int
        Of whole runs.

    Returns
    -------
    dict of str to (seeds,) array
        Of one step, by the target; of whole runs from rest ``"z"`` and ``"way of the foot"``.
    """
    fits = {target: [fit(replace(way, target=target), groups, seed=seed) for seed in seeds] for target in TARGETS}
    unseen = np.array([random_bits(holds, [seed, 2]) for seed in seeds])
    told = foretold(fits["deformation"], fits["foot"], unseen, groups.deborah)
    true = simulate([groups] * len(seeds), unseen, 1.0, samples_per_hold=round(1.0 / way.step))
    errors: dict[str, _Array] = {name: np.array([each.nmse for each in found]) for name, found in fits.items()}
    for name, runs, exact in zip(("z", "way of the foot"), told, (true.deformation, true.foot), strict=True):
        errors[name] = np.array([nmse(*pair) for pair in zip(runs, exact, strict=True)])
    return errors


def _terms(setting: Setting, origins: Any, states: _Array, valve: _Array, deborah: float) -> _Array:
    """Terms of the library at states of (n, 3) deformations, velocities and pressures, (n, terms)."""
    _, powers = library(setting.degree)
    values = np.ones((len(states), len(powers)))
    for column, exponents, origin in zip(states.T, powers.T, (origins, 0.0, 0.0), strict=True):
        raised = np.ones((setting.degree + 1, len(states)))
        np.cumprod(np.broadcast_to(column - origin, (setting.degree, len(states))), axis=0, out=raised[1:])
        values *= raised[exponents].T
    if setting.rates:
        rate = (valve - states[:, 2]) / deborah
        values = np.column_stack([values, np.maximum(0.0, rate), np.sign(rate)])
    return values


def nmse(told: _Array, true: _Array) -> float:
    """Mean squared error over the variance of what is true."""
    return nrmse(told, true) ** 2


def _velocity(motion: Trajectory, target: Target) -> _Array:
    """The velocity whose rate the target is."""
    parts = {
        "payload": motion.velocity + motion.foot_velocity,
        "foot": motion.foot_velocity,
        "deformation": motion.velocity,
    }
    return np.asarray(parts[target])


def _sparse(setting: Setting, terms: _Array, target: _Array, _: np.random.Generator) -> _Array:
    """Coefficients by sequentially thresholded least squares."""
    optimizer = pysindy.STLSQ(threshold=setting.threshold, alpha=1e-8)
    optimizer.fit(terms, target[:, np.newaxis])
    return np.asarray(optimizer.coef_)[0]


def _ensemble(setting: Setting, terms: _Array, target: _Array, generator: np.random.Generator) -> _Array:
    """The median of sparse coefficients over bootstrapped samples."""
    draws = generator.integers(target.size, size=(_MODELS, target.size))
    return np.median([_sparse(setting, terms[draw], target[draw], generator) for draw in draws], axis=0)


def _weak(setting: Setting, terms: _Array, velocity: _Array, _: np.random.Generator) -> _Array:
    """Coefficients of all terms in weak form."""
    return payload_law(terms.T, velocity, setting.step, _SUPPORT)


_METHODS = {"stlsq": _sparse, "ensemble": _ensemble, "weak": _weak}
METHODS = tuple(_METHODS)
