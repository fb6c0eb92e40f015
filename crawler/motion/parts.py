"""What the loop needs of a method, and the parts of those whose steps are polynomials of one body."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import inlined
from ..model.equations import pressure_after
from ..model.state import Body, Ledger
from ..stability.lyapunov import note_growth
from ..stability.tangent import carry, saltate
from ..steps.options import Pace, Situation
from ..steps.radau import radau_step
from ..steps.taylor import state_at, taylor_step
from ..steps.workspace import CHANGES
from .energy import account
from .events import next_event
from .sampling import BODY_ROWS, record

__all__ = ["RADAU", "SERIES", "Parts", "note"]


class Parts(NamedTuple):
    """The parts of the loop that differ from method to method: functions of compiled code.

    Each takes the `Situation` at the start of a step first, and all but the first what the step knows of the motion
    `ahead` next.
    """

    # pace -> length, ahead, pace. The longest step, nan where there is none.
    step: Callable[..., Any]
    # length, pace, budget -> length, mode, looks. The step up to its first event, the mode that follows, and what the
    # search took of the budget besides the step, or -1 if that did not suffice.
    event: Callable[..., Any]
    # length, moment, column, samples -> Body. Write down the state at a moment of the hold, at most `length` away.
    sample: Callable[..., Any]
    # longest, length, reached, last, sampled -> Body. The state at the end of the step, `reached` in the hold; `last`
    # if that is the end of the valve's stretch. `sampled` is the latest sample.
    arrive: Callable[..., Any]
    # ledger, following, length -> Ledger. Add the energies of the step, which has led to the body `following`.
    energies: Callable[..., Any]
    # following, length -> None. Carry the tangents over the step.
    tangents: Callable[..., Any]
    # following, mode, time -> None. Carry the tangents across the event at its end.
    tangents_across: Callable[..., Any]
    # samples -> None. Where these have rows for it, write down how far tangents have grown by the stretch's end; alone
    # it takes nothing that the step knows.
    growth: Callable[..., Any]


@inlined
def _event(now: Situation, end: Body, length: float, pace: Pace, _budget: int) -> tuple[float, int, int]:
    options, series = now.options, now.workspace
    length, mode = next_event(
        now.body, end, now.coefficients, now.hold.valve, options.order, length, options.tolerance, pace.doubt, series
    )
    return length, mode, 0


@inlined
def _sample(
    now: Situation, _end: Body, length: float, moment: float, column: int, samples: NDArray[np.float64]
) -> Body:
    # The pressure is that of this very moment, not of a step's end within rounding of it.
    sampled = _state(now, moment, min(moment - now.elapsed, length))
    record(sampled, samples, column)
    return sampled


@inlined
def _arrive(
    now: Situation, end: Body, longest: float, length: float, reached: float, _last: bool, _sampled: Body
) -> Body:
    return _state(now, reached, length) if length < longest else end


@inlined
def _state(now: Situation, moment: float, since: float) -> Body:
    """State at a moment of the hold, the time `since` into the step."""
    pressure = pressure_after(now.opening, now.coefficients, now.hold.valve, moment - now.hold.begin)
    return state_at(now.body, now.coefficients, pressure, now.options.order, since, now.workspace)


@inlined
def _account(now: Situation, _end: Body, ledger: Ledger, following: Body, length: float) -> Ledger:
    return account(ledger, now.body, following, now.coefficients, now.options.method, length, now.workspace)


@inlined
def _carry(now: Situation, _end: Body, _following: Body, length: float) -> None:
    carry(now.body, now.coefficients, now.options.order, length, now.workspace)


@inlined
def _saltate(now: Situation, _end: Body, following: Body, mode: int, time: float) -> None:
    saltate(following, mode, now.coefficients, now.hold.valve, time, now.workspace)


@inlined
def note(now: Situation, samples: NDArray[np.float64]) -> None:
    """Write the growth of tangents below the last sample of a body, where there are rows for it."""
    workspace = now.workspace
    if samples.shape[0] > BODY_ROWS:
        tangents = workspace[workspace.shape[0] - CHANGES :]
        note_growth(now.coefficients, tangents, samples[BODY_ROWS:, samples.shape[1] - 1])


SERIES = Parts(taylor_step, _event, _sample, _arrive, _account, _carry, _saltate, note)
RADAU = SERIES._replace(step=radau_step)
