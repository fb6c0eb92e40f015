"""What a run will cost by each solver, predicted from how fast and how stiff the crawler is.

Cost is steps times what a step takes. The body is taken to be linear about the deformation at which the full pressure
holds it, and its motion to be a sum of transients: the lag of the fluid and, for each motion of the foot, an
oscillation or a fast and a slow relaxation. Every turn of the valve sets them off. The n-th term of one a e^(-decay t)
whose n-th derivative is rate^n as large stays below the tolerance in a step of length

    h(t) = (n! tolerance / a)^(1 / n) e^(decay t / n) / rate,

and the steps it takes are the integral of 1 / h. They lengthen as it dies, and what it costs once it is dead tells the
solvers apart: a Taylor series stays within so many of its time constants for ever, and Radau collocation is free of it.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiling.compilation import compiled, formula
from .model.columns import coefficients_at, is_linear_at
from .model.equations import force, mobility_of, stiffness_at
from .model.groups import Groups
from .model.scene import Scene
from .model.state import Coefficients, coefficients_of, FORWARD, STUCK
from .model.tube import as_crawler, is_chain, node_masses
from .motion.sampling import FARTHEST
from .steps.options import STEPS_A_HOLD
from .steps.radau import stages_for
from .steps.taylor import order_for

__all__ = ["PREDICTED", "FastestRate", "cheapest_of_each", "fastest_rate", "predicted_cost", "predicted_steps"]

PREDICTED = ("closed_form", "taylor", "radau")
"""Solvers whose cost is known, in the order in which the first of the cheapest is taken."""

_CLOSED_FORM, _TAYLOR, _RADAU = range(len(PREDICTED))
# Microseconds that a step takes with its events, by Taylor, and more for each order, and by Radau for each stage; a
# look for events in closed form takes a third of a Taylor step of the same crawler. Only their ratios matter.
# `benchmarks/solver_choice.py` prints them, and the steps predicted over those counted, by which the other constants
# were set; a third more or less of any changes little.
_TAYLOR_STEP, _TAYLOR_ORDER, _RADAU_STAGE, _LOOK = 0.25, 0.012, 0.3, 0.13
# Length of a step over h above.
_TAYLOR_REACH, _RADAU_REACH = 1.2, 2.5
# Longest step of a Taylor series over order / rate: a longer one would make a dead transient grow again.
_TAYLOR_STABLE = 0.5
# A transient that Radau could cross in steps of so many (n!)^(1 / n) / rate is too faint to be followed.
_RADAU_FAINT = 2.0
# Part of the time for which a foot that breaks loose slides, if friction stops it again.
_SLIDING = 0.5
# Looks for each radian of the oscillation, and the time constants after which it is too faint to be looked at.
_LOOKS_A_RADIAN, _LOOKED_AT = 1.5, 3.0
# Steps counted over steps predicted, which few exceed.
_DOUBT = 2.0
# Newton steps from at most twice the root of a function that is convex from there down to it: none goes too far.
_REFINEMENTS = 10


class Rates(NamedTuple):
    """How fast the body moves in one motion of its foot, per unit of time."""

    frequency: float  # sqrt(K / m): of its oscillation, were there no damping
    damping: float  # 2 Pi2 / m: of a stretch that nothing drives


class Transient(NamedTuple):
    """One term of the motion that a turn of the valve sets off."""

    rate: float  # size of its complex exponent
    decay: float  # real part of that
    acceleration: float  # at first
    mobility: float  # acceleration per force
    lasting: bool  # whether rounding keeps it alive: the fluid's alone is computed from its own closed form


class Method(NamedTuple):
    """What limits the steps of a solver."""

    order: int
    digits: float  # ln(order! tolerance)
    reach: float  # of a step over h
    longest: float  # step over 1 / rate
    stiff: bool  # whether a transient that would allow a longer one is of no more concern


@formula
def rates(coefficients: Coefficients, mode: int, deformation: float) -> Rates:
    """Rates of the body about a deformation, without pressure."""
    mobility = mobility_of(coefficients, mode)
    stiffness = stiffness_at(coefficients, deformation, 0.0)
    return Rates(math.sqrt(mobility * stiffness), mobility * coefficients.damping)


class FastestRate(NamedTuple):
    """The fastest of a crawler's rates."""

    name: str
    rate: float  # per unit of time
    decay: float  # of what acts at that rate, per unit of time


def fastest_rate(groups: Groups, scene: Scene, deformation: float) -> FastestRate:
    """The fastest of a crawler's or a chain's rates about a deformation, of all segments alike."""
    coefficients = coefficients_of(groups, scene)
    lag = coefficients.lag_rate
    found = [FastestRate("the lag of the fluid (deborah)", lag, lag)]
    of, masses = "", "foot_mass_fraction"
    if is_chain(scene):
        of, masses = " of the segments", "segments, tube_mass"
    for mode, phase in ((STUCK, "resting"), (FORWARD, "sliding")):
        if mode == STUCK or not scene.anchored:
            if is_chain(scene):
                frequency, damping = _rates_of_chain(groups, scene, mode, deformation)
            else:
                frequency, damping = rates(coefficients, mode, deformation)
            on = f"{of} over a {phase} foot"
            found.append(FastestRate(f"the damping{on} (damping_ratio, {masses})", damping, damping))
            found.append(FastestRate(f"the spring{on} (duffing, {masses})", frequency, 0.5 * damping))
    return max(found, key=lambda fastest: fastest.rate)


def _rates_of_chain(groups: Groups, scene: Scene, mode: int, deformation: float) -> Rates:
    """Rates of a chain's fastest mode about a deformation, without pressure.

    Its nodes obey m_j u_j' = F_j - F_{j+1} and its segments D_i' = N (u_i - u_{i-1}), so that both rates are those of a
    crawler whose mobility is the largest eigenvalue of a tridiagonal matrix.
    """
    from scipy.linalg import eigh_tridiagonal  # whose import is long, and a refusal is rare

    mobility = 1.0 / node_masses(groups, scene)
    if mode == STUCK:
        mobility[0] = 0.0
    last = scene.segments - 1
    [largest] = eigh_tridiagonal(
        mobility[:-1] + mobility[1:], -mobility[1:-1], eigvals_only=True, select="i", select_range=(last, last)
    )
    mobility_of_mode = scene.segments * float(largest)
    coefficients = coefficients_of(groups, scene)
    stiffness = stiffness_at(coefficients, deformation, 0.0)
    return Rates(math.sqrt(mobility_of_mode * stiffness), mobility_of_mode * coefficients.damping)


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
    return _predicted(solver, groups, scene, hold, tolerance)[1]


def predicted_steps(solver: str, groups: Groups, scene: Scene, hold: float, tolerance: float) -> float:
    """Steps that one unit of time takes, or looks for events in closed form; parameters as for `predicted_cost`."""
    return _predicted(solver, groups, scene, hold, tolerance)[0]


def _predicted(solver: str, groups: Groups, scene: Scene, hold: float, tolerance: float) -> tuple[float, float]:
    groups, scene, unit = as_crawler(groups, scene)
    columns = np.array(coefficients_of(groups, scene), dtype=np.float64)[:, np.newaxis]
    _, predictions = _choices_of(columns, np.array([hold]), np.array([unit]), tolerance)
    steps, cost = predictions[:, PREDICTED.index(solver)].tolist()
    return steps, cost


def cheapest_of_each(
    coefficients: NDArray[np.float64], holds: NDArray[np.float64], units: NDArray[np.float64], tolerance: float
) -> NDArray[np.int8]:
    """Which of `PREDICTED` is predicted to be cheapest of those that keep to the step budget, crawler by crawler.

    Parameters
    ----------
    coefficients : (11, n) array
        Fields of `Coefficients`, of crawlers of one body as `as_crawler` has them.
    holds : (n,) array, in (0, inf)
    units : (n,) array
        Of time, from `as_crawler`.
    tolerance : float, in [1e-15, 1e-2]

    Returns
    -------
    (n,) array of int8
    """
    return _choices_of(coefficients, holds, units, tolerance)[0]


def _choices_of(
    columns: NDArray[np.float64], holds: NDArray[np.float64], units: NDArray[np.float64], tolerance: float
) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """The choices, and of the last crawler the steps and the cost of one unit of time by each solver."""
    choices, predictions = np.empty(len(holds), np.int8), np.empty((2, len(PREDICTED)))
    orders = order_for(tolerance), stages_for(tolerance)
    _choose(columns, holds, holds / units, *orders, tolerance, predictions, choices)
    return choices, predictions


@compiled
def _choose(
    columns: NDArray[np.float64],
    holds: NDArray[np.float64],
    spells: NDArray[np.float64],
    order: int,
    stages: int,
    tolerance: float,
    predictions: NDArray[np.float64],
    choices: NDArray[np.int8],
) -> None:
    for i in range(len(holds)):
        # Crawlers are often alike.
        if i > 0 and _is_as_before(columns, holds, spells, i):
            choices[i] = choices[i - 1]
            continue
        first = _CLOSED_FORM if is_linear_at(columns, i) else _TAYLOR
        _predict(columns, holds, spells, order, stages, tolerance, i, predictions)
        best = first
        for solver in range(first + 1, len(PREDICTED)):
            if predictions[1, solver] < predictions[1, best]:
                best = solver
        if holds[i] * predictions[0, best] > STEPS_A_HOLD:
            # Rather dear than not finished, where another surely finishes.
            best = first
            for solver in range(first + 1, len(PREDICTED)):
                doubtful = holds[i] * predictions[0, solver] * _DOUBT > STEPS_A_HOLD
                worse = holds[i] * predictions[0, best] * _DOUBT > STEPS_A_HOLD
                if doubtful < worse or (doubtful == worse and predictions[1, solver] < predictions[1, best]):
                    best = solver
        choices[i] = best


@compiled
def _is_as_before(
    columns: NDArray[np.float64], holds: NDArray[np.float64], spells: NDArray[np.float64], i: int
) -> bool:
    """Whether the crawler in column `i` is the one before it over again."""
    same = holds[i] == holds[i - 1] and spells[i] == spells[i - 1]
    for row in range(len(columns)):
        same = same and columns[row, i] == columns[row, i - 1]
    return same


@compiled
def _predict(
    columns: NDArray[np.float64],
    holds: NDArray[np.float64],
    spells: NDArray[np.float64],
    order: int,
    stages: int,
    tolerance: float,
    i: int,
    predictions: NDArray[np.float64],
) -> None:
    """Write the steps and the cost of one unit of time by each solver, of the crawler in column `i`.

    `spells` are the holds in each crawler's own unit of time.
    """
    coefficients = coefficients_at(columns, i)
    costs = (_LOOK, _TAYLOR_STEP + _TAYLOR_ORDER * order, _RADAU_STAGE * stages)
    for solver in range(len(PREDICTED)):
        steps = _steps_of(solver, coefficients, spells[i], order, stages, tolerance) / holds[i]
        predictions[0, solver] = steps
        predictions[1, solver] = costs[solver] * steps


@formula
def _steps_of(
    solver: int, coefficients: Coefficients, spell: float, order: int, stages: int, tolerance: float
) -> float:
    """Steps of a hold, which lasts for `spell`."""
    deformation = _held_stretch(coefficients)
    push = 1.0 + coefficients.radial_coupling * deformation
    resting, resting_slow = _body_transients(coefficients, STUCK, deformation, push, 0.0)
    sliding, sliding_slow = resting, resting_slow
    part = 0.0
    loose = not coefficients.anchored and coefficients.static_friction < resting.acceleration / resting.mobility
    if loose:
        part = _SLIDING if coefficients.kinetic_friction > 0.0 else 1.0
        jump = coefficients.static_friction - coefficients.kinetic_friction
        sliding, sliding_slow = _body_transients(coefficients, FORWARD, deformation, push, jump)

    if solver == _CLOSED_FORM:
        count = 1.0 if coefficients.anchored else 2.0 if coefficients.ratchet else 3.0
        if loose:
            count += (1.0 - part) * _looks_at(resting, spell) + part * _looks_at(sliding, spell)
        return count
    method = _method(solver, order, stages, tolerance)
    lag = coefficients.lag_rate
    fluid = Transient(lag, lag, resting.mobility * push, resting.mobility, False)
    # Collocation begins the sliding anew, a Taylor series begins every step anew.
    count = 2.0 if loose and method.stiff else 1.0
    count += _steps_through(fluid, spell, method)
    rests = _steps_through(resting, spell, method) + _steps_through(resting_slow, spell, method)
    count += (1.0 - part) * rests
    if loose:
        slides = _steps_through(sliding, spell, method)
        slides += _steps_through(sliding_slow, spell, method)
        count += part * slides
    return count


@formula
def _held_stretch(coefficients: Coefficients) -> float:
    """Deformation at which the full pressure holds the body: the root of its force at rest.

    Where nothing would hold it, that of a body without radial coupling.
    """
    cubic, linear = coefficients.duffing, 1.0 - coefficients.radial_coupling
    if cubic == 0.0 and linear <= 0.0:
        return 1.0
    alone = cubic ** (-1.0 / 3.0) if cubic > 0.0 else math.inf
    z = min(alone, 1.0 / linear) if linear > 0.0 else alone + math.sqrt(-linear) / math.sqrt(cubic)
    for _ in range(_REFINEMENTS):
        lower = z + force(coefficients, z, 0.0, 1.0) / stiffness_at(coefficients, z, 1.0)
        if not 0.0 < lower < z:
            break
        z = lower
    return min(z, FARTHEST)


@formula
def _body_transients(
    coefficients: Coefficients, mode: int, deformation: float, push: float, jump: float
) -> tuple[Transient, Transient]:
    """Transients of the body about a deformation, the fastest first; the second has the rate 0 where there is but one.

    The pressure sets them off by a change of force `push` that takes the time of its lag, and a foot that breaks loose
    by a sudden one, `jump`.
    """
    mobility = mobility_of(coefficients, mode)
    frequency, damping = rates(coefficients, mode, deformation)
    fast, decay, slow = frequency, 0.5 * damping, 0.0
    if decay >= frequency:
        fast = decay + math.sqrt(decay - frequency) * math.sqrt(decay + frequency)
        decay, slow = fast, frequency * (frequency / fast)
    # What sets off a transient of that rate.
    sudden = mobility * max(push / (1.0 + fast / coefficients.lag_rate), jump)
    gradual = mobility * max(push / (1.0 + slow / coefficients.lag_rate), jump)
    return Transient(fast, decay, sudden, mobility, True), Transient(
        slow, slow, gradual * (slow / fast), mobility, True
    )


@formula
def _method(solver: int, order: int, stages: int, tolerance: float) -> Method:
    if solver == _TAYLOR:
        digits = math.lgamma(order + 1.0) + math.log(tolerance)
        return Method(order, digits, _TAYLOR_REACH, _TAYLOR_STABLE * order, False)
    factorial = math.lgamma(stages + 1.0)
    longest = _RADAU_FAINT * math.exp(factorial / stages)
    return Method(stages, factorial + math.log(tolerance), _RADAU_REACH, longest, True)


@formula
def _steps_through(transient: Transient, span: float, method: Method) -> float:
    """Steps that a transient asks for in the time `span` after it was set off."""
    if transient.rate == 0.0:
        return 0.0
    # A Taylor series keeps the tolerance in the acceleration; Radau in the force, the velocity and the deformation.
    size = transient.acceleration
    if method.stiff:
        size *= max(1.0 / transient.mobility, 1.0 / transient.rate, 1.0 / transient.rate / transient.rate)
    if not (size < math.inf and transient.rate < math.inf):
        return math.inf
    afterwards = transient.rate / method.longest if transient.lasting and not method.stiff else 0.0
    reach = 0.0
    if size > 0.0:
        reach = method.reach * math.exp((method.digits - math.log(size)) / method.order)
    if size == 0.0 or reach >= method.longest:
        return span * afterwards
    lengthening = transient.decay / method.order
    alive = span
    if lengthening * span > math.log(method.longest / reach):
        alive = math.log(method.longest / reach) / lengthening
    mean = -math.expm1(-lengthening * alive) / (lengthening * alive) if lengthening * alive > 0.0 else 1.0
    return alive * mean * transient.rate / reach + (span - alive) * afterwards


@formula
def _looks_at(transient: Transient, span: float) -> float:
    """Looks for events that a transient asks for in the time `span` after it was set off."""
    alive = span if transient.decay * span < _LOOKED_AT else _LOOKED_AT / transient.decay
    return _LOOKS_A_RADIAN * transient.rate * alive
