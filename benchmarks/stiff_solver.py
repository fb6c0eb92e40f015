"""Cost and error of Radau beside Taylor, ordinary and stiff: whence `stickslip.crawler.steps.radau.stages_for` comes.

Run ``python benchmarks/stiff_solver.py``. Times are of the processor, the least of some rounds, in microseconds per
unit of time; the error is that of the foot against Radau at tolerance 1e-14.
"""

import time

import numpy as np

from stickslip.crawler import Groups, Scene
from stickslip.crawler.drive import drive
from stickslip.crawler.model.state import Body, coefficients_of
from stickslip.crawler.solvers import Solver, SOLVERS
from stickslip.crawler.steps.options import FINISHED, Options, Outcome
from stickslip.crawler.steps.radau_table import STAGES
from stickslip.crawler.steps.workspace import ROWS, WIDTH

WORD = np.array([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0] * 5)
CRAWLERS = {
    "default": Groups(),
    "Pi2 = 100": Groups(damping_ratio=100.0),
    "Pi2 = 100, Pi4 = 0.001": Groups(damping_ratio=100.0, deborah=1e-3),
    "Pi2 = 1e4": Groups(damping_ratio=1e4),
    "r = 1e-6": Groups(foot_mass_fraction=1e-6),
    "r = 1 - 1e-6": Groups(foot_mass_fraction=1.0 - 1e-6),
    "Pi4 = 1e-6": Groups(deborah=1e-6),
    "Pi1 = 1e6": Groups(duffing=1e6),
    "Pi1 = 1e6, Pi4 = r = 1e-6": Groups(duffing=1e6, deborah=1e-6, foot_mass_fraction=1e-6),
    "... and Pi2 = 1e4": Groups(duffing=1e6, damping_ratio=1e4, deborah=1e-6, foot_mass_fraction=1e-6),
}
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12, 1e-14)
ROUNDS = 5
_DEAR = 2.0  # seconds that one run may take to be run again


def run(groups: Groups, solver: Solver, options: Options) -> tuple[Outcome, float]:
    """Outcome, and processor time per unit of time in microseconds."""
    rest = Body(0.0, 0.0, 0.0, 0.0, 0.0, 0, 0)
    samples, events, series = np.empty((5, len(WORD))), np.empty((0, 2)), np.empty((ROWS, WIDTH))
    least = np.inf
    for _ in range(ROUNDS):
        start = time.process_time()
        outcome, _ = drive(rest, coefficients_of(groups, Scene()), WORD, 1.0, options, samples, events, series)
        least = min(least, time.process_time() - start)
        if least > _DEAR:
            break
    return outcome, 1e6 * least / len(WORD)


def main() -> None:
    """Print the tables."""
    radau = SOLVERS["radau"]
    costs: dict[tuple[float, int], list[float]] = {}
    for name, groups in CRAWLERS.items():
        exact, _ = run(groups, radau, radau.options(1e-14))
        print(f"{name}: {exact.body.slips} slips")
        for tolerance in TOLERANCES:
            for stages in STAGES:
                _, cost = run(groups, radau, radau.options(tolerance)._replace(order=stages))
                costs.setdefault((tolerance, stages), []).append(cost)
            if tolerance not in (1e-3, 1e-6, 1e-9, 1e-12):
                continue
            cells = []
            for solver in (radau, SOLVERS["taylor"]):
                outcome, cost = run(groups, solver, solver.options(tolerance))
                error = abs(outcome.body.foot - exact.body.foot)
                done = f"{error:.0e}, {outcome.body.slips} slips" if outcome.status == FINISHED else "not done"
                cells.append(f"{solver.name} {cost:9.2f} ({done})")
            print(f"  {tolerance:g}  " + "  ".join(cells), flush=True)
    print("geometric mean cost by stages")
    for tolerance in TOLERANCES:
        means = [np.exp(np.mean(np.log(costs[tolerance, stages]))) for stages in STAGES]
        print(f"  {tolerance:g}  " + "  ".join(f"{s}: {mean:.2f}" for s, mean in zip(STAGES, means, strict=True)))


if __name__ == "__main__":
    main()
