"""heyoka: Taylor series of an integrator compiled for this very system, with terminal events.

Of the forms tried the fastest is here: one integrator through sticks and slips, whose masses, event and valve are
runtime parameters; a callback changes them at an event and the propagation goes on, which saves a third of the calls
from Python. Two integrators, a stick's and a slip's, took a quarter longer. `fast_math` gains a tenth at no loss of
accuracy; compact mode, SLP vectorisation and wider registers gain nothing.

From rest every state is zero. That is no trouble as long as no power of z is taken (see `problem.force`): then heyoka
returns NaN.
"""

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

__all__ = ["contenders"]

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


def _solver(**options: float):
    z, v, p, x, w = hy.make_vars("z", "v", "p", "x", "w")
    valve, mobility, drag, recoil, sticks, slides = (hy.par[n] for n in range(6))
    pull = force(z, v, p)
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

    integrator = hy.taylor_adaptive(
        [
            (z, v),
            (v, mobility * pull + drag),
            (p, LAG_RATE * (valve - p)),
            (x, w),
            (w, recoil * (pull + DRAG)),
        ],
        [0.0] * 5,
        pars=[0.0] * 6,
        t_events=[
            hy.t_event(
                slides * w + sticks * (pull + GRIP),
                callback=change_motion,
                direction=hy.event_direction.negative,
            )
        ],
        fast_math=True,
        **options,
    )
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
