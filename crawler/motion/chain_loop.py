"""One chain through its schedule: the crawler's own loop, with a state for each segment.

Steps, events and samples follow the same rules as in `advance`: a step ends at whichever comes first of its error
bound, the foot's next event and the end of the hold.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ...compiling.roots import horner, sharp_descent
from ..model.equations import force, force_terms, pressure_after
from ..model.state import Body, Coefficients, Ledger, STUCK
from ..steps.chain_series import (
    Chain,
    ChainSeries,
    expand_chain,
    foot_at,
    longest_step,
    pulls_at,
    segment_mobility,
    stretches_at,
)
from ..steps.options import (
    AFRESH,
    DIVERGED,
    FINISHED,
    Leg,
    LOG_FULL,
    Options,
    OUT_OF_STEPS,
    Outcome,
    PAUSED,
    SAMPLES_A_STEP,
)
from ..steps.taylor import ROUNDING, SHORTENINGS, TRUST
from ..steps.workspace import FORCE, SCRATCH, V, Z
from .chain_energy import account_chain
from .events import breaking_loose, comes_to_rest, jump, mode_after_rest, started, turning_speed
from .loop import end_of_step, is_near, moment_of, record, sampled_by
from .progress import keep, opening_of, outcome_of, run_through, steps_of_a_call, stretch_at, stretch_of

__all__ = ["drive_chain"]


def drive_chain(
    body: Body,
    stretches: NDArray[np.float64],
    chain: Chain,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    segment_samples: NDArray[np.float64],
    events: NDArray[np.float64],
    series: ChainSeries,
) -> tuple[Outcome, int]:
    """Advance one chain through its schedule.

    Parameters
    ----------
    body : Body
        Its deformation and velocity are the means of `stretches`.
    stretches : (2, N) array
        D and D' of the segments, foot first; moved in place.
    chain : Chain
    schedule : (holds,) array
        Share of each hold that the valve is open, at its start.
    hold : float
    options : Options
    samples : (5, holds * samples_per_hold) array
        Receives z, v, p, x, w.
    segment_samples : (2, N, holds * samples_per_hold) array
        Receives d and d' of the segments.
    events : (capacity, 2) array
        Receives times and new motions.
    series : ChainSeries
        Scratch.

    Returns
    -------
    outcome : Outcome
        Of the last hold begun, with the number of events of all.
    finished : int
        Holds completed.
    """
    return run_through(
        _drive_chain_on,
        body,
        stretches,
        chain,
        schedule,
        hold,
        options,
        samples,
        segment_samples,
        events,
        series,
    )


@compiled
def _drive_chain_on(
    state: NDArray[np.float64],
    stretches: NDArray[np.float64],
    chain: Chain,
    schedule: NDArray[np.float64],
    hold: float,
    options: Options,
    samples: NDArray[np.float64],
    segment_samples: NDArray[np.float64],
    events: NDArray[np.float64],
    series: ChainSeries,
) -> None:
    """Go on with the run that `state` tells of, see `run_through`."""
    so_far = outcome_of(state)
    opening, body, ledger = opening_of(state), so_far.body, so_far.ledger
    elapsed, steps, logged = so_far.elapsed, so_far.steps, so_far.logged
    each = samples.shape[1] // len(schedule)
    until_pause = max(1, steps_of_a_call(state) // stretches.shape[1])
    for stretch in range(stretch_of(state), 2 * len(schedule)):
        k = stretch // 2
        valve, begin, end = stretch_at(stretch, schedule, hold)
        if not begin < end:
            continue
        if until_pause <= 0:
            keep(state, Outcome(PAUSED, elapsed, steps, logged, body, ledger, AFRESH), stretch, opening)
            return
        outcome = _advance_chain(
            body,
            stretches,
            ledger,
            chain,
            valve,
            hold,
            begin,
            end,
            options,
            options.max_steps - steps,
            k * hold,
            samples[:, k * each : (k + 1) * each],
            segment_samples[:, :, k * each : (k + 1) * each],
            events[logged:],
            series,
            Leg(opening, max(begin, elapsed), AFRESH, until_pause),
        )
        body = outcome.body
        ledger = outcome.ledger
        logged += outcome.logged
        steps += outcome.steps
        until_pause -= outcome.steps + each // SAMPLES_A_STEP
        if outcome.status != FINISHED:
            keep(
                state,
                Outcome(outcome.status, outcome.elapsed, steps, logged, body, ledger, AFRESH),
                stretch,
                opening,
            )
            return
        opening = body
        elapsed = 0.0
    keep(state, Outcome(FINISHED, hold, steps, logged, body, ledger, AFRESH), 2 * len(schedule), body)


@compiled
def _advance_chain(
    body: Body,
    stretches: NDArray[np.float64],
    ledger: Ledger,
    chain: Chain,
    valve: float,
    hold: float,
    begin: float,
    close: float,
    options: Options,
    budget: int,
    start: float,
    samples: NDArray[np.float64],
    segment_samples: NDArray[np.float64],
    events: NDArray[np.float64],
    series: ChainSeries,
    leg: Leg,
) -> Outcome:
    """Advance one chain from `begin` to `close` in one hold of the valve, in `budget` steps at most.

    Both are times into the hold, which begins at the time `start`; `leg` says where between them to go on.
    """
    segments = stretches.shape[1]
    count = samples.shape[1]
    opening, elapsed = leg.opening, leg.elapsed
    done = sampled_by(elapsed, hold, count)
    logged = 0
    allowed = min(budget, leg.steps)
    for steps in range(1, allowed + 1):
        expand_chain(stretches, body, chain, valve, options.order, series)
        length = longest_step(chain, body.mode, options.order, options.tolerance, series)
        if not length > 0.0:
            return Outcome(DIVERGED, elapsed, steps, logged, body, ledger, AFRESH)
        length = _trusted_length(body, chain, valve, options, min(length, close - elapsed), series)
        length, mode = _next_event(body, chain, valve, options.order, length, options.tolerance, series)

        reached, last = end_of_step(body, close, elapsed, length, mode)
        while done < count:
            moment = moment_of(done, count, hold)
            if moment > reached:
                break
            pressure = pressure_after(opening, chain.coefficients, valve, moment - begin)
            sampled = _state_at(
                body, chain.coefficients, pressure, options.order, min(moment - elapsed, length), series
            )
            record(sampled, samples, done)
            for j in range(segments):
                segment_samples[0, j, done] = series.ahead[0, j] / segments
                segment_samples[1, j, done] = series.ahead[1, j] / segments
            done += 1

        pressure = pressure_after(opening, chain.coefficients, valve, reached - begin)
        following = _state_at(body, chain.coefficients, pressure, options.order, length, series)
        if not is_near(following):
            return Outcome(DIVERGED, elapsed, steps, logged, body, ledger, AFRESH)
        for j in range(segments):
            stretches[0, j] = series.ahead[0, j]
            stretches[1, j] = series.ahead[1, j]
        if options.energy:
            ledger = account_chain(ledger, body, following, chain.coefficients, options.order, length, series)
        elapsed = reached
        if mode != body.mode:
            if options.log:
                if logged == events.shape[0]:
                    return Outcome(LOG_FULL, elapsed, steps, logged, body, ledger, AFRESH)
                events[logged, 0] = start + elapsed
                events[logged, 1] = mode
                logged += 1
            following = jump(following, mode, chain.coefficients)
        body = following
        if last:
            return Outcome(FINISHED, close, steps, logged, body, ledger, AFRESH)
    status = PAUSED if allowed < budget else OUT_OF_STEPS
    return Outcome(status, elapsed, allowed, logged, body, ledger, AFRESH)


@compiled
def _state_at(
    body: Body, coefficients: Coefficients, pressure: float, order: int, t: float, series: ChainSeries
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
def _trusted_length(
    body: Body, chain: Chain, valve: float, options: Options, length: float, series: ChainSeries
) -> float:
    """The part of a step at whose end every segment's series still satisfies the equation of motion.

    As in `taylor_step`: the defect is the force at the state less the force's own series.
    """
    coefficients = chain.coefficients
    order = options.order
    for _ in range(SHORTENINGS):
        stretches_at(order, length, series)
        pulls_at(order, length, series)
        pressure = pressure_after(body, coefficients, valve, length)
        worst = 0.0
        for j in range(series.ahead.shape[1]):
            z = series.ahead[0, j]
            v = series.ahead[1, j]
            defect = abs(force(coefficients, z, v, pressure) - series.pulls[j])
            rounding = ROUNDING * force_terms(coefficients, z, v)
            mobility = segment_mobility(chain, body.mode, j)
            if mobility * (defect - rounding) > TRUST * options.tolerance:
                worst = max(worst, mobility * defect)
        if worst == 0.0:
            break
        shrink = math.exp(math.log(options.tolerance / worst) / (order + 1))
        length *= max(0.25, min(0.9, shrink))
    return length


@compiled
def _next_event(
    body: Body, chain: Chain, valve: float, order: int, length: float, tolerance: float, series: ChainSeries
) -> tuple[float, int]:
    """Where the step ends, at most at `length`, and the motion that follows.

    A resting foot feels the first segment alone, and that segment's force is the crawler's.
    """
    coefficients = chain.coefficients
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
