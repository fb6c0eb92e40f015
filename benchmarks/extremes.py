"""The solver at the edges of the ranges: slips, error and cost of every row, as a table for the docs.

Run ``python benchmarks/extremes.py`` (``--rounds N`` for more turns). The rows and what is right for them are those
of `tests/judges/extremes.json`, which holds the verdicts of a 60-digit implicit judge. All rows take turns, round
after round in one process, so that the machine's drift falls on all alike. Where a call is short, a batch of equal
crawlers makes it longer, and what a batch of as many crawlers with nothing to do takes is subtracted. Times are the
processor's, so that other processes on the machine do not count. Medians over the rounds are printed and, with their
range and the machine, written to `benchmarks/results/extremes.json`.

What the physics itself does in a unit of time is the largest of three rates: the body's own frequency
sqrt(K / m - (Pi2 / m)^2) / (2 pi), with the stiffness K = 1 + 3 Pi1 z^2 at the largest |z| of the run and the mass m
that moves (1 - r while the foot sticks; r (1 - r) if it ever slides), 0 where the damping leaves no oscillation; the
slips; and the edges of the valve. A scene is allowed 25 us a unit of time, or that much for each of these cycles
where they are more than one.
"""

import argparse
import json
import math
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from measuring import keep, machine, refresh

from stickslip.crawler import Groups, Scene, simulate, SolverError, State, Trajectory

REFERENCES = Path(__file__).parents[1] / "tests" / "judges" / "extremes.json"
RESULTS = Path(__file__).parent / "results" / "extremes.json"
PAGE = Path(__file__).parents[1] / "docs" / "extremes.md"
TOLERANCE = 1e-6
ROUNDS = 9
SHORTEST = 2e-2  # seconds that one timed call should take, so that the clock and the call itself do not matter
LARGEST_BATCH = 256
# The row of the batch: members, holds, and the extreme one among them.
MEMBERS, WORD, EXTREME = 64, [1, 1, 1, 1, 0, 0, 0, 0] * 4, "Pi2 = 1e2"


def arguments(row: dict[str, Any]) -> tuple[Groups, list[int], float, dict[str, Any]]:
    options = {
        "scene": Scene(**row["scene"]),
        "initial": State(*row["initial"]),
        "samples_per_hold": row["samples_per_hold"],
        "tolerance": TOLERANCE,
    }
    return Groups(**row["groups"]), [int(letter) for letter in row["valve"]], row["hold"], options


def error_of(done: Trajectory, row: dict[str, Any]) -> float:
    """Largest difference of a sample from the reference."""
    exact = {name: np.array(values, dtype=float) for name, values in row["samples"].items()}
    return max(float(np.abs(getattr(done, name) - values).max()) for name, values in exact.items())


def cycles_per_time(row: dict[str, Any]) -> float:
    """How often the physics itself turns round in a unit of time; see the head of this file."""
    groups = Groups(**row["groups"])
    r = groups.foot_mass_fraction
    farthest = max([abs(row["initial"][0]), *(abs(float(z)) for z in row["samples"]["deformation"])])
    stiffness = 1.0 + 3.0 * groups.duffing * farthest**2
    masses = [1.0 - r, r * (1.0 - r)] if row["events"] else [1.0 - r]
    squares = [stiffness / mass - (groups.damping_ratio / mass) ** 2 for mass in masses]
    own = math.sqrt(max(0.0, *squares)) / (2.0 * math.pi)
    return max(own, row["slips"] / (len(row["valve"]) * row["hold"]), 1.0 / row["hold"])


def seconds(call: Callable[[], Any]) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start


def accuracy(row: dict[str, Any]) -> dict[str, Any]:
    """Slips and error of a row, or the solver's refusal."""
    groups, valve, hold, options = arguments(row)
    found = {"judge_slips": row["slips"], "condition": row["condition"], "cycles_per_time": cycles_per_time(row)}
    try:
        done = simulate(groups, valve, hold, **options)
    except SolverError as refusal:
        return {"refusal": str(refusal), **found}
    return {"model": done.model, "slips": done.slips, "error_over_tolerance": error_of(done, row) / TOLERANCE, **found}


def calls(row: dict[str, Any]) -> tuple[Callable[[], Any], Callable[[], Any], int]:
    """The row as a batch long enough to time, the same batch with nothing to do, and its size."""
    groups, valve, hold, options = arguments(row)
    once = min(seconds(lambda: simulate(groups, valve, hold, **options)) for _ in range(3))
    size = min(LARGEST_BATCH, max(1, round(SHORTEST / once)))
    # A closed valve at rest needs one step a hold of it; a hold as short as this is nothing else.
    idle = options | {"initial": State()}
    return (
        lambda: simulate([groups] * size, valve, hold, **options),
        lambda: simulate([Groups()] * size, [0], 1e-9, **idle),
        size,
    )


def measure(rows: dict[str, dict[str, Any]], rounds: int) -> dict[str, dict[str, Any]]:
    """What the table says of every row."""
    found = {name: accuracy(row) for name, row in rows.items()}
    timed = {name: calls(rows[name]) for name in rows if "refusal" not in found[name]}
    busy: dict[str, list[float]] = {name: [] for name in timed}
    idle: dict[str, list[float]] = {name: [] for name in timed}
    for turn in range(rounds):
        # Every other round runs backward, so that no row is always the first.
        for name in list(timed)[:: 1 if turn % 2 == 0 else -1]:
            busy[name].append(seconds(timed[name][0]))
            idle[name].append(seconds(timed[name][1]))
    for name, (_, _, size) in timed.items():
        scale = 1e6 / (size * len(rows[name]["valve"]) * rows[name]["hold"])
        costs = [scale * (value - statistics.median(idle[name])) for value in busy[name]]
        found[name]["us_per_time"] = statistics.median(costs)
        found[name]["us_per_time_range"] = [min(costs), max(costs)]
        found[name]["us_per_cycle"] = found[name]["us_per_time"] / max(1.0, found[name]["cycles_per_time"])
    return found


def measure_batch(rows: dict[str, dict[str, Any]], rounds: int) -> dict[str, Any]:
    """How much longer a batch takes with an extreme member than without, less what that member takes alone."""
    extreme = Groups(**rows[EXTREME]["groups"])
    plain = [Groups()] * (MEMBERS - 1)
    mixed = [*plain[: MEMBERS // 2], extreme, *plain[MEMBERS // 2 :]]
    takes: dict[str, list[float]] = {"plain": [], "mixed": [], "alone": []}
    members = {"plain": plain, "mixed": mixed, "alone": [extreme]}
    for _ in range(4 * rounds):
        for name, groups in members.items():
            takes[name].append(seconds(lambda groups=groups: simulate(groups, WORD, 1.0, tolerance=TOLERANCE)))
    slower = [(both - alone) / rest for rest, both, alone in zip(*takes.values(), strict=True)]
    return {"members": MEMBERS, "extreme": EXTREME, "slowdown_of_the_others": statistics.median(slower)}


def table(results: dict[str, Any]) -> str:
    """The results in Markdown."""
    lines = [
        "| scene | solver | slips, ours / judge | error / tolerance | condition | us per unit time | cycles per unit "
        "time | us per cycle |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, row in results["rows"].items():
        if "refusal" in row:
            cells = ["refused", f"– / {row['judge_slips']}", "–", f"{row['condition']:.2g}", "–"]
            cells += [f"{row['cycles_per_time']:.2g}", "–"]
        else:
            cells = [
                row["model"],
                f"{row['slips']} / {row['judge_slips']}",
                f"{row['error_over_tolerance']:.2g}",
                f"{row['condition']:.2g}",
                f"{row['us_per_time']:.3g}",
                f"{row['cycles_per_time']:.2g}",
                f"{row['us_per_cycle']:.3g}",
            ]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    batch = results["batch"]
    lines += [
        "",
        f"A batch of {batch['members']}, one of them extreme ({batch['extreme']}): the others take "
        f"{batch['slowdown_of_the_others']:.2f} of the time that they take without it.",
    ]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description="Slips, error and cost at the edges of the ranges.")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help=f"turns of every row (default {ROUNDS})")
    rounds = parser.parse_args().rounds
    rows = json.loads(REFERENCES.read_text(encoding="utf-8"))
    results = {
        "tolerance": TOLERANCE,
        "rounds": rounds,
        "machine": machine(),
        "rows": measure(rows, rounds),
        "batch": measure_batch(rows, rounds),
    }
    keep(RESULTS, results)
    print(table(results))
    refresh(PAGE, {"extremes": table(results)})


if __name__ == "__main__":
    main()
