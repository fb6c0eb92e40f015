"""The groups, or the SI parameters, of a body from measurements: nonlinear least squares through slips and stops.

The residuals are those of whole runs, and their slopes the sensitivities that ride along through every slip and stop
(`stickslip.sensitivities`); of a chain of segments, differences of neighbours in one batch. Where a slip is won or lost
a run has a kink or a jump, which no slope tells: what is found is compared with bodies beside it along each parameter,
and its intervals reach as far as these fit as well.
A wrong guess gets the slips wrong, and then the sum of squares has many valleys. So the search starts from many bodies
about the guess on the first few holds, where few slips can be wrong, and lengthens the run as it closes in.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...common.validation import different_names, whole_number
from ...crawler import Actuator, Groups, GroupsLike, Scene
from ...crawler.model.groups import RANGES
from .coordinates import Coordinates
from .identifiability import hidden_friction, what_is_not_told
from .identification import Identification
from .measurements import Measurements, several
from .prediction import Body
from .problem import Problem
from .search import Fit, search, STRUCTURED

__all__ = ["identify"]


def identify(
    measurements: Measurements | Sequence[Measurements],
    *,
    free: Sequence[str] | None = None,
    guess: GroupsLike | None = None,
    scene: Scene | dict[str, Any] | None = None,
    starts: int = 512,
    tolerance: float = 1e-9,
    seed: int = 0,
) -> Identification:
    """Find the body that measurements are of.

    Parameters
    ----------
    measurements : Measurements or sequence of them
        One run or several of one body, all of whose valves are known.
    free : sequence of str, optional
        What to find: fields of the guess. All groups by default; of an `Actuator` they must be named, since no motion
        tells, for example, all of its masses, stiffnesses and pressures.
    guess : Groups, preset, mapping or Actuator, optional
        Where to look, right within a factor of about three; the default groups by default. With an `Actuator`, the
        measurements are in SI, and what is not free is as it says.
    scene : Scene or mapping, optional
    starts : int
        Bodies about the guess that are compared, >= 1; one is the guess itself.
    tolerance : float
        Of `simulate`.
    seed : int
        Of the starts.

    Returns
    -------
    Identification

    Raises
    ------
    ValueError, TypeError
        If a name is not a field of the guess or there twice, or there are no more samples than free parameters.
    RuntimeError
        If no start can be simulated.
    """
    runs = several(measurements)
    body: Body = guess if isinstance(guess, Actuator) else Groups.of(guess)
    if free is None and isinstance(body, Actuator):
        raise ValueError("free must name what to find of an Actuator, got None")
    names = tuple(RANGES if free is None else free)
    different_names("free", names, [name for name in body.__dataclass_fields__ if name != "segments"])
    whole_number("starts", starts, 1)
    problem = Problem.of(runs, Coordinates(body, names), Scene.of(scene), tolerance)
    if problem.samples <= len(names):
        raise ValueError(f"measurements must have more samples than the {len(names)} free, got {problem.samples}")
    return _told(search(problem, starts, whole_number("seed", seed, 0)))


def _told(fit: Fit) -> Identification:
    """The identification that a fit is."""
    problem, point, profiles = fit.problem, fit.point, fit.profiles
    names, body_at = problem.coordinates.names, problem.coordinates.body
    values = [
        np.array([getattr(body_at(each), name) for each in row])
        for name, row in zip(names, profiles.points, strict=True)
    ]
    found = Identification(
        body=body_at(point),
        names=names,
        covariance=profiles.covariance,
        noise=problem.noise(point),
        samples=problem.samples,
        warnings=what_is_not_told(names, profiles.errors, profiles.directions),
        runs=problem.runs,
        scene=problem.scene,
        profiles=dict(zip(names, zip(values, profiles.rises, strict=True), strict=True)),
    )
    more = hidden_friction(found)
    if fit.structure > STRUCTURED:
        more += (
            "what is left is more than noise, since it goes on from sample to sample: the body differs from the "
            "model, or a better fit was missed",
        )
    return replace(found, warnings=found.warnings + more)
