"""One body, one stretch of a constant valve: the loop in which its state moves, whatever makes its steps.

A step ends at whichever comes first: the end of what its method can tell of the smooth motion, the first descent of an
event function through zero, or the end of the stretch: of the hold, or of the part of it that the valve is open or
shut. By series z and v are polynomials between events and the pressure is closed form; the foot follows from the
momentum, on which friction and slope alone act. A linear body is known in closed form up to its next event.
"""

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from ..compiling.compilation import compiled, INLINED
from .closed_form.parts import LINEAR
from .model.state import Body, Coefficients, Ledger
from .motion.chain_parts import CHAIN
from .motion.events import jump
from .motion.parts import Parts, RADAU, SERIES
from .motion.sampling import end_of_step, is_near, moment_of, sampled_by
from .motion.sensitive_parts import SENSITIVE
from .steps.options import (
    AFRESH,
    ClosedForm,
    DIVERGED,
    FINISHED,
    Hold,
    Leg,
    LOG_FULL,
    Method,
    method_of,
    Options,
    OUT_OF_STEPS,
    Outcome,
    PAUSED,
    Radau,
    Recording,
    Situation,
    TAYLOR,
    TaylorChain,
    TaylorSensitive,
)
from .steps.radau import refine_event_step

__all__ = ["advance"]

_PARTS: dict[type[Method], Parts] = {
    **dict.fromkeys(TAYLOR.values(), SERIES),
    Radau: RADAU,
    TaylorChain: CHAIN,
    TaylorSensitive: SENSITIVE,
    ClosedForm: LINEAR,
}


def _part(name: str) -> Callable[..., Any]:
    """A part of the loop, in compiled code alone: that of the method of the situation."""

    def part(*_arguments: Any) -> Any:
        raise NotImplementedError

    @overload(part, jit_options=INLINED, strict=False)
    def _compiled_part(now: Any, *_others: Any) -> Any:
        return getattr(_PARTS[method_of(now[Situation._fields.index("options")])], name)

    return part


_step, _event, _sample, _arrive, _account, _carry, _saltate, _note = map(_part, Parts._fields)


@compiled
def advance(
    body: Body,
    ledger: Ledger,
    coefficients: Coefficients,
    hold: Hold,
    options: Options,
    recording: Recording,
    workspace: Any,
    leg: Leg | None = None,
) -> Outcome:
    """Advance one body by one hold of the valve, or by a part of one.

    Parameters
    ----------
    body, ledger : Body, Ledger
        State and energies at the start of the stretch.
    coefficients : Coefficients
    hold : Hold
    options : Options
        `max_steps` bounds the steps, and the evaluations in search of an event in closed form besides.
    recording : Recording
        Receives the samples that are after the stretch's begin and not after its end, and the events. Where there is no
        room for these the outcome says LOG_FULL, and the run is to be done again from its start with a longer array.
    workspace : array or tuple of arrays
        The solver's.
    leg : Leg, optional
        Where to go on, with the state, the ledger, the samples and the workspace that a pause left; without one the
        stretch is advanced from its begin, and without a pause.

    Returns
    -------
    Outcome
    """
    samples, events = recording.samples, recording.events
    count = samples.shape[1]
    opening = body
    elapsed = hold.begin
    pace = AFRESH
    allowed = options.max_steps
    if leg is not None:
        opening = leg.opening
        elapsed = leg.elapsed
        pace = leg.pace
        allowed = min(allowed, leg.steps)
    done = sampled_by(elapsed, hold.length, count)
    logged = 0
    spent = 0
    while spent < allowed:
        now = Situation(opening, body, coefficients, hold, elapsed, options, workspace)
        longest, ahead, pace = _step(now, pace)
        if not longest >= 0.0:
            return Outcome(DIVERGED, elapsed, spent + 1, logged, body, ledger, pace)
        length, mode, looks = _event(now, ahead, longest, pace, options.max_steps - spent)
        spent += looks + 1
        if looks < 0:
            return Outcome(OUT_OF_STEPS, elapsed, options.max_steps, logged, body, ledger, pace)
        if mode != body.mode:
            pace = refine_event_step(body, coefficients, options.tolerance, pace, length)
            if pace.length > 0.0:
                continue

        reached, last = end_of_step(body, hold.end, elapsed, length, mode)
        following = body
        while done < count:
            moment = moment_of(done, count, hold.length)
            if moment > reached:
                break
            following = _sample(now, ahead, length, moment, done, samples)
            done += 1
        following = _arrive(now, ahead, longest, length, reached, last, following)
        if not is_near(following):
            return Outcome(DIVERGED, elapsed, spent, logged, body, ledger, pace)
        if options.energy:
            ledger = _account(now, ahead, ledger, following, length)
        if options.tangents:
            _carry(now, ahead, following, length)
        elapsed = reached
        if mode != body.mode:
            if options.tangents:
                _saltate(now, ahead, following, mode, hold.start + elapsed)
            following = jump(following, mode, coefficients)
            if options.log:
                if logged == events.shape[0]:
                    return Outcome(LOG_FULL, elapsed, spent, logged, body, ledger, pace)
                events[logged, 0] = hold.start + elapsed
                events[logged, 1] = mode
                logged += 1
        body = following
        if last:
            if options.tangents:
                _note(now, samples)
            return Outcome(FINISHED, hold.end, spent, logged, body, ledger, pace)
    status = PAUSED if allowed < options.max_steps else OUT_OF_STEPS
    return Outcome(status, elapsed, spent, logged, body, ledger, pace)
