"""heyoka: Taylor series of an integrator compiled for this very system, with terminal events.

Of the forms tried the fastest is here: one integrator through sticks and slips, whose masses, event and valve are
runtime parameters; a callback changes them at an event and the propagation goes on, which saves a third of the calls
from Python. Two integrators, a stick's and a slip's, took a quarter longer. `fast_math` gains a tenth at no loss of
accuracy; compact mode, SLP vectorisation and wider registers gain nothing.

From rest every state is zero. That is no trouble as long as no power of z is taken (see `problem.force`): then heyoka
returns NaN.
"""

import numpy as np
from numpy.typing import NDArray

from peer_solvers.problem import (
    Contender,
    DRAG,
    force,
    GRIP,
    HOLD,
    inverse_masses,
    Journey,
    LAG_RATE,
    LIGHT,
    Word,
)
from stickslip.common.extras import optional_import

with optional_import():
    import heyoka as hy

__all__ = ["batch_solver", "contenders"]

TOLERANCES = [1e-3, 1e-6, 1e-9, 1e-12]

VALVE = 0
# Parameters from 1: v' per force, drag in v', foot acceleration per force, weights of the two event functions.
STICK = (inverse_masses[0], 0.0, 0.0, 1.0, 0.0)
SLIP = (inverse_masses[1], DRAG / LIGHT, -1.0 / LIGHT, 0.0, 1.0)
SLIDING = 5
FOOT, SPEED = 3, 4


def contenders() -> list[Contender]:
    """Full precision, heyoka's default, and looser ones."""
    full = Contender("heyoka", "Taylor", "full precision", 0.0, _solver())
    return [*(Contender("heyoka", "Taylor", f"{tol:.0e}", tol, _solver(tol=tol)) for tol in TOLERANCES), full]


def _system():
    """Equations of motion, and the event function."""
    z, v, p, x, w = hy.make_vars("z", "v", "p", "x", "w")
    valve, mobility, drag, recoil, sticks, slides = (hy.par[n] for n in range(6))
    pull = force(z, v, p)
    equations = [
        (z, v),
        (v, mobility * pull + drag),
        (p, LAG_RATE * (valve - p)),
        (x, w),
        (w, recoil * (pull + DRAG)),
    ]
    return equations, slides * w + sticks * (pull + GRIP)


def _solver(**options: float):
    equations, event_function = _system()
    slips = 0

    def change_motion(_integrator, _direction) -> bool:
        nonlocal slips
        if parameters[SLIDING]:
            parameters[1:] = STICK
            state[SPEED] = 0.0
        else:
            parameters[1:] = SLIP
            slips += 1
        return True

    event = hy.t_event(event_function, callback=change_motion, direction=hy.event_direction.negative)
    integrator = hy.taylor_adaptive(equations, [0.0] * 5, pars=[0.0] * 6, t_events=[event], fast_math=True, **options)
    state, parameters = integrator.state, integrator.pars  # views

    def run(word: Word) -> Journey:
        nonlocal slips
        slips, integrator.time = 0, 0.0
        integrator.reset_cooldowns()
        state[:], parameters[1:] = 0.0, STICK
        for hold, command in enumerate(word.tolist(), 1):
            parameters[VALVE] = command
            outcome = integrator.propagate_until(hold * HOLD)[0]
            assert outcome == hy.taylor_outcome.time_limit, outcome
        return Journey(float(state[FOOT]), slips)

    return run


def batch_solver(tolerance: float):
    """`run(words)`, the feet after schedules (crawlers, holds), by integrators of as many crawlers as heyoka advises.

    Those of a batch keep to one time from hold to hold: one that is there takes steps of length 0 until all are.
    """
    size = hy.recommended_simd_size()
    equations, event_function = _system()
    stick, slip = np.array(STICK), np.array(SLIP)

    def change_motion(_integrator, _direction, i: int) -> bool:
        if parameters[SLIDING, i]:
            parameters[1:, i] = stick
            state[SPEED, i] = 0.0
        else:
            parameters[1:, i] = slip
        return True

    event = hy.t_event_batch(event_function, callback=change_motion, direction=hy.event_direction.negative)
    integrator = hy.taylor_adaptive_batch(
        equations,
        np.zeros((5, size)),
        pars=np.zeros((6, size)),
        t_events=[event],
        fast_math=True,
        tol=tolerance,
    )
    state, parameters = integrator.state, integrator.pars  # views

    def run(words: NDArray[np.int8]) -> NDArray[np.float64]:
        feet = np.empty(len(words))
        for first in range(0, len(words), size):
            some = words[first : first + size]
            integrator.set_time(0.0)
            integrator.reset_cooldowns()
            state[:], parameters[1:] = 0.0, stick[:, None]
            for hold, commands in enumerate(some.T, 1):
                parameters[VALVE, : len(some)] = commands
                integrator.propagate_until(hold * HOLD)
                assert all(told[0] == hy.taylor_outcome.time_limit for told in integrator.propagate_res)
            feet[first : first + size] = state[FOOT, : len(some)]
        return feet

    return run
