"""The parts of the loop for a chain: the crawler's own rules, with a state for each segment.

Its `samples` have (5 + 2 N) rows: those of the crawler, whose z and v are the means of the segments', and then d and d'
of the N segments, foot first.
"""

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled, inlined
from ...compiling.roots import horner, sharp_descent
from ..model.equations import pressure_after
from ..model.state import Body, Coefficients, Ledger, STUCK
from ..stability.chain_growth import carry_chain, note_chain, saltate_chain
from ..steps.chain_series import chain_step, ChainWorkspace, foot_at, stretches_at
from ..steps.options import Pace, Situation
from ..steps.workspace import FORCE, SCRATCH, V, Z
from .chain_energy import account_chain
from .events import breaking_loose, comes_to_rest, mode_after_rest, started, turning_speed
from .parts import Parts
from .sampling import BODY_ROWS, record

__all__ = ["CHAIN"]


@inlined
def _event(now: Situation, _start: Body, length: float, _pace: Pace, _budget: int) -> tuple[float, int, int]:
    options = now.options
    length, mode = _next_event(
        now.body, now.coefficients, now.hold.valve, options.order, length, options.tolerance, now.workspace
    )
    return length, mode, 0


@inlined
def _sample(
    now: Situation, _start: Body, length: float, moment: float, column: int, samples: NDArray[np.float64]
) -> Body:
    sampled = _state(now, moment, min(moment - now.elapsed, length))
    record(sampled, samples, column)
    segments = now.workspace.ahead.shape[1]
    for j in range(segments):
        samples[BODY_ROWS + j, column] = now.workspace.ahead[0, j] / segments
        samples[BODY_ROWS + segments + j, column] = now.workspace.ahead[1, j] / segments
    return sampled


@inlined
def _arrive(
    now: Situation, _start: Body, _longest: float, length: float, reached: float, _last: bool, _sampled: Body
) -> Body:
    following = _state(now, reached, length)
    for j in range(now.workspace.ahead.shape[1]):
        now.workspace.stretches[0, j] = now.workspace.ahead[0, j]
        now.workspace.stretches[1, j] = now.workspace.ahead[1, j]
    return following


@inlined
def _state(now: Situation, moment: float, since: float) -> Body:
    """State at a moment of the hold, the time `since` into the step."""
    pressure = pressure_after(now.opening, now.coefficients, now.hold.valve, moment - now.hold.begin)
    return _state_at(now.body, now.coefficients, pressure, now.options.order, since, now.workspace)


@inlined
def _account(now: Situation, _start: Body, ledger: Ledger, following: Body, length: float) -> Ledger:
    return account_chain(ledger, now.body, following, now.coefficients, now.options.order, length, now.workspace)


@inlined
def _carry(now: Situation, _start: Body, _following: Body, length: float) -> None:
    carry_chain(now.body, now.coefficients, now.options.order, length, now.workspace)


@inlined
def _saltate(now: Situation, _start: Body, following: Body, mode: int, time: float) -> None:
    saltate_chain(following, mode, now.coefficients, now.hold.valve, time, now.workspace)


@inlined
def _note(now: Situation, samples: NDArray[np.float64]) -> None:
    rows = BODY_ROWS + 2 * now.workspace.ahead.shape[1]
    if samples.shape[0] > rows:
        note_chain(now.workspace, samples[rows:, samples.shape[1] - 1])


CHAIN = Parts(chain_step, _event, _sample, _arrive, _account, _carry, _saltate, _note)


@compiled
def _state_at(
    body: Body, coefficients: Coefficients, pressure: float, order: int, t: float, series: ChainWorkspace
) -> Body:
    """State a time `t` into the step, with its D and D' in `series.ahead`."""
    stretches_at(order, t, series)
    foot, foot_velocity = foot_at(body, coefficients, order, t, series)
    segments = series.ahead.shape[1]
    z = 0.0
    v = 0.0
    for j in range(segments):
        z += series.ahead[0, j]
        v += series.ahead[1, j]
    return Body(z / segments, v / segments, pressure, foot, foot_velocity, body.mode, body.slips)


@compiled
def _next_event(
    body: Body,
    coefficients: Coefficients,
    valve: float,
    order: int,
    length: float,
    tolerance: float,
    series: ChainWorkspace,
) -> tuple[float, int]:
    """Where the step ends, at most at `length`, and the motion that follows.

    A resting foot feels the first segment alone, and that segment's force is the crawler's.
    """
    if coefficients.anchored:
        return length, body.mode
    rear = series.rear
    if body.mode == STUCK:
        return breaking_loose(body, coefficients, valve, order, length, 0.0, rear)
    speed = rear[SCRATCH]
    for n in range(order + 1):
        speed[n] = body.mode * series.foot_velocity[n]
    speed[0] += turning_speed(body, coefficients, tolerance)
    moment = sharp_descent(speed, started(speed, body, coefficients, order, rear), length)
    if moment > length:
        _, velocity = foot_at(body, coefficients, order, length, series)
        z, v = horner(rear[Z], order + 1, length), horner(rear[V], order + 1, length)
        pressure = pressure_after(body, coefficients, valve, length)
        if not comes_to_rest(body.mode, coefficients, z, v, pressure, velocity):
            return length, body.mode
        moment = length
    return moment, mode_after_rest(body.mode, coefficients, horner(rear[FORCE], order, moment))
