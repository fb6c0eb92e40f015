"""How the motion moves with the groups and with the length of a hold: sensitivities, carried along the run.

The derivative y of the state by a parameter obeys the equations of motion linearised about it,

    dz' = dv,  dv' = mobility (-K dz - 2 Pi2 dv + (1 + Pi5 z) dp + F_q) + mobility_q F + constant_q,

with K = `stiffness_at` and the subscript q for what the parameter changes by itself. All of it is a power series in the
time of the step where the motion is one, and so is y, by the same recurrence. The foot follows from the momentum, whose
derivative is linear in time. The pressure's derivative is closed form: it changes with Pi4, and with the hold. That one
is taken at a fixed share of the hold, of the time in holds t / T: its rates are those of the motion over T besides.

An event moves by dt = dg / falling, its function g changed by what the parameter does to g itself and to the state, and
then y jumps as a tangent does (`saltation`; I. A. Hiskens and M. A. Pai, IEEE Transactions on Circuits and Systems I 47
(2000) 204). The edges of the valve move with the hold alone.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ..model.equations import force_gradient, mobility_of, retardation
from ..model.groups import RANGES
from ..model.state import Body, Coefficients, STUCK
from ..steps.options import TAYLOR
from ..steps.workspace import FORCE, P, ROWS, V, WIDTH, Z
from .saltation import saltation_of

__all__ = [
    "PARAMETERS",
    "QUANTITIES",
    "SensitiveWorkspace",
    "carry_sensitivities",
    "expand_sensitivities",
    "saltate_sensitivities",
    "sensitive_workspace",
    "write_sensitivities",
]

PARAMETERS = (*RANGES, "hold")
"""The parameters, in order: the groups, and the length of a hold."""
QUANTITIES = 5
"""What each sensitivity is of: z, v, p, x and w, in this order."""
_COUNT = len(PARAMETERS)
_DUFFING, _DAMPING, _LAG, _COUPLING, _FOOT, _STATIC, _KINETIC, _HOLD = range(_COUNT)
_DZ, _DV, _DP, _DX, _DW = range(QUANTITIES)
# Error of a sensitivity's series, relative to it, in tolerances: that of `batch.growth`.
_ALLOWANCE = 64.0


class SensitiveWorkspace(NamedTuple):
    """What the steps of a crawler with sensitivities work on."""

    series: NDArray[np.float64]  # (ROWS, WIDTH): of the motion, see `steps.workspace`
    now: NDArray[np.float64]  # (QUANTITIES * PARAMETERS,): at the start of the step, a quantity after the other
    changes: NDArray[np.float64]  # (2, WIDTH, PARAMETERS): series of dz and dv on the step
    forcing: NDArray[np.float64]  # (WIDTH, PARAMETERS): series of what drives dv
    stiffness: NDArray[np.float64]  # (2, WIDTH): series of K and of z^2
    pressures: NDArray[np.float64]  # (2, WIDTH): series of dp by Pi4 and by the hold
    shifts: NDArray[np.float64]  # (capacity, PARAMETERS): of the events' times
    events: NDArray[np.int64]  # (1,): that have been
    method: Any  # of the series


def sensitive_workspace(order: int, capacity: int) -> SensitiveWorkspace:
    """At the start of a run, which no parameter moves, with room for so many events."""
    return SensitiveWorkspace(
        series=np.empty((ROWS, WIDTH)),
        now=np.zeros(QUANTITIES * _COUNT),
        changes=np.empty((2, WIDTH, _COUNT)),
        forcing=np.empty((WIDTH, _COUNT)),
        stiffness=np.empty((2, WIDTH)),
        pressures=np.empty((2, WIDTH)),
        shifts=np.zeros((capacity, _COUNT)),
        events=np.zeros(1, np.int64),
        method=TAYLOR[order](),
    )


@compiled
def expand_sensitivities(
    body: Body,
    coefficients: Coefficients,
    valve: float,
    hold: float,
    order: int,
    tolerance: float,
    work: SensitiveWorkspace,
) -> float:
    """Write the series of the sensitivities about the present instant; return how far they can be trusted.

    Parameters
    ----------
    body : Body
    coefficients : Coefficients
    valve : float
    hold : float
        Length of a whole hold.
    order : int
        Degree of the force's polynomial.
    tolerance : float
    work : SensitiveWorkspace
        Its motion's series are read.

    Returns
    -------
    float
    """
    _expand_stiffness(coefficients, order, work)
    _expand_pressures(body, coefficients, valve, hold, order, work)
    _expand_forcing(body, coefficients, order, work)
    mobility = mobility_of(coefficients, body.mode)
    damping, v = mobility * coefficients.damping, work.series[V]
    dz, dv, stiffness = work.changes[0], work.changes[1], work.stiffness[0]
    for j in range(_COUNT):
        dz[0, j] = work.now[_DZ * _COUNT + j]
        dv[0, j] = work.now[_DV * _COUNT + j]
    for n in range(order + 1):
        for j in range(_COUNT):
            dv[n + 1, j] = work.forcing[n, j] - damping * dv[n, j]
        for i in range(n + 1):
            pull = mobility * stiffness[i]
            for j in range(_COUNT):
                dv[n + 1, j] -= pull * dz[n - i, j]
        dv[n + 1, _HOLD] += (n + 1.0) * v[n + 1] / hold
        for j in range(_COUNT):
            dv[n + 1, j] /= n + 1.0
            dz[n + 1, j] = dv[n, j] / (n + 1.0)
        dz[n + 1, _HOLD] += v[n] / (hold * (n + 1.0))

    allowed = _ALLOWANCE * tolerance
    longest = np.inf
    for j in range(_COUNT):
        size = allowed * (1.0 + abs(dz[0, j]) + abs(dv[0, j]))
        for n in range(order, order + 2):  # two, because every second term may be zero
            last = abs(dv[n, j])
            if last > 0.0:
                longest = min(longest, math.exp(math.log(size / last) / n))
    return longest


@compiled
def _expand_stiffness(coefficients: Coefficients, order: int, work: SensitiveWorkspace) -> None:
    z, p = work.series[Z], work.series[P]
    for n in range(order + 1):
        square = 0.0
        for i in range(n + 1):
            square += z[i] * z[n - i]
        work.stiffness[1, n] = square
        work.stiffness[0, n] = 3.0 * coefficients.duffing * square - coefficients.radial_coupling * p[n]
    work.stiffness[0, 0] += 1.0


@compiled
def _expand_pressures(
    body: Body, coefficients: Coefficients, valve: float, hold: float, order: int, work: SensitiveWorkspace
) -> None:
    """P' = (valve - p) / Pi4 by Pi4, and by the hold."""
    rate = coefficients.lag_rate
    by_lag, by_hold = work.pressures[0], work.pressures[1]
    by_lag[0], by_hold[0] = work.now[_DP * _COUNT + _LAG], work.now[_DP * _COUNT + _HOLD]
    gap = valve - body.pressure
    for n in range(order):
        by_lag[n + 1] = -rate * (by_lag[n] + rate * gap) / (n + 1.0)
        by_hold[n + 1] = -rate * (by_hold[n] - gap / hold) / (n + 1.0)
        gap *= -rate / (n + 1.0)


@compiled
def _expand_forcing(body: Body, coefficients: Coefficients, order: int, work: SensitiveWorkspace) -> None:
    series, forcing = work.series, work.forcing
    z, v, p = series[Z], series[V], series[P]
    mobility, foot = mobility_of(coefficients, body.mode), coefficients.foot_fraction
    # Of 1 / (1 - r), and of 1 / (r (1 - r)).
    by_foot = mobility * mobility
    if body.mode != STUCK:
        by_foot *= 2.0 * foot - 1.0
    for n in range(order + 1):
        cube, product, lag, hold = 0.0, 0.0, 0.0, 0.0
        for i in range(n + 1):
            cube += work.stiffness[1, i] * z[n - i]
            product += p[i] * z[n - i]
            lag += work.pressures[0, i] * z[n - i]
            hold += work.pressures[1, i] * z[n - i]
        for j in range(_COUNT):
            forcing[n, j] = 0.0
        forcing[n, _DUFFING] = -mobility * cube
        forcing[n, _DAMPING] = -2.0 * mobility * v[n]
        forcing[n, _COUPLING] = mobility * product
        forcing[n, _LAG] = mobility * (work.pressures[0, n] + coefficients.radial_coupling * lag)
        forcing[n, _HOLD] = mobility * (work.pressures[1, n] + coefficients.radial_coupling * hold)
        forcing[n, _FOOT] = by_foot * series[FORCE, n]
    if body.mode != STUCK:
        forcing[0, _KINETIC] += body.mode / foot
        forcing[0, _FOOT] -= body.mode * coefficients.kinetic_friction / (foot * foot)


@compiled
def write_sensitivities(
    body: Body,
    ahead: Body,
    coefficients: Coefficients,
    valve: float,
    hold: float,
    order: int,
    t: float,
    work: SensitiveWorkspace,
    into: NDArray[np.float64],
) -> None:
    """Write the sensitivities of the state `ahead`, a time `t` into the step that begins with `body`.

    Parameters
    ----------
    body, ahead, coefficients, valve, hold, order, t
    work : SensitiveWorkspace
        Expanded.
    into : (QUANTITIES * PARAMETERS,) array
        May be that of the workspace.
    """
    payload, rate = coefficients.payload_fraction, coefficients.lag_rate
    slides = body.mode != STUCK
    drag = retardation(coefficients, body.mode)
    way, speed = ahead.deformation - body.deformation, ahead.velocity
    decay, gap = math.exp(-rate * t), valve - body.pressure
    for j in range(_COUNT):
        z, v, x, w = (
            work.changes[0, 0, j],
            work.changes[1, 0, j],
            work.now[_DX * _COUNT + j],
            work.now[_DW * _COUNT + j],
        )
        p = work.now[_DP * _COUNT + j]
        moved_z, moved_v = work.changes[0, order + 1, j], work.changes[1, order + 1, j]
        for n in range(order, -1, -1):
            moved_z = moved_z * t + work.changes[0, n, j]
            moved_v = moved_v * t + work.changes[1, n, j]
        if j == _LAG:
            p -= rate * rate * gap * t
        if j == _HOLD:
            p += rate * gap * t / hold
        if slides:
            momentum, braking, stretched = w + payload * v, 0.0, moved_z - z
            if j == _FOOT:
                momentum -= body.velocity
                x += way
            if j == _KINETIC:
                braking = 1.0 * body.mode
            if j == _HOLD:
                braking = drag / hold
                stretched -= way / hold
                x += (ahead.foot - body.foot) / hold
            x += (momentum - 0.5 * braking * t) * t - payload * stretched
            w = momentum - braking * t - payload * moved_v
            if j == _FOOT:
                w += speed
        into[_DZ * _COUNT + j] = moved_z
        into[_DV * _COUNT + j] = moved_v
        into[_DP * _COUNT + j] = decay * p
        into[_DX * _COUNT + j] = x
        into[_DW * _COUNT + j] = w


@compiled
def saltate_sensitivities(
    body: Body, mode: int, coefficients: Coefficients, valve: float, hold: float, time: float, work: SensitiveWorkspace
) -> None:
    """Carry the sensitivities across an event, and note how it moves: parameters as for `saltation_of`."""
    event = saltation_of(body, mode, coefficients, valve, time)
    z, v, p = body.deformation, body.velocity, body.pressure
    _, _, by_p = force_gradient(coefficients, z, p)
    count = work.events[0]
    for j in range(_COUNT):
        later = (
            event.later_z * work.now[_DZ * _COUNT + j]
            + event.later_v * work.now[_DV * _COUNT + j]
            + event.later_w * work.now[_DW * _COUNT + j]
        )
        if body.mode == STUCK:
            pull = by_p * work.now[_DP * _COUNT + j]
            if j == _DUFFING:
                pull -= z * z * z
            if j == _DAMPING:
                pull -= 2.0 * v
            if j == _COUPLING:
                pull += p * z
            if j == _FOOT:
                pull += coefficients.slope
            later += mode * pull * event.moves
            if j == _STATIC:
                later += event.moves
        work.now[_DV * _COUNT + j] += event.by_later_v * later
        if event.stops:
            work.now[_DW * _COUNT + j] = 0.0
        else:
            work.now[_DW * _COUNT + j] += event.by_later_w * later
        if count < work.shifts.shape[0]:
            work.shifts[count, j] = later
            if j == _HOLD:
                work.shifts[count, j] += time / hold
    work.events[0] += 1


@compiled
def carry_sensitivities(
    body: Body,
    ahead: Body,
    coefficients: Coefficients,
    valve: float,
    hold: float,
    order: int,
    t: float,
    work: SensitiveWorkspace,
) -> None:
    """Carry the sensitivities over a step of the length `t`."""
    write_sensitivities(body, ahead, coefficients, valve, hold, order, t, work, work.now)
