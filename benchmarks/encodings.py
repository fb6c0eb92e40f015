"""What each encoding of a real-valued series costs and loses, at equal physical time a sample.

Run ``python benchmarks/encodings.py``. Every sample lasts one unit of time, whatever the number of holds in it, and the
body is the default crawler read four times a sample. The table goes into the docs, and all numbers into
`benchmarks/results/encodings.json`. Times are of the whole call, relative to the pulse width's in the same round.
"""

import argparse
import os
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns

from stickslip.studies.benchmark import run_benchmark
from stickslip.tasks import BodyReservoir, CAPACITY, encode, Problem, random_uniform, SeriesTask, TASKS

RESULTS = Path(__file__).parent / "results" / "encodings.json"
PAGE = Path(__file__).parents[1] / "docs" / "encodings.md"
SAMPLE_TIME, LENGTH, SEEDS = 1.0, 4000, range(5)
PULSE_WIDTH = "pulse_width", 1
CASES = (PULSE_WIDTH, ("threshold", 1), *(("sigma_delta", holds) for holds in (1, 2, 4, 8, 16)))
FORECAST = ("NARMA-2 uniform NRMSE", "NARMA-10 uniform NRMSE", "Mackey-Glass NRMSE")


def _memory(length: int, seed: int) -> Problem:
    drive = random_uniform(length, seed)
    return Problem(drive, drive, drive, 0)


CHOSEN = {"memory of uniform input": SeriesTask(_memory, CAPACITY)} | {name: TASKS[name] for name in FORECAST}


def loss(encoding: str, holds: int) -> float:
    """Root-mean-square distance of the share of a sample that the valve is open from a uniform sample's value."""
    drive = random_uniform(LENGTH, 0)
    shares = encode(drive, encoding, holds).reshape(LENGTH, holds).mean(axis=1)
    return float(np.sqrt(np.mean((shares - drive) ** 2)))


def markdown(rows: list[dict[str, Any]]) -> str:
    """The table of the page."""
    heading = f"| encoding | holds a sample | loss | time | {' | '.join(CHOSEN)} |"
    lines = [heading, f"|---|{'---:|' * (3 + len(CHOSEN))}"]
    for row in rows:
        scores = " | ".join(f"{np.mean(row[name]):.2f} ± {np.std(row[name], ddof=1):.2f}" for name in CHOSEN)
        name = row["encoding"].replace("_", " ")
        lines.append(f"| {name} | {row['holds']} | {row['loss']:.2f} | {row['time'][1]:.2f} | {scores} |")
    return "\n".join(lines)


def main() -> None:
    """Print the table, put it into the page and keep the results."""
    parser = argparse.ArgumentParser(description="What each encoding of a real-valued series costs and loses.")
    parser.add_argument("--rounds", type=int, default=15, help="turns of every encoding (default 15)")
    rounds = parser.parse_args().rounds
    bodies = {
        (encoding, holds): BodyReservoir(hold=SAMPLE_TIME / holds, encoding=encoding, holds_per_sample=holds)
        for encoding, holds in CASES
    }
    drive = random_uniform(LENGTH, 0)
    works = {f"{encoding} {holds}": lambda body=body: body(drive) for (encoding, holds), body in bodies.items()}
    for work in works.values():
        work()
    seconds = take_turns(works, rounds)
    reference = seconds["{} {}".format(*PULSE_WIDTH)]
    rows = []
    for (encoding, holds), body in bodies.items():
        scores = run_benchmark(tasks=CHOSEN, reservoirs={"body": body}, seeds=SEEDS, length=LENGTH)
        own = seconds[f"{encoding} {holds}"]
        rows.append(
            {
                "encoding": encoding,
                "holds": holds,
                "loss": loss(encoding, holds),
                "time": quartiles([own[turn] / reference[turn] for turn in own if turn in reference]),
                "us_per_sample": quartiles([1e6 * each / LENGTH for each in own.values()]),
                **{name: [score.score for score in scores if score.task == name] for name in CHOSEN},
            }
        )
    table = markdown(rows)
    print(table)
    refresh(PAGE, {"encodings": table})
    keep(RESULTS, {"machine": machine(), "sample_time": SAMPLE_TIME, "length": LENGTH, "rows": rows})


if __name__ == "__main__":
    main()
