"""Cost of every scene relative to the full crawler, what each integrates, and that models agree where two apply.

Run ``python benchmarks/scenes.py`` (``--rounds N`` for more turns). Scenes take turns in one process, and the ratio to
the crawler is that of the same round; its median and quartiles are printed as the table of the docs and kept in
`benchmarks/results/scenes.json`. A time includes the whole call of `simulate`.
"""

import argparse
import os
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns

from stickslip.crawler import Groups, Scene, simulate

RESULTS = Path(__file__).parent / "results" / "scenes.json"
PAGE = Path(__file__).parents[1] / "docs" / "solvers.md"
TOLERANCE = 1e-6
HOLD, WORDS = 1.0, 50
WORD = [1, 1, 1, 1, 0, 0, 0, 0]
DEFAULT, LINEAR, STIFF = Groups(), Groups.of("linear"), Groups(damping_ratio=100.0, deborah=1e-3)
CRAWLER = "on the ground, ratcheted foot (the full crawler)"
CASES = {
    CRAWLER: (DEFAULT, Scene(), "z, v; x and w by momentum"),
    "on the ground, symmetric friction": (DEFAULT, Scene(ratchet=False), "z, v; x and w by momentum"),
    "on a slope of 0.1": (DEFAULT, Scene(slope=0.1), "z, v; x and w by momentum"),
    "anchored": (DEFAULT, Scene(anchored=True), "z, v"),
    "on the ground, linear": (LINEAR, Scene(), "none between events"),
    "anchored, linear": (LINEAR, Scene(anchored=True), "none: one affine map a sample"),
    "on the ground, stiff (Pi2 = 100, Pi4 = 0.001)": (STIFF, Scene(), "z, v; x and w by momentum"),
    "4 massless segments": (DEFAULT, Scene(segments=4), "z, v: the segments stretch alike"),
    "1 segment, tube_mass 0.5": (DEFAULT, Scene(tube_mass=0.5), "z, v: half the tube at each end"),
    **{
        f"{n} segments, tube_mass 0.5": (DEFAULT, Scene(segments=n, tube_mass=0.5), f"{2 * n}, and the foot's 2")
        for n in (2, 4, 8, 16)
    },
}
# Where two solvers or two models apply: what is compared with what.
PAIRS = {
    "linear on the ground: closed form and Taylor": [(LINEAR, Scene(), "closed_form"), (LINEAR, Scene(), "taylor")],
    "anchored linear: closed form and Radau": [
        (LINEAR, Scene(anchored=True), "closed_form"),
        (LINEAR, Scene(anchored=True), "radau"),
    ],
    "crawler: Taylor and Radau": [(DEFAULT, Scene(), "taylor"), (DEFAULT, Scene(), "radau")],
    "crawler and 4 massless segments": [(DEFAULT, Scene(), "taylor"), (DEFAULT, Scene(segments=4), "taylor")],
}
PAIR_TOLERANCE = 1e-12


def disagreement(pair: list[tuple[Groups, Scene, str]]) -> float:
    """Largest difference of foot and deformation over two words."""
    first, second = (
        simulate(groups, WORD * 2, HOLD, scene=scene, solver=solver, tolerance=PAIR_TOLERANCE)
        for groups, scene, solver in pair
    )
    return max(float(np.abs(getattr(first, name) - getattr(second, name)).max()) for name in ("foot", "deformation"))


def scene_table(rows: dict[str, dict[str, Any]]) -> str:
    """Markdown."""
    lines = ["| scene | states integrated | `Trajectory.model` | cost over the crawler's |", "|---|---|---|---:|"]
    for name, row in rows.items():
        low, middle, high = row["ratio"]
        lines.append(f"| {name} | {row['states']} | {row['model']} | {middle:.2f} [{low:.2f}, {high:.2f}] |")
    own = rows[CRAWLER]["us_per_time"][1]
    return "\n".join([*lines, "", f"The crawler itself took {own:.2f} us a unit of time, at tolerance {TOLERANCE:g}."])


def agreement_table(agreements: dict[str, float]) -> str:
    """Markdown."""
    rows = [f"| {name} | {difference:.0e} |" for name, difference in agreements.items()]
    return "\n".join(["| compared | largest difference of foot and deformation |", "|---|---:|", *rows])


def main() -> None:
    """Print the tables, put them into the page and keep the results."""
    parser = argparse.ArgumentParser(description="Cost of every scene relative to the full crawler.")
    parser.add_argument("--rounds", type=int, default=15, help="turns of every scene (default 15)")
    rounds = parser.parse_args().rounds

    def run(groups: Groups, scene: Scene) -> str:
        return simulate(groups, WORD * WORDS, HOLD, scene=scene, tolerance=TOLERANCE).model

    models = {name: run(groups, scene) for name, (groups, scene, _) in CASES.items()}
    works = {name: lambda g=groups, s=scene: run(g, s) for name, (groups, scene, _) in CASES.items()}
    seconds = take_turns(works, rounds)
    span = HOLD * WORDS * len(WORD)
    rows = {}
    for name, (_, _, states) in CASES.items():
        ratio = quartiles([time / seconds[CRAWLER][turn] for turn, time in seconds[name].items()])
        cost = quartiles([1e6 * time / span for time in seconds[name].values()])
        rows[name] = {"states": states, "model": models[name], "ratio": ratio, "us_per_time": cost}
    agreements = {name: disagreement(pair) for name, pair in PAIRS.items()}
    made = {"scenes": scene_table(rows), "agreements": agreement_table(agreements)}
    for table in made.values():
        print(f"{table}\n")
    refresh(PAGE, made)
    RESULTS.parent.mkdir(exist_ok=True)
    keep(RESULTS, {"machine": machine(), "tolerance": TOLERANCE, "scenes": rows, "disagreements": agreements})


if __name__ == "__main__":
    main()
