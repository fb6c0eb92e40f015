"""The crawler driven and scored, beside an echo-state network of reservoirpy of as many features on the same series.

Run ``python benchmarks/reservoir_speed.py``; it needs reservoirpy (the extra ``peers``). The works take turns in one
process with one thread for BLAS; a ratio is that of neighbours in time, given as median and quartiles over the rounds.
The table goes into `docs/reservoir.md`, all numbers into ``results/reservoir_speed.json``.

Memory is that of 10,000 bits to 40 delays, NARMA-10 a readout fitted on the first half and scored on the second. Ours
is `BodyReservoir` from rest to states and the score. Of reservoirpy, the network is built beforehand and

- run: driven alone, nothing scored;
- run, our score: driven, and scored by the same function as ours;
- run, its readout: its own ridge fitted on the first half, predicting the second, and the score of that;
- JAX, our score: its JAX network, in single precision, compiled beforehand.
"""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns
from numpy.typing import NDArray

from stickslip.common.extras import optional_import
from stickslip.reservoir import memory_capacity, nrmse, squared_correlation
from stickslip.tasks import BodyReservoir, NRMSE, TASKS

with optional_import():
    import reservoirpy.jax.nodes
    import reservoirpy.nodes
    from threadpoolctl import threadpool_limits

RESULTS = Path(__file__).parent / "results" / "reservoir_speed.json"
PAGE = Path(__file__).parents[1] / "docs" / "reservoir.md"
SAMPLES, WASHOUT, DELAYS, RIDGE = 10_000, 200, 40, 1e-6
OURS = "the crawler, simulated and scored"
RUN, SCORED, OWN, JAX = (
    "reservoirpy: run",
    "reservoirpy: run, our score",
    "reservoirpy: run, its readout",
    "reservoirpy with JAX: run, our score",
)

Array = NDArray[np.float64]


def works(features: int, task: str) -> dict[str, Callable[[], object]]:
    problem = TASKS[task].draw(SAMPLES, 0)
    drive, targets = problem.drive, problem.targets
    column = drive[:, None]
    body = BodyReservoir(virtual_nodes=features // 3)
    settings = {"units": features, "sr": 0.9, "lr": 1.0, "input_scaling": 0.1, "seed": 0}
    network, compiled = reservoirpy.nodes.Reservoir(**settings), reservoirpy.jax.nodes.Reservoir(**settings)
    half = (WASHOUT + SAMPLES) // 2
    wanted = targets[:, None]
    if task == "memory capacity":
        wanted = np.stack([np.roll(targets, delay) for delay in range(DELAYS)], axis=1)

    def ours(states: Array) -> float:
        if task == "memory capacity":
            return memory_capacity(states, targets, DELAYS, washout=WASHOUT).corrected
        return NRMSE.solve(states, targets, WASHOUT).score

    def theirs(states: Array) -> object:
        readout = reservoirpy.nodes.Ridge(ridge=RIDGE)
        readout.fit(states[WASHOUT:half], wanted[WASHOUT:half])
        prediction = readout.run(states[half:])
        if task == "memory capacity":
            return squared_correlation(prediction, wanted[half:])
        return nrmse(prediction[:, 0], targets[half:])

    return {
        OURS: lambda: ours(body(drive)),
        RUN: lambda: network.run(column),
        SCORED: lambda: ours(network.run(column)),
        OWN: lambda: theirs(network.run(column)),
        JAX: lambda: ours(np.asarray(compiled.run(column), dtype=np.float64)),
    }


def markdown(rows: dict[tuple[str, int], dict[str, dict[str, list[float]]]]) -> str:
    """The table of the page."""
    heads = [f"{task}, {features}" for task, features in rows]
    lines = [f"| what | {' | '.join(heads)} |", f"|---|{'---:|' * len(heads)}"]
    for work in next(iter(rows.values())):
        cells = []
        for found in rows.values():
            low, middle, high = found[work]["times the crawler"]
            milliseconds = f"{1e3 * found[work]['seconds'][1]:.0f} ms"
            cells.append(milliseconds if work == OURS else f"{middle:.1f} [{low:.1f}, {high:.1f}]")
        lines.append(f"| {work} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, print the table, put it into the page and keep the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=21, help="turns of every work (default 21)")
    rounds = parser.parse_args().rounds
    rows = {}
    with threadpool_limits(1):
        for task in ("memory capacity", "NARMA-10 NRMSE"):
            for features in (12, 60):
                candidates = works(features, task)
                for work in candidates.values():
                    work()
                seconds = take_turns(candidates, rounds)
                rows[task, features] = {
                    name: {
                        "seconds": quartiles(list(taken.values())),
                        "times the crawler": quartiles([taken[turn] / seconds[OURS][turn] for turn in taken]),
                    }
                    for name, taken in seconds.items()
                }
    table = markdown(rows)
    print(table)
    refresh(PAGE, {"speed": table})
    keep(
        RESULTS,
        {
            "what": "seconds, and their ratio to the crawler's in the same round: three quartiles",
            "machine": machine("reservoirpy", "jax", "scikit-learn"),
            "threads": 1,
            "rounds": rounds,
            "sizes": {"samples": SAMPLES, "washout": WASHOUT, "delays": DELAYS},
            "rows": [{"task": task, "features": features, **found} for (task, features), found in rows.items()],
        },
    )


if __name__ == "__main__":
    main()
