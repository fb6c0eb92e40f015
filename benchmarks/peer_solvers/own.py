"""stickslip itself: the user's call, and the compiled kernel alone. No other file here calls its solver."""

import numpy as np

from peer_solvers.problem import Contender, GROUPS, HOLD, Journey, Word
from stickslip.crawler import REST, Scene, simulate
from stickslip.crawler.drive import drive
from stickslip.crawler.model.state import Body, coefficients_of, STUCK
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import FINISHED
from stickslip.crawler.steps.workspace import ROWS, WIDTH

__all__ = ["KERNEL", "LIBRARY", "SIMULATE", "contenders", "foot_under_plain_friction"]

LIBRARY, KERNEL, SIMULATE = "stickslip", "kernel", "simulate"
TOLERANCES = [10.0**-n for n in range(3, 16)]


def contenders() -> list[Contender]:
    """The call that users make, which keeps the energy ledger and logs events, and the kernel, which does neither."""
    return [
        Contender(LIBRARY, method, f"{tolerance:.0e}", tolerance, make(tolerance))
        for method, make in ((SIMULATE, _simulate), (KERNEL, _kernel))
        for tolerance in TOLERANCES
    ]


def foot_under_plain_friction(friction: float, word: Word) -> float:
    """Way of a foot that has one friction coefficient at rest and sliding, and may slide backward."""
    groups = {**GROUPS.to_dict(), "static_friction": friction, "kinetic_friction": friction}
    done = simulate(type(GROUPS)(**groups), word, HOLD, scene=Scene(ratchet=False), tolerance=1e-12)
    return float(done.foot[-1])


def _simulate(tolerance: float):
    def run(word: Word) -> Journey:
        done = simulate(GROUPS, word, HOLD, tolerance=tolerance)
        return Journey(float(done.foot[-1]), done.slips)

    return run


def _kernel(tolerance: float):
    coefficients, options = coefficients_of(GROUPS, Scene()), SOLVERS["taylor"].options(tolerance)
    body = Body(*REST, STUCK, 0)
    events, series = np.empty((0, 2)), np.empty((ROWS, WIDTH))
    samples = {}

    def run(word: Word) -> Journey:
        into = samples.setdefault(len(word), np.empty((5, len(word))))
        outcome, _ = drive(body, coefficients, word.astype(np.float64), HOLD, options, into, events, series)
        assert outcome.status == FINISHED
        return Journey(outcome.body.foot, outcome.body.slips)

    return run
