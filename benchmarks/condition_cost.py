"""What it costs to be told how far an answer moves for a change of its start: `simulate(..., condition=True)`.

Run ``python benchmarks/condition_cost.py`` (``--rounds N`` for more turns). A run with and one without take turns in
one process, and the ratio is that of the same round; its median and quartiles are printed as the table of the docs and
kept in `benchmarks/results/condition_cost.json`. A time includes the whole call of `simulate`.
"""

import argparse
import os
from pathlib import Path

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from measuring import keep, machine, quartiles, refresh, take_turns

from stickslip.crawler import Groups, Scene, simulate

RESULTS = Path(__file__).parent / "results" / "condition_cost.json"
PAGE = Path(__file__).parents[1] / "docs" / "solvers.md"
HOLD, WORD, WORDS = 1.0, [1, 1, 1, 1, 0, 0, 0, 0], 50
LINEAR = Groups(duffing=0.0, radial_coupling=0.0)
CHAOTIC = Groups(duffing=150.0, damping_ratio=0.0, deborah=0.03, foot_mass_fraction=0.99, kinetic_friction=0.1)
CASES = {
    "default": (Groups(), Scene(), "taylor"),
    "anchored": (Groups(), Scene(anchored=True), "taylor"),
    "undamped, stiff, heavy-footed": (CHAOTIC, Scene(), "taylor"),
    "damped, stiff (Pi2 = 1000)": (Groups(damping_ratio=1e3), Scene(), "radau"),
    "linear": (LINEAR, Scene(), "closed_form"),
}
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12)


def table(ratios: dict[str, dict[str, list[float]]]) -> str:
    """Markdown."""
    lines = [
        "| crawler | solver | " + " | ".join(f"{tolerance:g}" for tolerance in TOLERANCES) + " |",
        "|---|---|" + "---:|" * len(TOLERANCES),
    ]
    for name, row in ratios.items():
        cells = [f"{middle:.2f} [{low:.2f}, {high:.2f}]" for low, middle, high in row.values()]
        lines.append(f"| {name} | {CASES[name][2].replace('_', ' ')} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Print the table, put it into the page and keep the results."""
    parser = argparse.ArgumentParser(description="Cost of the condition, over that of the run without.")
    parser.add_argument("--rounds", type=int, default=15, help="turns of every run (default 15)")
    rounds = parser.parse_args().rounds

    works = {}
    for name, (groups, scene, solver) in CASES.items():
        for tolerance in TOLERANCES:
            for asked in (False, True):

                def run(g=groups, s=scene, by=solver, t=tolerance, a=asked) -> None:
                    simulate(g, WORD * WORDS, HOLD, scene=s, solver=by, tolerance=t, condition=a)

                run()
                works[f"{name} {tolerance:g} {asked}"] = run
    seconds = take_turns(works, rounds)
    ratios: dict[str, dict[str, list[float]]] = {}
    for name in CASES:
        for tolerance in TOLERANCES:
            without, asked = (seconds[f"{name} {tolerance:g} {whether}"] for whether in (False, True))
            ratio = quartiles([asked[turn] / without[turn] for turn in without])
            ratios.setdefault(name, {})[f"{tolerance:g}"] = ratio
    print(table(ratios))
    refresh(PAGE, {"condition": table(ratios)})
    RESULTS.parent.mkdir(exist_ok=True)
    keep(RESULTS, {"machine": machine(), "ratios": ratios})


if __name__ == "__main__":
    main()
