"""A crawler through its schedule, whichever way a hold is advanced."""

import math
from typing import Any

import numpy as np
from numba.extending import overload
from numpy.typing import NDArray

from ..compiling.compilation import compiled, OPTIONS
from .closed_form.loop import advance_linear
from .model.state import Body, Coefficients, Ledger
from .motion.loop import advance
from .motion.progress import keep, opening_of, outcome_of, run_through, steps_of_a_call, stretch_at, stretch_of
from .steps.options import AFRESH, ClosedForm, FINISHED, Leg, method_of, Options, Outcome, PAUSED, SAMPLES_A_STEP

__all__ = ["advance_by_method", "drive"]


def advance_by_method(
    body: Body,
    ledger: Ledger,
    coefficients: Coefficients,
    valve: float,
    hold: float,
    options: Options,
    start: float,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: NDArray[np.float64],
    begin: float = 0.0,
    end: float = math.inf,
    leg: Leg | None = None,
) -> Outcome:
    """A hold or a part of one by the method of the options, in compiled code alone: see `advance`, `advance_linear`."""
    raise NotImplementedError


@overload(advance_by_method, jit_options=OPTIONS)
def _compiled_advance(
    body: Body,
    ledger: Ledger,
    coefficients: Coefficients,
    valve: float,
    hold: float,
    options: Options,
    start: float,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: NDArray[np.float64],
    begin: float = 0.0,
    end: float = math.inf,
    leg: Leg | None = None,
) -> Any:
    kernel: Any = advance_linear if method_of(options) is ClosedForm else advance
    return kernel.py_func


def drive(
    body: Body,
    coefficients: Coefficients,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: NDArray[np.float64],
) -> tuple[Outcome, int]:
    """Advance one crawler through its schedule.

    Parameters
    ----------
    body : Body
    coefficients : Coefficients
    schedule : (holds,) array
        Duty cycles: the share of each hold that the valve is open, at its start.
    hold : float
    options : Options
        Its step budget is that of the whole run.
    samples : (5, holds * samples_per_hold) array
        Receives z, v, p, x, w.
    events : (capacity, 2) array
        Receives times and new motions.
    workspace : array
        What `advance` works on.

    Returns
    -------
    outcome : Outcome
        Of the last hold begun, with the steps and events of all.
    finished : int
        Holds completed.
    """
    return run_through(_drive_on, body, coefficients, schedule, hold, options, samples, events, workspace)


@compiled
def _drive_on(
    state: NDArray[np.float64],
    coefficients: Coefficients,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: NDArray[np.float64],
) -> None:
    """Go on with the run that `state` tells of, see `run_through`."""
    so_far = outcome_of(state)
    opening, body, ledger, pace = opening_of(state), so_far.body, so_far.ledger, so_far.pace
    elapsed, steps, logged = so_far.elapsed, so_far.steps, so_far.logged
    each = samples.shape[1] // len(schedule)
    until_pause = steps_of_a_call(state)
    # Every hold is a stretch of the open valve and one of the shut; most often one of the two is empty.
    for stretch in range(stretch_of(state), 2 * len(schedule)):
        k = stretch // 2
        valve, begin, end = stretch_at(stretch, schedule, hold)
        if not begin < end:
            continue
        if until_pause <= 0:
            keep(state, Outcome(PAUSED, elapsed, steps, logged, body, ledger, pace), stretch, opening)
            return
        left = Options(
            options.tolerance,
            options.order,
            options.max_steps - steps,
            options.energy,
            options.log,
            options.tangents,
            options.method,
        )
        outcome = advance_by_method(
            body,
            ledger,
            coefficients,
            valve,
            hold,
            left,
            k * hold,
            samples[:, k * each : (k + 1) * each],
            events[logged:],
            workspace,
            begin,
            end,
            Leg(opening, max(begin, elapsed), pace, until_pause),
        )
        body = outcome.body
        ledger = outcome.ledger
        logged += outcome.logged
        steps += outcome.steps
        until_pause -= outcome.steps + each // SAMPLES_A_STEP
        if outcome.status != FINISHED:
            keep(
                state,
                Outcome(outcome.status, outcome.elapsed, steps, logged, body, ledger, outcome.pace),
                stretch,
                opening,
            )
            return
        opening = body
        elapsed = 0.0
        pace = AFRESH
    keep(state, Outcome(FINISHED, hold, steps, logged, body, ledger, AFRESH), 2 * len(schedule), body)
