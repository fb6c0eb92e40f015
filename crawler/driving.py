"""A crawler through its schedule, whichever way a hold is advanced."""

import math
from typing import Any

import numpy as np
from numba.extending import overload
from numpy.typing import NDArray

from ..compilation import compiled, OPTIONS
from .advance import advance
from .body import Body, Ledger, Physics
from .control import ClosedForm, Control, FINISHED, method_of, Outcome
from .linear import advance_linear

__all__ = ["advance_by_method", "drive"]


def advance_by_method(
    body: Body,
    ledger: Ledger,
    physics: Physics,
    valve: float,
    hold: float,
    control: Control,
    start: float,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: NDArray[np.float64],
    begin: float = 0.0,
    end: float = math.inf,
) -> Outcome:
    """A hold or a part of one by the control's method, in compiled code alone: see `advance`, `advance_linear`."""
    raise NotImplementedError


@overload(advance_by_method, jit_options=OPTIONS)
def _compiled_advance(
    body: Body,
    ledger: Ledger,
    physics: Physics,
    valve: float,
    hold: float,
    control: Control,
    start: float,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: NDArray[np.float64],
    begin: float = 0.0,
    end: float = math.inf,
) -> Any:
    kernel: Any = advance_linear if method_of(control) is ClosedForm else advance
    return kernel.py_func


@compiled
def drive(
    body: Body,
    coefficients: Physics,
    schedule: NDArray[np.float64],
    hold: float,
    control: Control,
    samples: NDArray[np.float64],
    events: NDArray[np.float64],
    workspace: NDArray[np.float64],
) -> tuple[Outcome, int]:
    """Advance one crawler through its schedule.

    Parameters
    ----------
    body : Body
    coefficients : Physics
    schedule : (holds,) array
        Duty cycles: the share of each hold that the valve is open, at its start.
    hold : float
    control : Control
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
    each = samples.shape[1] // len(schedule)
    ledger = Ledger(0.0, 0.0, 0.0)
    logged = 0
    steps = 0
    # Every hold is a stretch of the open valve and one of the shut; most often one of the two is empty.
    for stretch in range(2 * len(schedule)):
        k = stretch // 2
        opened = schedule[k] * hold
        valve, begin, end = (1.0, 0.0, opened) if stretch % 2 == 0 else (0.0, opened, hold)
        if not begin < end:
            continue
        left = Control(
            control.tolerance,
            control.order,
            control.max_steps - steps,
            control.energy,
            control.log,
            control.method,
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
        )
        body = outcome.body
        ledger = outcome.ledger
        logged += outcome.logged
        steps += outcome.steps
        if outcome.status != FINISHED:
            return Outcome(outcome.status, outcome.elapsed, steps, logged, body, ledger), k
    return Outcome(FINISHED, hold, steps, logged, body, ledger), len(schedule)
