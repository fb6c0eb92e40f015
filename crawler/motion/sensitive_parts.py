"""The parts of the loop for a crawler whose sensitivities are carried along: those of a Taylor series, and theirs.

Its `samples` have a row more for each of five quantities by each of eight parameters: see `stability.sensitivity`.
"""

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import inlined
from ..model.equations import pressure_after
from ..model.state import Body, Ledger
from ..stability.sensitivity import (
    carry_sensitivities,
    expand_sensitivities,
    saltate_sensitivities,
    write_sensitivities,
)
from ..steps.options import Options, Pace, Situation
from ..steps.taylor import state_at, taylor_step
from .parts import Parts, SERIES
from .sampling import BODY_ROWS

__all__ = ["SENSITIVE"]

_event_of_series, _sample_of_series, _arrive_of_series, _account_of_series = (
    SERIES.event,
    SERIES.sample,
    SERIES.arrive,
    SERIES.energies,
)


@inlined
def _motion(now: Situation) -> Situation:
    """The situation of the motion alone."""
    given = now.options
    options = Options(
        given.tolerance, given.order, given.max_steps, given.energy, given.log, given.tangents, now.workspace.method
    )
    return Situation(now.opening, now.body, now.coefficients, now.hold, now.elapsed, options, now.workspace.series)


@inlined
def _step(now: Situation, pace: Pace) -> tuple[float, Body, Pace]:
    """One step, as short as it takes for the sensitivities' series too."""
    hold, options = now.hold, now.options
    length, end, pace = taylor_step(_motion(now), pace)
    if length >= 0.0:
        trusted = expand_sensitivities(
            now.body, now.coefficients, hold.valve, hold.length, options.order, options.tolerance, now.workspace
        )
        if trusted < length:
            length = trusted
            since = now.elapsed + length - hold.begin
            pressure = pressure_after(now.opening, now.coefficients, hold.valve, since)
            end = state_at(now.body, now.coefficients, pressure, options.order, length, now.workspace.series)
    return length, end, pace


@inlined
def _event(now: Situation, end: Body, length: float, pace: Pace, budget: int) -> tuple[float, int, int]:
    return _event_of_series(_motion(now), end, length, pace, budget)


@inlined
def _sample(now: Situation, end: Body, length: float, moment: float, column: int, samples: NDArray[np.float64]) -> Body:
    sampled = _sample_of_series(_motion(now), end, length, moment, column, samples)
    since = min(moment - now.elapsed, length)
    into = samples[BODY_ROWS:, column]
    write_sensitivities(
        now.body,
        sampled,
        now.coefficients,
        now.hold.valve,
        now.hold.length,
        now.options.order,
        since,
        now.workspace,
        into,
    )
    return sampled


@inlined
def _arrive(
    now: Situation, end: Body, longest: float, length: float, reached: float, last: bool, sampled: Body
) -> Body:
    return _arrive_of_series(_motion(now), end, longest, length, reached, last, sampled)


@inlined
def _account(now: Situation, end: Body, ledger: Ledger, following: Body, length: float) -> Ledger:
    return _account_of_series(_motion(now), end, ledger, following, length)


@inlined
def _carry(now: Situation, _end: Body, following: Body, length: float) -> None:
    hold = now.hold
    carry_sensitivities(
        now.body, following, now.coefficients, hold.valve, hold.length, now.options.order, length, now.workspace
    )


@inlined
def _saltate(now: Situation, _end: Body, following: Body, mode: int, time: float) -> None:
    hold = now.hold
    saltate_sensitivities(following, mode, now.coefficients, hold.valve, hold.length, time, now.workspace)


@inlined
def _note(_now: Situation, _samples: NDArray[np.float64]) -> None:
    return


SENSITIVE = Parts(_step, _event, _sample, _arrive, _account, _carry, _saltate, _note)
