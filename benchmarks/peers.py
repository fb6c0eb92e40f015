"""The same trajectory by stickslip and by other people's solvers: cost against error, in one process.

Run ``python benchmarks/peers.py [--rounds N] [--output benchmarks/results/peers.json]``; ``pip install
'stickslip[peers]'`` installs the peers, and one that is missing is left out.

Every solver crawls for 200 time units from rest under the word 11110000 with holds of 1; its error is that of the foot
at the end, which is known to 25 digits. All take turns, round after round; a slow solver sits some rounds out and is
never given less to do. Ratios compare a solver with the cheapest setting of stickslip that is no less accurate, in the
same rounds.
"""

import os

# Every solver may use one thread: idle threads of one would take the processor from the next, and a trajectory offers
# nothing to do at once. This must come before the libraries are imported.
os.environ["OMP_NUM_THREADS"] = "1"
os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ["MKL_NUM_THREADS"] = "1"
os.environ["NUMBA_NUM_THREADS"] = "1"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["JAX_PLATFORMS"] = "cpu"

import argparse
import importlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from measuring import keep, machine, refresh
from peer_solvers.comparison import GOALS, measure, meet, Row
from peer_solvers.one_hold import measure_calls
from peer_solvers.own import KERNEL, SIMULATE
from peer_solvers.problem import Contender, FOOT, HOLD, SLIPS, WORD

from stickslip.common.extras import MissingExtra

SOLVERS = {
    "own": "stickslip",
    "with_scipy": "scipy",
    "with_heyoka": "heyoka",
    "with_diffrax": "diffrax",
    "with_mujoco": "mujoco",
}
RESULTS = Path(__file__).parent / "results" / "peers.json"
PAGE = Path(__file__).parents[1] / "docs" / "solvers.md"
LIBRARIES = ("stickslip", "numpy", "numba", "llvmlite", "scipy", "heyoka", "diffrax", "jax", "jaxlib", "mujoco")


def main() -> None:
    """Measure, print the tables and write the file."""
    parser = argparse.ArgumentParser(description="The same trajectory by stickslip and its peers.")
    parser.add_argument("--rounds", type=int, default=21, help="of the solvers that take least (default 21)")
    parser.add_argument("--output", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    if arguments.rounds < 1:
        parser.error(f"--rounds must be a whole number >= 1, got {arguments.rounds}")

    rows = measure(list(available()), arguments.rounds)
    goals = [meeting for goal in GOALS for meeting in meet(goal, rows)]
    calls = measure_calls(arguments.rounds)
    print_rows(rows)
    print_goals(goals)
    print_calls(calls)
    results = {
        "machine": machine(*LIBRARIES),
        "trajectory": {"foot": FOOT, "slips": SLIPS, "hold": HOLD, "holds": len(WORD), "word": "11110000"},
        "rounds": arguments.rounds,
        "solvers": [row | {"turns": len(row["turns"])} for row in rows],
        "at equal error": goals,
        "one hold": calls,
    }
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    keep(arguments.output, results)
    print(f"written to {arguments.output}")
    if arguments.output == RESULTS:
        refresh(PAGE, {"peers": goals_table(goals), "calls": calls_table(calls)})


def available() -> Iterable[Contender]:
    """Solvers of the libraries that are installed; for each other one a line that says how to install it."""
    for module, library in SOLVERS.items():
        try:
            solvers = importlib.import_module(f"peer_solvers.{module}")
        except MissingExtra as missing:
            print(f"{library} is left out: {missing}")
            continue
        yield from solvers.contenders()


def print_rows(rows: list[Row]) -> None:
    print(
        "median [quartiles] of CPU time; x: multiple of the cheapest stickslip setting (in brackets) no less accurate\n"
    )
    print(
        f"{'':32}{'setting':16}{'error':>8}{'slips':>7}{'turns':>7}  {'us per time unit':26}{'x kernel':31}x simulate"
    )
    notes = set()
    for row in rows:
        name = f"{row['library']} {row['method']}"
        slips = "?" if row["slips"] is None else row["slips"]
        times = "".join(f"{times_text(row['times stickslip'][method]):31}" for method in (KERNEL, SIMULATE))
        cost = spread(row["microseconds per time unit"])
        print(
            f"{name:32}{row['setting']:16}{row['error']:8.0e}{slips:>7}{len(row['turns']):7}  {cost:26}{times}".rstrip()
        )
        if row["note"]:
            notes.add(f"{name}: {row['note']}")
    for note in sorted(notes):
        print(note)


def print_goals(goals: list[Row]) -> None:
    print("\nat equal error: the cheapest setting of each method that reaches it, as do all tighter ones\n")
    print(f"{'goal':8}{'':32}{'setting':16}{'us per time unit':26}{'x kernel':31}x simulate")
    for row in goals:
        times = "".join(f"{times_text(row['times stickslip'][method]):31}" for method in (KERNEL, SIMULATE))
        cost = spread(row["microseconds per time unit"])
        name = f"{row['library']} {row['method']}"
        print(f"{row['goal']:<8.0e}{name:32}{row['setting']:16}{cost:26}{times}".rstrip())


def goals_table(goals: list[Row]) -> str:
    """Markdown, for the docs."""
    lines = [
        "| error | peer | setting | us per unit of time | over the kernel | over simulate |",
        "|---|---|---|---:|---:|---:|",
    ]
    for row in goals:
        times = " | ".join(times_text(row["times stickslip"][method]) for method in (KERNEL, SIMULATE))
        cost = spread(row["microseconds per time unit"])
        lines.append(f"| {row['goal']:.0e} | {row['library']} {row['method']} | {row['setting']} | {cost} | {times} |")
    return "\n".join(lines)


def calls_table(calls: list[Row]) -> str:
    """Markdown, for the docs."""
    names = [name for name in calls[0] if name not in ("hold", "tolerance")]
    lines = ["| hold | tolerance | " + " | ".join(names) + " |", "|---" * 2 + "|---:" * len(names) + "|"]
    for case in calls:
        cells = " | ".join(spread(case[name]) for name in names)
        lines.append(f"| {case['hold']:g} | {case['tolerance']:g} | {cells} |")
    return "\n".join(lines)


def print_calls(calls: list[Row]) -> None:
    print("\none hold by a call from Python, us: median [quartiles]; less a compiled call that does nothing\n")
    for case in calls:
        print(f"hold {case['hold']:g}, tolerance {case['tolerance']:g}")
        for name, values in case.items():
            if name not in ("hold", "tolerance"):
                print(f"    {name:32}{spread(values)}")


def times_text(times: Row | None) -> str:
    return "" if times is None else f"{spread(times['quartiles'])} ({times['setting']})"


def spread(values: list[float]) -> str:
    """Median and quartiles to three figures."""
    low, middle, high = (figures(value) for value in values)
    return f"{middle} [{low}, {high}]"


def figures(value: float) -> str:
    """Three figures, never in exponents."""
    return np.format_float_positional(value, precision=3, unique=False, fractional=False, trim="-")


if __name__ == "__main__":
    main()
