"""How far a run has come, as an array that compiled code shares with Python.

Python hears of an interrupt between two calls of compiled code, so a run is made of many short calls, and goes on from
call to call as if it were one. What passes between them are numbers: compiled code would make a tuple class by calling
Python, which fails while an interrupt is pending, and numba's code for that does not survive the failure.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, formula
from ..model.state import Body, Ledger
from ..steps.options import Hold, Outcome, Pace, PAUSED

__all__ = ["keep", "opening_of", "outcome_of", "run_through", "steps_of_a_call", "stretch_at", "stretch_of"]

# Steps of one call: some tens of milliseconds.
PAUSE_AFTER = 20_000
# Where in the array each begins: status, elapsed time, steps and events, then the fields of what is named, in order.
_BODY, _LEDGER, _PACE, _OPENING, _STRETCH, _CALL, _SIZE = 4, 11, 15, 19, 26, 27, 28


def run_through(kernel: Callable[..., None], weight: int, body: Body, *arguments: Any) -> tuple[Outcome, int]:
    """Call a kernel until its run has ended.

    Parameters
    ----------
    kernel : callable
        Takes the state of the run, an array that `keep` writes, and the `arguments`; it goes on with the run until
        that has ended or has taken the steps of one call.
    weight : int
        How many times as long as a crawler's step one takes.
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
    state[_CALL] = max(1, PAUSE_AFTER // weight)
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
    _write_body(state[_BODY:], outcome.body)
    _write_four(state[_LEDGER:], ledger.work, ledger.viscous, ledger.friction, ledger.flow)
    _write_four(state[_PACE:], pace.length, pace.span, pace.begin, pace.error)
    _write_body(state[_OPENING:], opening)
    state[_STRETCH] = stretch


@compiled
def _write_body(into: NDArray[np.float64], body: Body) -> None:
    _write_four(into, body.deformation, body.velocity, body.pressure, body.foot)
    into[4], into[5], into[6] = body.foot_velocity, body.mode, body.slips


@compiled
def _write_four(into: NDArray[np.float64], first: float, second: float, third: float, fourth: float) -> None:
    into[0], into[1], into[2], into[3] = first, second, third, fourth


@formula
def outcome_of(state: Any) -> Outcome:
    """The outcome of a run so far."""
    ledger, pace = state[_LEDGER:_PACE], state[_PACE:_OPENING]
    return Outcome(
        int(state[0]),
        state[1],
        int(state[2]),
        int(state[3]),
        _body_of(state[_BODY:_LEDGER]),
        Ledger(ledger[0], ledger[1], ledger[2], ledger[3]),
        # The doubt is of the step that was taken, and the next one has its own.
        Pace(pace[0], pace[1], pace[2], pace[3], 0.0),
    )


@formula
def opening_of(state: Any) -> Body:
    """The body at the begin of the stretch that is reached."""
    return _body_of(state[_OPENING:_STRETCH])


@formula
def _body_of(numbers: Any) -> Body:
    return Body(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], int(numbers[5]), int(numbers[6]))


@formula
def stretch_of(state: Any) -> int:
    """The stretch that is reached: two a hold, one with the valve open and one with it shut."""
    return int(state[_STRETCH])


@formula
def steps_of_a_call(state: Any) -> int:
    """Steps until the next pause."""
    return int(state[_CALL])


@compiled
def stretch_at(stretch: int, schedule: NDArray[np.float64], hold: float) -> Hold:
    """The part of a hold that a stretch is."""
    k = stretch // 2
    opened = schedule[k] * hold
    if stretch % 2 == 0:
        return Hold(1.0, hold, 0.0, opened, k * hold)
    return Hold(0.0, hold, opened, hold, k * hold)
