"""A crawler through its schedule, whichever way a hold is advanced."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled
from .advance import Control, FINISHED, Outcome
from .body import Body, Ledger, Physics

__all__ = ["driver"]


def driver(advance: Callable[..., Outcome]) -> Callable[..., Any]:
    """Make the kernel that calls `advance` hold after hold; only what is driven is compiled."""

    @compiled
    def drive(
        body: Body,
        coefficients: Physics,
        schedule: NDArray[np.int8],
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
        schedule : (holds,) array of int8
        hold : float
        control : Control
        samples : (5, holds * samples_per_hold) array
            Receives z, v, p, x, w.
        events : (capacity, 2) array
            Receives times and new motions.
        workspace : array
            What `advance` works on.

        Returns
        -------
        outcome : Outcome
            Of the last hold begun, with the number of events of all.
        finished : int
            Holds completed.
        """
        each = samples.shape[1] // len(schedule)
        ledger = Ledger(0.0, 0.0, 0.0)
        logged = 0
        for k in range(len(schedule)):
            outcome = advance(
                body,
                ledger,
                coefficients,
                float(schedule[k]),
                hold,
                control,
                k * hold,
                samples[:, k * each : (k + 1) * each],
                events[logged:],
                workspace,
            )
            body = outcome.body
            ledger = outcome.ledger
            logged += outcome.logged
            if outcome.status != FINISHED:
                return Outcome(outcome.status, outcome.elapsed, logged, body, ledger), k
        return Outcome(FINISHED, hold, logged, body, ledger), len(schedule)

    return drive
