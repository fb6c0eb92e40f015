"""diffrax in float64: the whole trajectory is one compiled function, begun anew at every hold and every event.

Events are diffrax's own, located by optimistix's Newton on the step's interpolant. Forward mode, one array of two
states and no compiler flags but those for one thread were the fastest of what was tried.
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
    PAYLOAD,
    travel,
    Word,
)
from stickslip.common.extras import optional_import

with optional_import():
    import diffrax
    import jax
    import jax.numpy as jnp
    import optimistix

__all__ = ["contenders"]

TOLERANCES = {
    diffrax.Tsit5: [10.0**-n for n in range(3, 12)],
    diffrax.Dopri8: [1e-6, 1e-9, 1e-12],
    diffrax.Kvaerno5: [1e-3, 1e-6],
}
EVENT = optimistix.Newton(rtol=1e-13, atol=1e-13)

jax.config.update("jax_enable_x64", True)


def contenders() -> list[Contender]:
    """Tsit5, Dopri8 and the stiff Kvaerno5 with rtol = atol."""
    chosen = []
    for solver, tolerances in TOLERANCES.items():
        journey = _compiled(solver())
        chosen += [
            Contender("diffrax", solver.__name__, f"{tolerance:.0e}", tolerance, _runner(journey, tolerance))
            for tolerance in tolerances
        ]
    return chosen


def _runner(journey, tolerance: float):
    def run(word: Word) -> Journey:
        foot, slips = journey(word, tolerance)
        return Journey(float(foot), int(slips))

    return run


def _compiled(solver):
    def pressure(t, motion):
        command, gap, began, _, _ = motion
        return command + gap * jnp.exp(-LAG_RATE * (t - began))

    def rates(t, y, motion):
        sliding = motion[3]
        pull = force(*y, pressure(t, motion))
        sticks, slides = inverse_masses
        return jnp.stack([y[1], jnp.where(sliding, pull * slides + DRAG / LIGHT, pull * sticks)])

    def margin(t, y, args, **_):
        _, _, began, sliding, momentum = args
        speed = momentum - PAYLOAD * y[1] - DRAG * (t - began)
        return jnp.where(sliding, speed, GRIP + force(*y, pressure(t, args)))

    term = diffrax.ODETerm(rates)
    event = diffrax.Event(margin, EVENT, direction=False)

    @jax.jit
    def journey(word, tolerance):
        options = diffrax.PIDController(rtol=tolerance, atol=tolerance)

        def unfinished(carry):
            return carry[0] < len(word)

        def segment(carry):
            hold, t, y, p, foot, speed, sliding, slips = carry
            command = word[hold].astype(float)
            motion = (command, p - command, t, sliding, speed + PAYLOAD * y[1])
            done = diffrax.diffeqsolve(
                term,
                solver,
                t,
                (hold + 1) * HOLD,
                None,
                y,
                motion,
                stepsize_controller=options,
                event=event,
                adjoint=diffrax.ForwardMode(),
                max_steps=None,
                throw=False,
            )
            happened, ended, after = done.event_mask, done.ts[-1], done.ys[-1]
            took = ended - t
            way = travel(speed, after[0] - y[0], y[1], took)
            slower = speed + PAYLOAD * (y[1] - after[1]) - DRAG * took
            return (
                hold + ~happened,
                ended,
                after,
                pressure(ended, motion),
                foot + jnp.where(sliding, way, 0.0),
                jnp.where(sliding & ~happened, slower, 0.0),
                sliding ^ happened,
                slips + (happened & ~sliding),
            )

        start = (0, 0.0, jnp.zeros(2), 0.0, 0.0, 0.0, False, 0)
        end = jax.lax.while_loop(unfinished, segment, jax.tree.map(jnp.asarray, start))
        return end[4], end[7]

    return journey
