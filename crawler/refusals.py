"""What an unfinished or an unresolved run means: where it got to, why no further, and what to change."""

import math
import warnings

from .cost import fastest_rate, FastestRate
from .model.groups import Groups
from .model.scene import Scene
from .model.tube import is_chain
from .motion.sampling import FARTHEST
from .steps.options import DIVERGED

__all__ = ["SlipWarning", "SolverError", "solver_error", "warn_of_slips"]

# Decades from 1 beyond which a group leaves no digits to the others.
_ABSURD = 15.0
# Slips in a period of the body's fastest oscillation that it cannot make by swinging.
_MANY_SLIPS = 10.0
_TAKE_RADAU = "solver='radau'"


class SolverError(RuntimeError):
    """The motion diverged or the solver ran out of steps; the message says where, why and what to change."""


class SlipWarning(UserWarning):
    """More slips were counted than the tolerance resolves; the message says how many, and what to change."""


def warn_of_slips(slips: int, length: float, tolerance: float, scene: Scene, whose: str = "") -> None:
    """Warn that the slips of a run are shorter than its tolerance.

    Parameters
    ----------
    slips : int
    length : float
        Mean way of the foot in one, z_c.
    tolerance : float
    scene : Scene
    whose : str
        What the message begins with.

    Warns
    -----
    SlipWarning
    """
    other = "" if is_chain(scene) else f" or {_TAKE_RADAU}"
    warnings.warn(
        f"{whose}the foot broke loose {slips} times, for {length:.2g} on average, which is less than the tolerance "
        f"{tolerance:g}: so short slips may come and go with the solver's error; take a smaller tolerance{other}",
        SlipWarning,
        stacklevel=3,
    )


def solver_error(
    status: int,
    time: float,
    deformation: float,
    steps: int,
    groups: Groups,
    scene: Scene,
    tolerance: float,
    solver: str,
    slips: int = 0,
    began: float = 0.0,
) -> SolverError:
    """The exception that tells what an unfinished run means: where, why, and what to change.

    Parameters
    ----------
    status : int
        DIVERGED or OUT_OF_STEPS.
    time, deformation : float
        How far the motion got.
    steps : int
        The budget.
    groups : Groups
    scene : Scene
    tolerance : float
    solver : str
    slips : int
        In the steps of the budget.
    began : float
        When the first of those steps began.
    """
    where = f"at time {time:.6g} (z = {deformation:.6g})"
    absurd = _absurd(groups, scene)
    if status == DIVERGED:
        cause = f"it began too far or too fast, and left the {FARTHEST:g} natural units within which a body is followed"
        if absurd:
            cause = f"{absurd} leaves floating-point numbers no digits for the rest"
        elif groups.duffing == 0.0 and groups.radial_coupling > 1.0:
            cause = "a body with radial_coupling > 1 needs duffing > 0"
        return SolverError(f"the motion diverged {where}: {cause}, with {groups}")
    fastest = fastest_rate(groups, scene, deformation)
    cause, remedies = _spent(absurd, fastest, time - began, slips, tolerance, solver)
    if is_chain(scene):
        remedies = [remedy for remedy in remedies if remedy != _TAKE_RADAU]  # which takes no chain
        remedies = [f"fewer segments than {scene.segments}", f"more tube_mass than {scene.tube_mass!r}", *remedies]
    return SolverError(
        f"the step budget of {steps} was spent {where} by solver {solver!r} at tolerance {tolerance:g}: "
        f"{cause}; take {', '.join(remedies[:-1])}, or {remedies[-1]}; with {groups}"
    )


def _spent(
    absurd: str, fastest: FastestRate, span: float, slips: int, tolerance: float, solver: str
) -> tuple[str, list[str]]:
    """What the steps, over a span of time, were spent on, and what to do about it."""
    remedies = ["a larger max_steps"]
    if solver != "closed_form":
        remedies.append("a looser tolerance")
    if absurd:
        return f"{absurd} makes it faster than any solver follows", [*remedies, "less of that"]
    acts = f"{fastest.name} acts at a rate of {fastest.rate:.3g} per unit of time"
    swings = fastest.rate * span / (2.0 * math.pi)
    if slips > _MANY_SLIPS * (1.0 + swings):
        cause = f"{slips} slips have accumulated, {slips / (1.0 + swings):.3g} in the time of a swing of the body"
        return f"{cause}, whose pull hovers about the grip", [*remedies, "another static_friction"]
    alive = fastest.decay < fastest.rate and fastest.decay * span < -math.log(tolerance)
    if alive and swings > 1.0:
        return f"{acts}: {swings:.3g} real swings so far, which no solver may skip", [*remedies, "a shorter schedule"]
    # Radau would hold fast what grows, and damp what swings on.
    if solver == "taylor" and not alive:
        return f"{acts}, which is too stiff for this solver", [_TAKE_RADAU, *remedies, "less of that"]
    return acts, [*remedies, "less of that"]


def _absurd(groups: Groups, scene: Scene) -> str:
    """The group or the slope that is farthest from 1 beyond all measure, as an assignment; empty where none is."""
    sizes = {**groups.to_dict(), "slope": abs(scene.slope)}
    del sizes["static_friction"]  # a grip that never yields makes nothing harder
    decades = {name: math.log10(size) for name, size in sizes.items() if size > 0.0}
    for small in ("deborah", "foot_mass_fraction"):
        decades[small] = -decades[small]
    name = max(decades, key=decades.__getitem__)
    return f"{name} = {sizes[name]!r}" if decades[name] > _ABSURD else ""
