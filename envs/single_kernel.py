"""The solver behind plain arrays.

A named tuple costs microseconds to carry across the border between Python and compiled code, many times the physics
of a hold; an array costs a fraction of one.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiling.compilation import compiled, merged
from ..compiling.generators import next_uniform
from ..crawler.loop import advance
from ..crawler.model.columns import coefficients_in
from ..crawler.model.groups import Groups
from ..crawler.model.scene import Scene
from ..crawler.model.state import Body, Coefficients, coefficients_of, FOOT, NOTHING_YET, SLIPS, State
from ..crawler.refusals import solver_error
from ..crawler.solvers import AUTO, choose
from ..crawler.steps.options import FINISHED, Hold, MAX_STEPS, Method, METHODS, Options, Recording
from ..reservoir.prequential import score
from ..reservoir.targets import aimed
from .calibration import calibration_valves
from .infos import place_of, TOLD, write_told
from .observation import observe, seen_at_rest, valves_seen
from .reward import reward, surprise
from .settings import Settings
from .transition import Transition

__all__ = [
    "ANSWERS",
    "ELAPSED",
    "NO_MEMORY",
    "REWARD",
    "Stepper",
    "calibration_states",
    "rest",
    "samples_of",
    "stepper_for",
    "within_hold",
]

_BODY = len(Body._fields)
_HOLD, _TOLERANCE, _ORDER, _MAX_STEPS, _DITHER, _WEIGHT, _TARGET = range(
    len(Coefficients._fields), len(Coefficients._fields) + 7
)
REWARD, ELAPSED = len(TOLD), len(TOLD) + 1
"""Places of the reward, and of the time into the hold that was reached."""

ANSWERS = len(TOLD) + 2
"""Numbers that a step writes down: `stickslip.envs.infos.TOLD`, and these two."""

NO_MEMORY = np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0))
"""Arrays of a readout that neither scores nor learns."""

Array = NDArray[np.float64]


class Stepper(NamedTuple):
    """How one crawler is stepped, and what stays the same from step to step."""

    step: Callable[..., int]
    fixed: Array  # of `Coefficients`, hold, tolerance, order, step budget, dither, memory weight, of `Target`
    workspace: Array
    solver: str


def rest() -> Array:
    """State of a crawler at rest: the fields of `Body` in order, shape (7,)."""
    return np.zeros(_BODY)


def samples_of(instants: int) -> Array:
    """Place for z, v, p, x, w of the body at so many instants of a hold."""
    return np.empty((len(State._fields), instants))


def stepper_for(settings: Settings, groups: Groups, scene: Scene, *, samples: int | None = None) -> Stepper:
    """The cheapest way to step a crawler, hold by hold; with as many samples of a hold as its readout takes, or other.

    How many there are changes nothing of the motion.
    """
    coefficients = coefficients_of(groups, scene)
    solver = choose(AUTO, groups, scene, settings.hold, settings.tolerance)
    options = solver.options(settings.tolerance)
    numbers = settings.hold, options.tolerance, options.order, options.max_steps
    return Stepper(
        _STEP[type(options.method)],
        np.array([*coefficients, *numbers, settings.dither, settings.memory_weight, *settings.aim]),
        solver.workspace(coefficients, settings.hold, settings.samples if samples is None else samples),
        solver.name,
    )


def calibration_states(settings: Settings) -> Array:
    """States of the body under the calibration's valves, from rest, shape (holds, features).

    Raises
    ------
    SolverError
        If the motion diverges.
    """
    valves = calibration_valves(settings)
    groups, scene = settings.groups, settings.scene
    step, fixed, workspace, solver = stepper_for(settings, groups, scene)
    body, observation, answers = rest(), seen_at_rest(settings.valve_history), np.zeros(ANSWERS)
    samples = samples_of(settings.samples)
    states = np.empty((len(valves), settings.features))
    for k, valve in enumerate(valves.tolist()):
        status = step(body, fixed, valve, 0, 0, samples, workspace, observation, answers, *NO_MEMORY, 0)
        if status != FINISHED:
            began, crawler = k * settings.hold, (groups, scene, settings.tolerance)
            reached, gained = began + float(answers[ELAPSED]), int(body[SLIPS] - answers[place_of("slips")])
            raise solver_error(status, reached, float(body[0]), MAX_STEPS, *crawler, solver, gained, began)
        states[k] = samples[:3].reshape(-1)
    return states


def within_hold(stepper: Stepper, body: Array, valve: int, samples: int, valve_history: int) -> Array:
    """What a crawler does in one hold, sampled: nobody reads it, nothing is drawn, and the state stays as it is.

    Parameters
    ----------
    stepper : Stepper
        For as many samples.
    body : (7,) array
        Where the hold begins.
    valve : int
        As it was held, after the flip.
    samples : int
    valve_history : int
        Of the environment.

    Returns
    -------
    (5, samples) array
        z, v, p, x, w at equal distances, the last at the hold's end.
    """
    taken, observation, answers = samples_of(samples), seen_at_rest(valve_history), np.empty(ANSWERS)
    stepper.step(body.copy(), stepper.fixed, valve, 0, 0, taken, stepper.workspace, observation, answers, *NO_MEMORY, 0)
    return taken


@merged
def _step(
    method: Method,
    body: Array,
    fixed: Array,
    command: int,
    function: int,
    generator: int,
    samples: Array,
    workspace: Array,
    observation: NDArray[np.float32],
    answers: Array,
    weights: Array,
    covariance: Array,
    history: Array,
    rows: Array,
    seen: int,
) -> int:
    """Hold the valve of one crawler as commanded, or flipped, for one hold, in place.

    Parameters
    ----------
    method : Method
    body : (7,) array
        From :func:`rest`; updated.
    fixed : array
        From :func:`stepper_for`.
    command : int
        0 or 1.
    function, generator : int
        Where the random numbers come from, see `stickslip.compiling.generators`; 0 flips no command.
    samples : array
        From :func:`samples_of`; filled.
    workspace : array
        From :func:`stepper_for`.
    observation : array of float32
        Of the step before; receives what `stickslip.envs.observation` names.
    answers : (ANSWERS,) array
        Filled.
    weights, covariance, history, rows, seen
        As `stickslip.reservoir.prequential.score` wants them; of length 0 where there is no message.

    Returns
    -------
    int
        The status, as in `stickslip.crawler.steps.options`. If it is not FINISHED only the time
        reached is told.
    """
    dither = fixed[_DITHER]
    valve = command
    if function != 0 and next_uniform(np.uint64(function), np.uint64(generator)) < dither:
        valve = 1 - command
    start = body[FOOT]
    hold = fixed[_HOLD]
    coefficients = coefficients_in(fixed[:_HOLD])
    outcome = advance(
        Body(body[0], body[1], body[2], body[3], body[4], int(body[5]), int(body[6])),
        NOTHING_YET,
        coefficients,
        Hold(float(valve), hold, 0.0, hold, 0.0),
        Options(fixed[_TOLERANCE], int(fixed[_ORDER]), int(fixed[_MAX_STEPS]), False, False, False, method),
        Recording(samples, workspace[:0]),
        workspace,
    )
    after = outcome.body
    body[0] = after.deformation
    body[1] = after.velocity
    body[2] = after.pressure
    body[3] = after.foot
    body[4] = after.foot_velocity
    body[5] = after.mode
    body[6] = after.slips
    answers[ELAPSED] = outcome.elapsed
    if outcome.status != FINISHED:
        return outcome.status
    memory = 0.0
    if len(weights) > 0:
        mean, variance, lead = fixed[_TARGET + 2], fixed[_TARGET + 3], int(fixed[_TARGET + 4])
        kind, order = int(fixed[_TARGET]), int(fixed[_TARGET + 1])
        message = aimed(kind, order, mean, history[2:], surprise(valve, command, dither))
        memory = score(weights, covariance, history, rows, seen, lead, samples, message, variance)
    valves = int(valves_seen(observation)) << 1 | valve
    step = Transition(start, after, coefficients, command, valve, valves, hold, dither, fixed[_WEIGHT], memory)
    observe(observation, step)
    write_told(answers, step)
    answers[REWARD] = reward(step)
    return outcome.status


def _stepper(method: type[Method]) -> Callable[..., int]:
    # A method cannot be an argument from Python: it would cost more than the physics.
    @compiled
    def step(
        body: Array,
        fixed: Array,
        command: int,
        function: int,
        generator: int,
        samples: Array,
        workspace: Array,
        observation: NDArray[np.float32],
        answers: Array,
        weights: Array,
        covariance: Array,
        history: Array,
        rows: Array,
        seen: int,
    ) -> int:
        return _step(
            method(),
            body,
            fixed,
            command,
            function,
            generator,
            samples,
            workspace,
            observation,
            answers,
            weights,
            covariance,
            history,
            rows,
            seen,
        )

    return step


_STEP = {method: _stepper(method) for method in METHODS}
