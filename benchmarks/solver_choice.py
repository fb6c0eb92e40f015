"""What `solver="auto"` costs beside the best single choice, over random crawlers, and how its prediction is calibrated.

Run ``python benchmarks/solver_choice.py [--crawlers N] [--rounds N] [--output benchmarks/results/solver_choice.json]``.

Half of the crawlers are ordinary, half from the whole of the ranges that the package is meant for. Solvers take turns
on each; times are of the processor, the least of some rounds, for one unit of time. A run that takes too many steps is
broken off, and counts by the time that it reached.
"""

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from measuring import keep, machine, refresh
from numpy.typing import NDArray

from stickslip.crawler import Groups, Scene
from stickslip.crawler.cost import predicted_steps
from stickslip.crawler.drive import drive
from stickslip.crawler.model.state import Body, coefficients_of
from stickslip.crawler.solvers import AUTO, cheapest, choose, SOLVERS, solvers_for
from stickslip.crawler.steps.options import FINISHED

RESULTS = Path(__file__).parent / "results" / "solver_choice.json"
PAGE = Path(__file__).parents[1] / "docs" / "solvers.md"
SCENES = (Scene(), Scene(), Scene(anchored=True), Scene(ratchet=False))
MOST_STEPS = 200_000
_LEAST_HOLDS, _MOST_HOLDS, _TIME = 16, 1000, 30.0
_DEAR = 0.05  # seconds that one run may take to be run again
_FEW = 100  # steps that tell nothing of what one takes
_SHOWN = 10

Row = dict[str, Any]


class Drawn(NamedTuple):
    """One random crawler and what it is to do."""

    groups: Groups
    scene: Scene
    hold: float
    tolerance: float
    schedule: NDArray[np.float64]


class Run(NamedTuple):
    """What one solver took."""

    steps: int
    reached: float  # units of time
    seconds: float
    finished: bool


def random_crawlers(count: int, seed: int) -> Iterator[Drawn]:
    """Draw crawlers, the ordinary and the extreme by turns."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        yield random_crawler(rng, ordinary=number % 2 == 0)


def random_crawler(rng: np.random.Generator, *, ordinary: bool) -> Drawn:
    """One crawler, within a factor of four of the default values or from anywhere."""

    def spread(low: float, high: float, usual: float) -> float:
        if ordinary:
            low, high = max(low, usual / 4.0), min(high, usual * 4.0)
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    linear = rng.random() < 0.2
    duffing = 0.0 if linear or rng.random() < 0.1 else spread(1e-2, 1e6, 0.5)
    # Without a cubic spring nothing bounds a body whose area grows faster than its spring.
    coupling = 0.0 if linear else float(rng.uniform(0.0, 0.6 if ordinary else 2.0 if duffing > 0.0 else 1.0))
    foot = float(rng.uniform(0.1, 0.9)) if ordinary else spread(1e-6, 0.5, 0.3)
    static = 0.0 if rng.random() < 0.15 else spread(1e-3, 1e3, 0.3)
    groups = Groups(
        duffing=duffing,
        damping_ratio=0.0 if rng.random() < 0.2 else spread(1e-2, 1e4, 0.05),
        deborah=spread(1e-6, 1e6, 0.5),
        radial_coupling=coupling,
        foot_mass_fraction=1.0 - foot if rng.random() < 0.5 else foot,
        static_friction=static,
        kinetic_friction=static * float(rng.choice([0.0, 1.0, rng.uniform()], p=[0.15, 0.15, 0.7])),
    )
    hold = spread(1e-3, 100.0, 1.0)
    holds = int(np.clip(np.ceil(_TIME / hold), _LEAST_HOLDS, _MOST_HOLDS))
    schedule = rng.integers(0, 2, holds).astype(np.float64)
    # Nothing happens to a body at rest until the valve opens.
    schedule[0] = 1
    scene = SCENES[rng.integers(len(SCENES))]
    return Drawn(groups, scene, hold, 10.0 ** float(rng.uniform(-14.0, -2.0)), schedule)


def run(drawn: Drawn, name: str, max_steps: int) -> Run:
    """Drive a crawler from rest by one solver."""
    solver = SOLVERS[name]
    coefficients = coefficients_of(drawn.groups, drawn.scene)
    options = solver.options(drawn.tolerance, max_steps=max_steps)
    workspace = solver.workspace(coefficients, drawn.hold, 1)
    rest = Body(0.0, 0.0, 0.0, 0.0, 0.0, 0, 0)
    samples, events = np.empty((5, len(drawn.schedule))), np.empty((0, 2))
    start = time.process_time()
    outcome, finished = drive(rest, coefficients, drawn.schedule, drawn.hold, options, samples, events, workspace)
    seconds = time.process_time() - start
    reached = finished * drawn.hold + (outcome.elapsed if finished < len(drawn.schedule) else 0.0)
    return Run(outcome.steps, reached, seconds, outcome.status == FINISHED)


def measure(drawn: Drawn, rounds: int) -> Row:
    """Microseconds and steps a unit of time by each solver that can take the crawler, and by the one chosen."""
    chosen = choose(AUTO, *drawn[:4]).name
    contenders = {name: name for name in solvers_for(drawn.groups, drawn.scene)} | {AUTO: chosen}
    seconds = dict.fromkeys(contenders, np.inf)
    row: Row = {"drawn": drawn, "chosen": chosen, "steps": {}, "cost": {}, "step cost": {}}
    for turn in range(rounds):
        for contender, name in contenders.items():
            if turn > 0 and seconds[contender] > _DEAR:
                continue
            done = run(drawn, name, MOST_STEPS)
            seconds[contender] = min(seconds[contender], done.seconds)
            row["cost"][contender] = 1e6 * seconds[contender] / done.reached
            if contender != AUTO:
                row["steps"][name] = done.steps / done.reached
                # A run broken off is of steps without events, which take less.
                if done.finished and done.steps >= _FEW:
                    row["step cost"][name] = 1e6 * seconds[contender] / done.steps
    row["ratio"] = row["cost"][AUTO] / min(row["cost"][name] for name in contenders if name != AUTO)
    return row


def step_costs(rows: list[Row]) -> dict[str, dict[str, float]]:
    """Median microseconds that a step takes, by solver and order."""
    each: dict[str, dict[str, list[float]]] = {}
    for row in rows:
        for name, cost in row["step cost"].items():
            order = str(SOLVERS[name].order_for(row["drawn"].tolerance))
            each.setdefault(name, {}).setdefault(order, []).append(cost)
    return {
        name: {order: round(float(np.median(costs)), 3) for order, costs in sorted(by.items(), key=lambda i: int(i[0]))}
        for name, by in sorted(each.items())
    }


def looks_to_steps(rows: list[Row]) -> list[float]:
    """Time of a look in closed form over that of a Taylor step of the same crawler on the ground: quartiles."""
    costs = [row["step cost"] for row in rows if not row["drawn"].scene.anchored]
    ratios = [cost["closed_form"] / cost["taylor"] for cost in costs if {"closed_form", "taylor"} <= cost.keys()]
    return np.percentile(ratios, [25, 50, 75]).round(2).tolist() if ratios else []


def predictions(rows: list[Row]) -> dict[str, list[float]]:
    """Steps predicted over steps counted, by solver: 5th, 25th, 50th, 75th and 95th percentiles."""
    ratios: dict[str, list[float]] = {}
    for row in rows:
        for name, counted in row["steps"].items():
            ratios.setdefault(name, []).append(predicted_steps(name, *row["drawn"][:4]) / counted)
    return {name: np.percentile(each, [5, 25, 50, 75, 95]).round(2).tolist() for name, each in sorted(ratios.items())}


def choosing(rows: list[Row]) -> float:
    """Median microseconds of a choice itself."""
    each = []
    for row in rows:
        cheapest.cache_clear()
        start = time.perf_counter()
        choose(AUTO, *row["drawn"][:4])
        each.append(1e6 * (time.perf_counter() - start))
    return round(float(np.median(each)), 1)


def summary(rows: list[Row]) -> Row:
    """How far from the best the choice is."""
    ratios = np.array([row["ratio"] for row in rows])
    return {
        "median": round(float(np.median(ratios)), 3),
        "worst tenth": round(float(np.percentile(ratios, 90)), 3),
        "worst hundredth": round(float(np.percentile(ratios, 99)), 3),
        "worst": round(float(ratios.max()), 3),
    }


def always(rows: list[Row]) -> dict[str, Row]:
    """The same for whom takes one solver always; the closed form among the linear."""
    found = {}
    for name in SOLVERS:
        able = [row for row in rows if name in row["cost"]]
        found[name] = summary(
            [{"ratio": row["cost"][name] / min(row["cost"][each] for each in row["steps"])} for row in able]
        )
    return found


def described(row: Row) -> Row:
    """One crawler's row, ready for JSON."""
    drawn = row["drawn"]
    return {
        "ratio": round(row["ratio"], 2),
        "chosen": row["chosen"],
        "microseconds per time unit": {name: float(f"{cost:.3g}") for name, cost in row["cost"].items()},
        "groups": drawn.groups.to_dict(),
        "scene": drawn.scene.to_dict(),
        "hold": drawn.hold,
        "tolerance": drawn.tolerance,
    }


def choice_table(results: dict[str, Any]) -> str:
    """Markdown, for the docs."""
    shares = ("median", "worst tenth", "worst hundredth", "worst")
    lines = ["| measured cost over that of the best solver | " + " | ".join(shares) + " |", "|---" + "|---:" * 4 + "|"]
    named = {"`auto`": results["auto over the best"]}
    named |= {f"always `{name}`": results["one solver always, over the best"][name] for name in ("taylor", "radau")}
    for name, ratios in named.items():
        lines.append(f"| {name} | " + " | ".join(f"{ratios[share]:.3g}" for share in shares) + " |")
    return "\n".join(lines)


def main() -> None:
    """Measure, print and write the file."""
    parser = argparse.ArgumentParser(description="The cost of solver='auto' beside the best single choice.")
    parser.add_argument("--crawlers", type=int, default=600)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    for name in ("crawlers", "rounds"):
        if getattr(arguments, name) < 1:
            parser.error(f"--{name} must be a whole number >= 1, got {getattr(arguments, name)}")

    for name in SOLVERS:  # compiled before the clock runs
        run(Drawn(Groups(duffing=0.0, radial_coupling=0.0), Scene(), 1.0, 1e-6, np.ones(1, np.int8)), name, MOST_STEPS)
    rows = [measure(drawn, arguments.rounds) for drawn in random_crawlers(arguments.crawlers, arguments.seed)]
    rows.sort(key=lambda row: -row["ratio"])
    results = {
        "machine": machine(),
        "crawlers": arguments.crawlers,
        "rounds": arguments.rounds,
        "seed": arguments.seed,
        "auto over the best": summary(rows),
        "one solver always, over the best": always(rows),
        "chosen": {name: sum(row["chosen"] == name for row in rows) for name in SOLVERS},
        "microseconds of a choice": choosing(rows),
        "microseconds of a step by order": step_costs(rows),
        "a look over a step of Taylor, quartiles": looks_to_steps(rows),
        "steps predicted over counted, percentiles 5, 25, 50, 75, 95": predictions(rows),
        "worst": [described(row) for row in rows[:_SHOWN]],
    }
    for title, found in results.items():
        if title not in ("machine", "worst"):
            print(f"{title}: {found}")
    for row in results["worst"]:
        print(f"  {row['ratio']:6.2f}  {row['chosen']:12}{row['microseconds per time unit']}")
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    keep(arguments.output, results)
    print(f"written to {arguments.output}")
    if arguments.output == RESULTS:
        refresh(PAGE, {"choice": choice_table(results)})


if __name__ == "__main__":
    main()
