"""Cost of a hold in lanes of vector arithmetic, against batch size and threads, beside the crawlers one by one.

Run ``python benchmarks/lanes.py``. Works take turns, round after round in one process, so that the machine's drift
falls on all alike. The floor is what the counted arithmetic of the vector steps and samples takes at the peak that one
core reaches on independent multiply-adds of the same width: with no event, and no lane idle.
"""

import re
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from measuring import machine, quartiles, take_turns
from numba import njit
from numpy.typing import NDArray

from stickslip.compiling.compilation import compiled
from stickslip.compiling.tracing import unrolled_in_lanes
from stickslip.compiling.vectors import LANES
from stickslip.crawler import Groups, Scene
from stickslip.crawler.batch.advance import advance_lanes, lane_workspace, one_by_one
from stickslip.crawler.batch.step import sample_lanes, step_lanes
from stickslip.crawler.drive import drive
from stickslip.crawler.model.columns import Crawlers, Share
from stickslip.crawler.model.state import Body, coefficients_of, STUCK
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import Taylor12

HOLD, TOLERANCE, SAMPLES = 0.5, 1e-6, 4
SIZES = (1, 8, 64, 512, 4096, 65_536)
ROUNDS, SCHEDULES = 15, 8
_CHAINS, _LINKS = 10, 200
CONTROL = SOLVERS["taylor"].options(TOLERANCE)


@compiled
def in_lanes(crawlers, some, hold, options, workspace):
    advance_lanes(crawlers, some, hold, options, workspace)


class Batch:
    """The default crawlers, with random valves."""

    def __init__(self, n: int, parts: int = 1) -> None:
        rng = np.random.default_rng(n)
        self.n, self.parts = n, parts
        self.bodies = np.zeros((7, n))
        self.coefficients = np.repeat(
            np.array(coefficients_of(Groups(), Scene()), dtype=np.float64)[:, None], n, axis=1
        )
        self.valves = rng.integers(0, 2, (SCHEDULES, n))
        self.samples = np.empty((3, SAMPLES, n))
        self.results = np.zeros(n, np.int8), np.zeros(n)
        self.skip = np.zeros(n, bool)
        self.lanes = [lane_workspace() for _ in range(parts)]
        self.series = SOLVERS["taylor"].workspace(coefficients_of(Groups(), Scene()), HOLD, SAMPLES)
        self.pool = ThreadPoolExecutor(parts)
        self.turn = 0

    def _advance(self, kernel: Callable[..., None], begin: int, end: int, workspace: NDArray[np.float64]) -> None:
        valves = self.valves[self.turn % SCHEDULES]
        crawlers = Crawlers(self.bodies, self.coefficients, valves, self.samples, *self.results)
        kernel(crawlers, Share(begin, end, self.skip), HOLD, CONTROL, workspace)

    def one_by_one(self) -> None:
        """One hold of all, by the single crawler's functions."""
        self.turn += 1
        self._advance(one_by_one, 0, self.n, self.series[None])

    def in_lanes(self) -> None:
        """One hold of all, shared out among the threads."""
        self.turn += 1
        bounds = np.linspace(0, self.n, self.parts + 1).astype(int).tolist()
        if self.parts == 1:
            self._advance(in_lanes, *bounds, self.lanes[0])
        else:
            jobs = zip(bounds, bounds[1:], self.lanes, strict=False)
            list(self.pool.map(lambda job: self._advance(in_lanes, *job), jobs))


def _chains(_order, rows, factor):
    chains = [rows[0][k] for k in range(_CHAINS)]
    for _ in range(_LINKS):
        chains = [chain.fma(factor, factor) for chain in chains]
    return {0: chains}, [chains[0] > 0.0]


_multiply_add = unrolled_in_lanes(_chains, LANES, 1)


@njit
def _peak_work(rows, repeats):
    for _ in range(repeats):
        _multiply_add(1, (0.5,), rows)


@njit
def _one_step(rows):
    return step_lanes(Taylor12(), (TOLERANCE, float(SAMPLES)), rows)


@njit
def _one_sample(rows):
    return sample_lanes(Taylor12(), (float(SAMPLES),), rows)


def flops(kernel) -> int:
    """Floating-point operations that a lane takes in a kernel, counted in its code: a multiply-add is two."""
    kernel(lane_workspace())
    code = next(iter(kernel.inspect_llvm().values()))
    vector = rf"<{LANES} x double>"
    single = len(re.findall(rf"= f(?:add|sub|mul|div) {vector}", code))
    return single + 2 * len(re.findall(rf"call {vector} @llvm\.fma", code))


def peak() -> float:
    """Operations a microsecond of independent multiply-adds in all lanes; the best of many goes."""
    rows, repeats = np.zeros((1, _CHAINS, LANES)), 500
    _peak_work(rows, 1)
    best = np.inf
    for _ in range(200):
        start = time.perf_counter()
        _peak_work(rows, repeats)
        best = min(best, time.perf_counter() - start)
    return 2.0 * _CHAINS * _LINKS * LANES * repeats / best * 1e-6


def steps_a_hold(holds: int = 4000) -> float:
    """Steps of the default crawler in a hold, with random valves."""
    valves = np.random.default_rng(0).integers(0, 2, holds).astype(float)
    coefficients = coefficients_of(Groups(), Scene())
    rest = Body(0.0, 0.0, 0.0, 0.0, 0.0, STUCK, 0)
    series = SOLVERS["taylor"].workspace(coefficients, HOLD, 1)
    outcome, _ = drive(rest, coefficients, valves, HOLD, CONTROL, np.empty((5, holds)), np.empty((0, 2)), series)
    return outcome.steps / holds


def floor() -> dict[str, float]:
    """What a hold would take one core at its peak, from the counted arithmetic of its vector steps and samples."""
    steps, most = steps_a_hold(), peak()
    step, sample = flops(_one_step), flops(_one_sample)
    return {
        "steps a hold": steps,
        "operations a step": step,
        "operations a sample": sample,
        "peak, operations a us": most,
        "us a hold": (steps * step + SAMPLES * sample) / most,
    }


def main() -> None:
    """Print the table and the floor."""
    works = {}
    for n in SIZES:
        for name, batch in ("one by one", Batch(n)), ("lanes", Batch(n)), ("lanes, two threads", Batch(n, 2)):
            works[name, n] = batch.one_by_one if name == "one by one" else batch.in_lanes
            for _ in range(SCHEDULES):
                works[name, n]()
    seconds = take_turns({f"{name}|{n}": work for (name, n), work in works.items()}, ROUNDS)
    print(machine()["processor"], f"{LANES} lanes, hold {HOLD}, tolerance {TOLERANCE:g}, {SAMPLES} samples a hold")
    print("microseconds a hold: lower quartile, median, upper quartile\n")
    for key, times in seconds.items():
        name, n = key.split("|")
        low, middle, high = (each / int(n) * 1e6 for each in quartiles(list(times.values())))
        print(f"{name:20}{n:>8}{low:10.3f}{middle:10.3f}{high:10.3f}")
    least = floor()
    print(f"\n{least['steps a hold']:.2f} steps a hold of {least['operations a step']} operations, ", end="")
    print(f"{SAMPLES} samples of {least['operations a sample']}")
    print(f"peak {least['peak, operations a us'] / 1e3:.1f} operations a nanosecond: ", end="")
    print(f"the floor is {least['us a hold']:.3f} microseconds a hold")


if __name__ == "__main__":
    main()
