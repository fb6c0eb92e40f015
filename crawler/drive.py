"""A body through its schedule, whatever makes its steps."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compiling.compilation import compiled
from .loop import advance
from .model.state import Body, Coefficients
from .motion.progress import keep, opening_of, outcome_of, run_through, steps_of_a_call, stretch_at, stretch_of
from .motion.sampling import BODY_ROWS
from .steps.options import AFRESH, FINISHED, Leg, Options, Outcome, PAUSED, Recording, SAMPLES_A_STEP

__all__ = ["drive"]


def drive(
    body: Body,
    coefficients: Coefficients,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: Any,
) -> tuple[Outcome, int]:
    """Advance one body through its schedule.

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
        Receives z, v, p, x, w; of a chain (5 + 2 N, holds * samples_per_hold), see `chain_parts`.
    events : (capacity, 2) array
        Receives times and new motions.
    workspace : array or tuple of arrays
        What `advance` works on.

    Returns
    -------
    outcome : Outcome
        Of the last hold begun, with the steps and events of all.
    finished : int
        Holds completed.
    """
    # A step takes as long as there are segments.
    weight = max(1, (len(samples) - BODY_ROWS) // 2)
    return run_through(_drive_on, weight, body, coefficients, schedule, hold, options, samples, events, workspace)


@compiled
def _drive_on(
    state: NDArray[np.float64],
    coefficients: Coefficients,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: Any,
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
        part = stretch_at(stretch, schedule, hold)
        if not part.begin < part.end:
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
        outcome = advance(
            body,
            ledger,
            coefficients,
            part,
            left,
            Recording(samples[:, k * each : (k + 1) * each], events[logged:]),
            workspace,
            Leg(opening, max(part.begin, elapsed), pace, until_pause),
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
