"""SciPy's solvers, begun anew at every hold and every event, the events by `brentq` on their own dense output.

The solver classes are stepped here as `solve_ivp` does it, with the same result; `solve_ivp` itself took a quarter to a
half longer. Two states; the pressure is closed form and the foot follows from the momentum, so that SciPy has the least
to do.
"""

import math

import numpy as np
from scipy.integrate import DOP853, OdeSolver, Radau, RK45
from scipy.optimize import brentq

from peer_solvers.problem import (
    Contender,
    DAMPING,
    DRAG,
    force,
    GRIP,
    GROUPS,
    HOLD,
    inverse_masses,
    Journey,
    LAG_RATE,
    LIGHT,
    PAYLOAD,
    travel,
    Word,
)

__all__ = ["contenders"]

TOLERANCES = {
    RK45: [10.0**-n for n in range(3, 11)],
    DOP853: [10.0**-n for n in range(4, 14)],
    Radau: [1e-4, 1e-6],
}

CLOSE = 1e-15  # in time, of an event


def contenders() -> list[Contender]:
    """RK45, DOP853 and Radau with rtol = atol."""
    return [
        Contender("SciPy", method.__name__, f"{tolerance:.0e}", tolerance, _solver(method, tolerance))
        for method, tolerances in TOLERANCES.items()
        for tolerance in tolerances
    ]


def _solver(method: type[OdeSolver], tolerance: float):
    def run(word: Word) -> Journey:
        z = v = p = foot = speed = 0.0
        sliding, slips = False, 0
        for command in word.tolist():
            # Both times run from the start of the hold.
            gap, began = p - command, 0.0
            while began < HOLD:
                rates, margin, jacobian = _motion(sliding, command, gap, began, speed + PAYLOAD * v)
                extra = {"jac": jacobian} if method is Radau else {}
                solver = method(rates, began, np.array([z, v]), HOLD, rtol=tolerance, atol=tolerance, **extra)
                ended, (stretched, rate), happened = _until_event(solver, margin)
                took = ended - began
                if sliding:
                    foot += travel(speed, stretched - z, v, took)
                    speed += PAYLOAD * (v - rate) - DRAG * took
                z, v, began = stretched, rate, ended
                if happened:
                    sliding, speed = not sliding, 0.0
                    slips += sliding
            p = command + gap * math.exp(-HOLD * LAG_RATE)
        return Journey(foot, slips)

    return run


def _until_event(solver: OdeSolver, margin) -> tuple[float, list[float], bool]:
    """Time, state, and whether an event happened, where `margin` first falls below zero or the solver ends."""
    before = margin(solver.t, solver.y)
    while solver.status == "running":
        solver.step()
        after = margin(solver.t, solver.y)
        if after < 0.0 < before:
            return *_event(solver, margin), True
        before = after
    if solver.status == "failed":
        raise RuntimeError(f"{type(solver).__name__} failed at time {solver.t:g} of a hold")
    return solver.t, solver.y.tolist(), False


def _event(solver: OdeSolver, margin) -> tuple[float, list[float]]:
    """Time and state of the event in the step just done."""
    inside = solver.dense_output()
    moment = brentq(lambda t: margin(t, inside(t)), solver.t_old, solver.t, xtol=CLOSE, rtol=CLOSE)
    return moment, inside(moment).tolist()


def _motion(sliding: bool, command: float, gap: float, began: float, momentum: float):
    """Rates, event function and Jacobian of one motion; plain floats, since SciPy's arrays of two cost more."""
    mobility, drag = inverse_masses[sliding], DRAG / LIGHT if sliding else 0.0

    def rates(t, y):
        z, v = y.tolist()
        return v, force(z, v, command + gap * math.exp(-t * LAG_RATE)) * mobility + drag

    def margin(t, y):
        z, v = y.tolist()
        if sliding:
            return momentum - PAYLOAD * v - DRAG * (t - began)
        return GRIP + force(z, v, command + gap * math.exp(-t * LAG_RATE))

    def jacobian(t, y):
        z = y.item(0)
        pressure = command + gap * math.exp(-t * LAG_RATE)
        secant = GROUPS.radial_coupling * pressure - 1.0 - 3.0 * GROUPS.duffing * z * z
        return ((0.0, 1.0), (secant * mobility, -DAMPING * mobility))

    return rates, margin, jacobian
