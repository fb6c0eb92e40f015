"""Memory capacity to 50 delays on 10,000 samples of 50 states, beside the ways it is usually had.

Run ``python benchmarks/memory_speed.py``. The works take turns in one process with one thread for BLAS; a ratio is that
of neighbours in time, given as median and quartiles over the rounds. Kept in ``results/memory_speed.json``.

The works, all on the same second half after the same first half:

- ``memory_capacity`` as shipped: checks, solve, scores of the held-out half, cutoff and rank.
- one Cholesky solve for all delays, scikit-learn's: the fit alone, without prediction, scores or rank.
- the same with prediction and scores.
- one ridge fit a delay, scikit-learn's, the fits alone: what RCbench does.

The states are normal noise, the states of an echo-state network, and states that are collinear to 1e-5 and to 1e-12.
There the Gram matrix has lost its digits: Cholesky's times are those of a wrong answer.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from measuring import keep, machine, quartiles, take_turns
from numpy.typing import NDArray
from sklearn.linear_model import Ridge

from stickslip.common.extras import optional_import
from stickslip.reservoir import EchoStateNetwork, memory_capacity, squared_correlation

with optional_import():
    from threadpoolctl import threadpool_limits

SAMPLES, FEATURES, DELAYS, WASHOUT, RIDGE = 10_000, 50, 50, 200, 1e-6
OURS, SOLVE, SCORED, EACH = "memory_capacity", "one Cholesky solve", "... and scored", "one ridge fit a delay"
RESULTS = Path(__file__).parent / "results" / "memory_speed.json"

Array = NDArray[np.float64]


def collinear(condition: float) -> Array:
    """Noise whose singular values fall geometrically, turned so that no column is alone to blame."""
    random = np.random.default_rng(2)
    left = np.linalg.qr(random.normal(size=(SAMPLES, FEATURES)))[0] * np.sqrt(SAMPLES)
    turn = np.linalg.qr(random.normal(size=(FEATURES, FEATURES)))[0]
    return left * np.geomspace(1, 1 / condition, FEATURES) @ turn


def works(states: Array, message: Array) -> dict[str, Callable[[], object]]:
    half = (SAMPLES - WASHOUT) // 2
    delayed = np.column_stack([message[WASHOUT - d : SAMPLES - d] for d in range(DELAYS)])
    seen, rest = states[WASHOUT:][:half], states[WASHOUT:][half:]
    targets, unseen = delayed[:half], delayed[half:]

    def solve(y: Array) -> Ridge:
        return Ridge(alpha=RIDGE, solver="cholesky").fit(seen, y)

    return {
        OURS: lambda: memory_capacity(states, message, DELAYS, washout=WASHOUT, ridge=RIDGE),
        SOLVE: lambda: solve(targets),
        SCORED: lambda: squared_correlation(solve(targets).predict(rest), unseen),
        EACH: lambda: [solve(targets[:, d]) for d in range(DELAYS)],
    }


def main() -> None:
    """Measure, print the table and keep it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=31)
    rounds = parser.parse_args().rounds
    message = np.random.default_rng(0).integers(0, 2, SAMPLES) - 0.5
    kinds = {
        "noise": np.random.default_rng(1).normal(size=(SAMPLES, FEATURES)),
        "echo-state network": EchoStateNetwork(FEATURES).states(message),
        "collinear to 1e-5": collinear(1e5),
        "collinear to 1e-12": collinear(1e12),
    }
    results: dict[str, object] = {
        "what": "seconds, and their ratio to memory_capacity in the same round: lower quartile, median, upper quartile",
        "machine": machine("scikit-learn", "scipy"),
        "threads": 1,
        "rounds": rounds,
        "sizes": {"samples": SAMPLES, "features": FEATURES, "delays": DELAYS, "washout": WASHOUT},
    }
    print(f"{'milliseconds, median':22}{'':24}times memory_capacity: median [quartiles]")
    with threadpool_limits(1):
        for kind, states in kinds.items():
            candidates = works(states, message)
            for work in candidates.values():
                work()
            seconds = take_turns(candidates, rounds)
            kept = {}
            for name, taken in seconds.items():
                ratio = quartiles([taken[turn] / seconds[OURS][turn] for turn in taken])
                kept[name] = {"seconds": quartiles(list(taken.values())), "times memory_capacity": ratio}
                low, middle, high = ratio
                print(
                    f"{kind:22}{name:24}{kept[name]['seconds'][1] * 1e3:7.2f}   {middle:6.2f} [{low:.2f}, {high:.2f}]"
                )
            results[kind] = kept
    keep(RESULTS, results)


if __name__ == "__main__":
    main()
