"""What a run will cost by each solver, predicted from how fast and how stiff the crawler is.

Cost is steps times what a step takes. The body is taken to be linear about the deformation at which the full pressure
holds it, and its motion to be a sum of modes: the lag of the fluid and, for each motion of the foot, an oscillation or
a fast and a slow relaxation. Every turn of the valve sets them off. The n-th term of a mode a e^(-decay t) whose n-th
derivative is rate^n as large stays below the tolerance in a step of length

    h(t) = (n! tolerance / a)^(1 / n) e^(decay t / n) / rate,

and the steps it takes are the integral of 1 / h. They lengthen as the mode dies, and what it costs once it is dead
tells the solvers apart: a Taylor series stays within so many of its time constants for ever, and Radau collocation is
free of it.
"""

import math
from functools import lru_cache
from typing import NamedTuple

from .model.equations import mobility_of
from .model.groups import Groups
from .model.scene import Scene
from .model.state import Coefficients, coefficients_of, FORWARD, STUCK
from .model.tube import as_crawler
from .motion.loop import FARTHEST
from .steps.radau import stages_for
from .steps.taylor import order_for

__all__ = ["FastestRate", "fastest_rate", "predicted_cost", "predicted_steps"]

# Microseconds that a step takes with its events, by Taylor, and more for each order, and by Radau for each stage; a
# look for events in closed form takes a third of a Taylor step of the same crawler. Only their ratios matter.
# `benchmarks/solver_choice.py` prints them, and the steps predicted over those counted, by which the other constants
# were set; a third more or less of any changes little.
_TAYLOR_STEP, _TAYLOR_ORDER, _RADAU_STAGE, _LOOK = 0.25, 0.012, 0.3, 0.13
# Length of a step over h above.
_TAYLOR_REACH, _RADAU_REACH = 1.2, 2.5
# Longest step of a Taylor series over order / rate: a longer one would make a dead mode grow again.
_TAYLOR_STABLE = 0.5
# A mode that Radau could cross in steps of so many (n!)^(1 / n) / rate is too faint to be followed.
_RADAU_FAINT = 2.0
# Part of the time for which a foot that breaks loose slides, if friction stops it again.
_SLIDING = 0.5
# Looks for each radian of the oscillation, and the time constants after which it is too faint to be looked at.
_LOOKS_A_RADIAN, _LOOKED_AT = 1.5, 3.0
# Newton steps from at most twice the root of a function that is convex from there down to it: none goes too far.
_REFINEMENTS = 10


class Rates(NamedTuple):
    """How fast the body moves in one motion of its foot, per unit of time."""

    frequency: float  # sqrt(K / m): of its oscillation, were there no damping
    damping: float  # 2 Pi2 / m: of a stretch that nothing drives


class Mode(NamedTuple):
    """One term of the motion that a turn of the valve sets off."""

    rate: float  # size of its complex exponent
    decay: float  # real part of that
    acceleration: float  # at first
    mobility: float  # acceleration per force
    lasting: bool  # whether rounding keeps it alive: the fluid's alone is computed from its own closed form


class Method(NamedTuple):
    """What limits the steps of a solver."""

    order: int
    reach: float  # of a step over h
    longest: float  # step over 1 / rate
    stiff: bool  # whether a mode that would allow a longer one is of no more concern


def rates(coefficients: Coefficients, mode: int, deformation: float) -> Rates:
    """Rates of the body about a deformation; K = 1 + 3 Pi1 z^2."""
    mobility = mobility_of(coefficients, mode)
    stiffness = 1.0 + 3.0 * coefficients.duffing * deformation**2
    return Rates(math.sqrt(mobility * stiffness), mobility * coefficients.damping)


class FastestRate(NamedTuple):
    """The fastest of a crawler's rates."""

    name: str
    rate: float  # per unit of time
    decay: float  # of what acts at that rate, per unit of time


def fastest_rate(groups: Groups, scene: Scene, deformation: float) -> FastestRate:
    """The fastest of a crawler's rates about a deformation."""
    coefficients = coefficients_of(groups, scene)
    lag = coefficients.lag_rate
    found = [FastestRate("the lag of the fluid (deborah)", lag, lag)]
    for mode, phase in ((STUCK, "resting"), (FORWARD, "sliding")):
        if mode == STUCK or not scene.anchored:
            frequency, damping = rates(coefficients, mode, deformation)
            on = f"over a {phase} foot"
            found.append(FastestRate(f"the damping {on} (damping_ratio, foot_mass_fraction)", damping, damping))
            found.append(FastestRate(f"the spring {on} (duffing, foot_mass_fraction)", frequency, 0.5 * damping))
    return max(found, key=lambda fastest: fastest.rate)


def predicted_cost(solver: str, groups: Groups, scene: Scene, hold: float, tolerance: float) -> float:
    """Cost of one unit of time.

    Parameters
    ----------
    solver : str
        "taylor" or "radau", or for linear groups "closed_form".
    groups : Groups
    scene : Scene
        Any but a chain's.
    hold : float, in (0, inf)
    tolerance : float, in [1e-15, 1e-2]

    Returns
    -------
    float
        About microseconds, on the machine that `benchmarks/results/solver_choice.json` describes: to be compared.
    """
    each = {
        "taylor": _TAYLOR_STEP + _TAYLOR_ORDER * order_for(tolerance),
        "radau": _RADAU_STAGE * stages_for(tolerance),
        "closed_form": _LOOK,
    }[solver]
    return each * predicted_steps(solver, groups, scene, hold, tolerance)


# A choice asks for the steps and for the cost, and the members of a batch are often alike.
@lru_cache(maxsize=1024)
def predicted_steps(solver: str, groups: Groups, scene: Scene, hold: float, tolerance: float) -> float:
    """Steps that one unit of time takes, or looks for events in closed form; parameters as for `predicted_cost`."""
    groups, scene, unit = as_crawler(groups, scene)
    spell = hold / unit
    coefficients = coefficients_of(groups, scene)
    deformation = _held_stretch(groups)
    push = 1.0 + groups.radial_coupling * deformation
    resting = _body_modes(coefficients, STUCK, deformation, push, 0.0)
    moving = [(1.0, resting)]
    loose = not scene.anchored and groups.static_friction < resting[0].acceleration / resting[0].mobility
    if loose:
        part = _SLIDING if groups.kinetic_friction > 0.0 else 1.0
        jump = groups.static_friction - groups.kinetic_friction
        moving = [(1.0 - part, resting), (part, _body_modes(coefficients, FORWARD, deformation, push, jump))]

    if solver == "closed_form":
        count = 1.0 if scene.anchored else 2.0 if scene.ratchet else 3.0
        if loose:
            count += sum(part * _looks_at(modes[0], spell) for part, modes in moving)
    else:
        method = _method(solver, tolerance)
        lag = coefficients.lag_rate
        fluid = Mode(lag, lag, resting[0].mobility * push, resting[0].mobility, lasting=False)
        # Collocation begins the sliding anew, a Taylor series begins every step anew.
        count = 2.0 if loose and method.stiff else 1.0
        count += _steps_through(fluid, spell, tolerance, method)
        for part, modes in moving:
            count += part * sum(_steps_through(mode, spell, tolerance, method) for mode in modes)
    return count / hold


def _held_stretch(groups: Groups) -> float:
    """Deformation at which the full pressure holds the body: the root of Pi1 z^3 + (1 - Pi5) z = 1.

    Where nothing would hold it, that of a body without radial coupling.
    """
    cubic, linear = groups.duffing, 1.0 - groups.radial_coupling
    if cubic == 0.0:
        return 1.0 / linear if linear > 0.0 else 1.0
    alone = cubic ** (-1.0 / 3.0)
    z = min(alone, 1.0 / linear) if linear > 0.0 else alone + math.sqrt(-linear) / math.sqrt(cubic)
    for _ in range(_REFINEMENTS):
        square = cubic * z * z
        z -= (z * (square + linear) - 1.0) / (3.0 * square + linear)
    return min(z, FARTHEST)


def _body_modes(coefficients: Coefficients, mode: int, deformation: float, push: float, jump: float) -> list[Mode]:
    """Modes of the body about a deformation, the fastest first.

    The pressure sets them off by a change of force `push` that takes the time of its lag, and a foot that breaks loose
    by a sudden one, `jump`.
    """
    mobility = mobility_of(coefficients, mode)
    frequency, damping = rates(coefficients, mode, deformation)
    fast, decay, slow = frequency, 0.5 * damping, 0.0
    if decay >= frequency:
        fast = decay + math.sqrt(decay - frequency) * math.sqrt(decay + frequency)
        decay, slow = fast, frequency * (frequency / fast)

    def set_off(rate: float) -> float:
        return mobility * max(push / (1.0 + rate / coefficients.lag_rate), jump)

    modes = [Mode(fast, decay, set_off(fast), mobility, lasting=True)]
    if slow > 0.0:
        modes.append(Mode(slow, slow, set_off(slow) * (slow / fast), mobility, lasting=True))
    return modes


def _method(solver: str, tolerance: float) -> Method:
    if solver == "taylor":
        order = order_for(tolerance)
        return Method(order, _TAYLOR_REACH, _TAYLOR_STABLE * order, stiff=False)
    stages = stages_for(tolerance)
    return Method(stages, _RADAU_REACH, _RADAU_FAINT * math.exp(math.lgamma(stages + 1) / stages), stiff=True)


def _steps_through(mode: Mode, span: float, tolerance: float, method: Method) -> float:
    """Steps that a mode asks for in the time `span` after it was set off."""
    # A Taylor series keeps the tolerance in the acceleration; Radau in the force, the velocity and the deformation.
    size = mode.acceleration
    if method.stiff:
        size *= max(1.0 / mode.mobility, 1.0 / mode.rate, 1.0 / mode.rate / mode.rate)
    if not (size < math.inf and mode.rate < math.inf):
        return math.inf
    afterwards = mode.rate / method.longest if mode.lasting and not method.stiff else 0.0
    reach = 0.0
    if size > 0.0:
        exponent = (math.lgamma(method.order + 1) + math.log(tolerance) - math.log(size)) / method.order
        reach = method.reach * math.exp(exponent)
    if size == 0.0 or reach >= method.longest:
        return span * afterwards
    lengthening = mode.decay / method.order
    alive = span
    if lengthening * span > math.log(method.longest / reach):
        alive = math.log(method.longest / reach) / lengthening
    mean = -math.expm1(-lengthening * alive) / (lengthening * alive) if lengthening * alive > 0.0 else 1.0
    return alive * mean * mode.rate / reach + (span - alive) * afterwards


def _looks_at(mode: Mode, span: float) -> float:
    """Looks for events that a mode asks for in the time `span` after it was set off."""
    alive = span if mode.decay * span < _LOOKED_AT else _LOOKED_AT / mode.decay
    return _LOOKS_A_RADIAN * mode.rate * alive
