"""How far a run has come, as an array that compiled code shares with Python.

Python hears of an interrupt between two calls of compiled code, so a run is made of many short calls, and goes on from
call to call as if it were one. What passes between them are numbers: compiled code would make a tuple class by calling
Python, which fails while an interrupt is pending, and numba's code for that does not survive the failure.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled, formula
from .body import Body, Ledger
from .control import Outcome, Pace, PAUSED

__all__ = ["keep", "opening_of", "outcome_of", "run_through", "steps_of_a_call", "stretch_of"]

# Steps of one call: some tens of milliseconds.
PAUSE_AFTER = 20_000
_BODY, _OPENING, _SIZE = 4, 18, 28


def run_through(kernel: Callable[..., None], body: Body, *arguments: Any) -> tuple[Outcome, int]:
    """Call a kernel until its run has ended.

    Parameters
    ----------
    kernel : callable
        Takes the state of the run, an array that `keep` writes, and the `arguments`; it goes on with the run until
        that has ended or has taken the steps of one call.
    body : Body
        At the start.
    *arguments
        The same for each call.

    Returns
    -------
    outcome : Outcome
        Of the last hold begun, with the steps and events of all.
    finished : int
        Holds completed.
    """
    state = np.zeros(_SIZE)
    state[0] = PAUSED
    state[26] = PAUSE_AFTER
    state[_BODY : _BODY + len(body)] = state[_OPENING : _OPENING + len(body)] = body
    while state[0] == PAUSED:
        kernel(state, *arguments)
    numbers = state.tolist()
    return outcome_of(numbers), stretch_of(numbers) // 2


@compiled
def keep(state: NDArray[np.float64], outcome: Outcome, stretch: int, opening: Body) -> None:
    """Write down the outcome so far, the stretch of the valve that is reached, and the body at its begin."""
    ledger, pace = outcome.ledger, outcome.pace
    state[0], state[1], state[2], state[3] = outcome.status, outcome.elapsed, outcome.steps, outcome.logged
    _write_body(state[4:11], outcome.body)
    state[11], state[12], state[13], state[27] = ledger.work, ledger.viscous, ledger.friction, ledger.flow
    state[14], state[15], state[16], state[17] = pace.length, pace.span, pace.begin, pace.error
    _write_body(state[18:25], opening)
    state[25] = stretch


@compiled
def _write_body(into: NDArray[np.float64], body: Body) -> None:
    into[0], into[1], into[2], into[3] = body.deformation, body.velocity, body.pressure, body.foot
    into[4], into[5], into[6] = body.foot_velocity, body.motion, body.slips


@formula
def outcome_of(state: Any) -> Outcome:
    """The outcome of a run so far."""
    return Outcome(
        int(state[0]),
        state[1],
        int(state[2]),
        int(state[3]),
        Body(state[4], state[5], state[6], state[7], state[8], int(state[9]), int(state[10])),
        Ledger(state[11], state[12], state[13], state[27]),
        Pace(state[14], state[15], state[16], state[17], 0.0),
    )


@formula
def opening_of(state: Any) -> Body:
    """The body at the begin of the stretch that is reached."""
    return Body(state[18], state[19], state[20], state[21], state[22], int(state[23]), int(state[24]))


@formula
def stretch_of(state: Any) -> int:
    """The stretch that is reached: two a hold, one with the valve open and one with it shut."""
    return int(state[25])


@formula
def steps_of_a_call(state: Any) -> int:
    """Steps until the next pause."""
    return int(state[26])
