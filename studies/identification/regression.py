"""The law of the crawler by linear regression that knows of slips and stops.

The payload's acceleration is F / (1 - r) whether the foot sticks or slides, so that one regression on p - z, p z, z^3
and v finds the force from all samples, without a phase being known. It is done in weak form: both sides are integrated
against smooth bumps, and no measurement is differentiated (D. A. Messenger and D. M. Bortz, Multiscale Modeling and
Simulation 19 (2021) 1474). While the foot slides, momentum (1 - r) v + w falls at the rate k, whatever the force. What
holds the foot shows only in when it breaks loose: that friction is the one with which the crawler, driven as it was,
moves most nearly as it did. The lag follows from the pressure, which is known in closed form.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_opening, label
from scipy.optimize import minimize_scalar
from scipy.signal import fftconvolve

from ...common.validation import number_within
from ...crawler import Groups, Scene
from .measurements import Measurements
from .prediction import predicted

__all__ = ["Law", "payload_law", "regress", "sliding"]

_NEEDED = ("deformation", "velocity", "pressure", "foot_velocity")
_POWER = 6  # of the bump (1 - s^2)^q, which makes sums over samples as good as integrals
_OVERLAP = 4  # bumps within half the support of one
_LAGS = (1e-3, 1e3)  # over the hold
_TOLD = 4.0  # standard errors of the foot's velocity above which it moves
_SHORTEST = 5  # samples of a slide that tells of its friction
# Static frictions that are compared at once, round by round, each between the neighbours of the last one's best. A slip
# that is won or lost makes a valley of its own, some percent wide, which the first round must not step over.
_TRIED = (257, 17, 17, 17)
_RANGE = (1.0, 10.0)  # of these, over the kinetic friction
_TOLERANCE = 1e-8  # of the crawlers that are driven for it


@dataclass(frozen=True)
class Law:
    """What a regression found.

    Attributes
    ----------
    groups : Groups
    coefficients : (4,) array
        Of p - z, p z, z^3 and v in the payload's acceleration.
    sliding : (samples,) array of bool
        Whether the foot slid, as it was known or found.
    """

    groups: Groups
    coefficients: NDArray[np.float64]
    sliding: NDArray[np.bool_]


def regress(
    run: Measurements, *, phases: NDArray[np.bool_] | None = None, support: float = 0.4, scene: Scene | None = None
) -> Law:
    """Find the groups of a crawler on level ground with a ratcheted foot.

    Parameters
    ----------
    run : Measurements
        Equally spaced and without gaps, in natural units, of deformation, velocity, pressure and foot velocity.
    phases : (samples,) array of bool, optional
        Whether the foot slides; found from its velocity by default (`sliding`).
    support : float
        Half the length of the bumps, natural time, > 2 samples.
    scene : Scene, optional
        In which the static friction is looked for.

    Returns
    -------
    Law

    Raises
    ------
    ValueError
        If a channel is missing or has gaps, samples are not equally spaced, or the foot hardly ever slides.
    """
    missing = [name for name in _NEEDED if name not in run.measured or np.isnan(getattr(run, name)).any()]
    if missing or run.samples_per_hold is None:
        lacks = f"{missing[0]} in all samples" if missing else "samples_per_hold"
        raise ValueError(f"measurements must have {', '.join(_NEEDED)}, equally spaced; these lack {lacks}")
    z, v, measured, w = (np.asarray(getattr(run, name)) for name in _NEEDED)
    deborah, pressure = _lag(run.valve, run.hold, run.samples_per_hold, measured)
    step = run.hold / run.samples_per_hold
    found = payload_law(np.stack([pressure - z, pressure * z, z**3, v]), v + w, step, support)
    slides = sliding(w) if phases is None else np.asarray(phases, dtype=bool)
    share = 1.0 / found[0]
    kinetic = _kinetic_friction(run.times, share * v + w, slides)
    groups = Groups(
        duffing=max(0.0, -found[2] * share),
        damping_ratio=max(0.0, -0.5 * found[3] * share),
        deborah=deborah,
        radial_coupling=max(0.0, found[1] * share),
        foot_mass_fraction=1.0 - share,
        static_friction=kinetic,
        kinetic_friction=kinetic,
    )
    return Law(_with_static_friction(groups, run, Scene.of(scene)), found, slides)


def payload_law(
    terms: NDArray[np.float64], velocity: NDArray[np.float64], step: float, support: float
) -> NDArray[np.float64]:
    """Coefficients of terms in an acceleration, in weak form.

    Parameters
    ----------
    terms : (terms, samples) array
    velocity : (samples,) array
        Whose rate they make.
    step : float
        Between samples.
    support : float
        Half the length of the bumps.

    Returns
    -------
    (terms,) array
    """
    half = round(number_within("support", support, "(0, inf)") / step)
    if half < 2 or 2 * half + 1 > velocity.size:
        raise ValueError(f"support must be of 2 samples or more and at most half of the run, got {half} of {step:g}")
    s = np.linspace(-1.0, 1.0, 2 * half + 1)
    bump = (1.0 - s**2) ** _POWER
    slope = -2.0 * _POWER * s * (1.0 - s**2) ** (_POWER - 1) / (half * step)
    every = max(1, half // _OVERLAP)
    integrals = np.stack([fftconvolve(term, bump[::-1], "valid")[::every] for term in terms], axis=1)
    rates = -fftconvolve(velocity, slope[::-1], "valid")[::every]
    return np.linalg.lstsq(integrals, rates, rcond=None)[0]


def sliding(foot_velocity: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the foot slides, from its noisy velocity.

    It does where the velocity is above four standard errors, which are taken from third differences, in at least two
    samples in a row; single samples below do not end a slide.
    """
    errors = float(np.median(np.abs(np.diff(foot_velocity, 3)))) / 0.6745 / np.sqrt(20.0)
    above = foot_velocity > _TOLD * errors
    pair = np.ones(2, dtype=bool)
    return binary_opening(binary_closing(above, np.ones(3, dtype=bool)), pair)


def _lag(
    valve: NDArray[np.float64], hold: float, samples_per_hold: int, measured: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64]]:
    """Pi4, and the pressure with it: both from the measured pressure by least squares."""
    since = np.arange(1, samples_per_hold + 1) * hold / samples_per_hold

    def pressure(lag: float) -> NDArray[np.float64]:
        start, holds = 0.0, []
        for duty in valve.tolist():
            open_for = duty * hold
            filled = 1.0 + (start - 1.0) * np.exp(-np.minimum(since, open_for) / lag)
            holds.append(filled * np.exp(-np.maximum(since - open_for, 0.0) / lag))
            start = float(holds[-1][-1])
        return np.concatenate(holds)

    low, high = (np.log(each * hold) for each in _LAGS)
    found = minimize_scalar(
        lambda log: float(np.sum((pressure(float(np.exp(log))) - measured) ** 2)),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-10},
    )
    lag = float(np.exp(found.x))
    return lag, pressure(lag)


def _kinetic_friction(times: NDArray[np.float64], momentum: NDArray[np.float64], slides: NDArray[np.bool_]) -> float:
    """The rate at which momentum falls in all slides together; the samples at their ends are left out."""
    pieces, count = label(slides)
    along = square = 0.0
    for piece in range(1, count + 1):
        inside = np.flatnonzero(pieces == piece)[1:-1]
        if inside.size >= _SHORTEST:
            since = times[inside] - times[inside].mean()
            along += float(since @ momentum[inside])
            square += float(since @ since)
    if square == 0.0:
        raise ValueError(f"the foot must slide for {_SHORTEST + 2} samples at least once, which it does nowhere")
    return max(0.0, -along / square)


def _with_static_friction(groups: Groups, run: Measurements, scene: Scene) -> Groups:
    """The groups with the static friction by which the crawler, driven as it was, moves most nearly as it did."""
    low, high = (max(groups.kinetic_friction, 1e-3) * ratio for ratio in _RANGE)
    for count in _TRIED:
        tried = np.geomspace(low, high, count)
        crawlers = [replace(groups, static_friction=max(float(s), groups.kinetic_friction)) for s in tried]
        motions = predicted(crawlers, run, scene, _TOLERANCE)
        left = sum(
            np.sum((motions[name] - getattr(run, name)) ** 2, axis=1) / np.var(getattr(run, name))
            for name in ("velocity", "foot_velocity")
        )
        best = int(np.nanargmin(left))
        low, high = tried[max(best - 1, 0)], tried[min(best + 1, count - 1)]
    return crawlers[best]
