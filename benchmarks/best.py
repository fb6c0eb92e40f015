"""The best body and the best networks of 60 features that the same search finds for each task, and why.

Run ``python benchmarks/best.py``. Bodies begin with those in `benchmarks/results/search.json`, which are scored again
by the measures of today, and are searched further by ``--bodies`` evaluations; networks are searched anew. What was
found is tested on seeds that no search saw. Then it is measured what each task needs of its input's past and what of it
each reservoir holds. Numbers go into `benchmarks/results/search.json`, tables into `docs/best.md` (which `ruff format`
then lays out), the figure into `docs/images`. ``--tables`` only makes tables and figure of the numbers again.
"""

import argparse
import json
import math
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh
from numpy.typing import NDArray
from scipy.linalg import eigh

from stickslip.common.extras import optional_import
from stickslip.common.figures import house_style, MARKERS, OKABE_ITO, PAGE_WIDTH, save_figure
from stickslip.reservoir import Estimate, information_processing_capacity, mean_over_runs, nrmse, predict_held_out
from stickslip.studies.benchmark.probe import probes
from stickslip.studies.search import body_space, echo_state_space, held_out_scores, search
from stickslip.tasks import BodyReservoir, DelayLine, EchoState, MEASURES, Reservoir, TASKS
from stickslip.tasks.task import mean_score

with optional_import():
    from matplotlib import pyplot as plt

FEATURES = 60
CHOSEN = {
    "NARMA-2 uniform NRMSE": "uniform",
    "NARMA-10 uniform NRMSE": "uniform",
    "parity-3 capacity": "bits",
    "memory capacity": "bits",
}
VALIDATION, TESTS, LENGTH = range(1000, 1004), range(15), 4000
NOISE = 1e-3
# Of real numbers the pulse width is the best encoding by far, and of bits there is nothing to choose.
_BODIES = body_space(FEATURES).where(encoding="pulse_width")
# Of real numbers the pulse width is by far the best encoding (docs/encodings.md); of bits there is none to choose.
_WAVES = {
    "ground": "anchored",
    "segments": 30,
    "readings": "deformation, velocity",
    "holds_per_sample": 1,
    "slope": 0.0,
    "static_friction": 0.3,
    "kinetic_share": 0.5,
}
SPACES = {
    "any body": (_BODIES, 80, 0),
    "any body, again": (_BODIES, 60, 1),
    "waves": (_BODIES.where(**_WAVES), 40, 0),
    "crawler": (_BODIES.where(segments=1, ground="ratchet"), 40, 0),
    "echo-state network": (echo_state_space(FEATURES).where(topology="random"), 40, 0),
    "cycle reservoir": (echo_state_space(FEATURES).where(topology="cycle"), 40, 0),
}  # with the points that explore, and the seed
NETWORKS = ("echo-state network", "cycle reservoir")
NAMES = ("body", "crawler", *NETWORKS, "delay line")
FOLDER = Path("runs/best")
RESULTS = Path(__file__).parent / "results" / "search.json"
PAGE = Path(__file__).parents[1] / "docs" / "best.md"
FIGURE = Path(__file__).parents[1] / "docs" / "images" / "best"


def searched(task: str, kind: str, evaluations: int) -> dict[str, Any]:
    """The best of a space for one task: by a search, or as known from an earlier one if nothing better is found."""
    space, exploration, seed = SPACES[kind]
    candidates = []
    known = None if kind in NETWORKS else earlier(task, kind)
    if known is not None:
        reservoir = space.build(known["values"])
        if reservoir is None or repr(reservoir) != known["reservoir"]:
            raise ValueError(f"{RESULTS} must hold values of the {kind} for {task} that build what they were found for")
        scores, _ = held_out_scores(TASKS[task], reservoir, VALIDATION, length=3000)
        candidates.append((float(np.mean(scores)), known["values"], reservoir))
    if evaluations or known is None:
        FOLDER.mkdir(parents=True, exist_ok=True)
        found = search(
            TASKS[task],
            space,
            evaluations=evaluations,
            exploration=exploration,
            seed=seed,
            validation_seeds=VALIDATION,
            file=FOLDER / f"{task} {kind}.json".replace(" ", "_").replace(",", ""),
        )
        candidates.append((found.validation, found.values, found.reservoir))
    best = max if TASKS[task].metric.more_is_better else min
    validation, values, reservoir = best(candidates, key=lambda candidate: candidate[0])
    return {
        "values": values,
        "reservoir": reservoir,
        "evaluations": evaluations,
        "evaluations before": known["evaluations"] + known.get("evaluations before", 0) if known is not None else 0,
        "validation": validation,
    }


def earlier(task: str, kind: str) -> dict[str, Any] | None:
    """What the last run of this script found."""
    if not RESULTS.exists():
        return None
    found = json.loads(RESULTS.read_text(encoding="utf-8"))["tasks"].get(task, {}).get("found", {})
    known: dict[str, Any] | None = found.get(kind)
    return known


def remembering(reservoir: Reservoir) -> Reservoir:
    """The reservoir, driven once by each series."""
    kept: dict[tuple[bytes, int], NDArray[np.float64]] = {}

    def states(series: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
        key = series.tobytes(), seed
        if key not in kept:
            kept[key] = reservoir(series, seed)
        return kept[key]

    return states


def noisy(reservoir: Reservoir) -> Reservoir:
    """The reservoir read with noise of a thousandth of each state's standard deviation."""

    def states(series: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
        exact = reservoir(series, seed)
        return exact + NOISE * exact.std(axis=0) * np.random.default_rng([seed, 7]).standard_normal(exact.shape)

    return states


def curve(task: str, reservoir: Reservoir, counts: Sequence[int]) -> dict[str, list[float]]:
    """Mean scores over three test seeds: fewer of a body's readings, evenly spread, or fewer nodes or taps."""
    most: int = reservoir.features  # type: ignore[attr-defined]
    counts = [*(count for count in counts if count < most), most]
    whole = remembering(reservoir)

    def fewer(features: int) -> Reservoir:
        if isinstance(reservoir, EchoState | DelayLine):
            return replace(reservoir, features=features)
        kept = np.linspace(0, most - 1, features).round().astype(int)
        return lambda series, seed: whole(series, seed)[:, kept]

    scores = [held_out_scores(TASKS[task], fewer(count), range(3), length=LENGTH)[0] for count in counts]
    return {"features": counts, "mean": [float(np.mean(each)) for each in scores]}


def mode_memories(body: BodyReservoir) -> list[float]:
    """Samples in which each swing of an anchored chain falls to 1/e, the slowest swing first, were it linear.

    Stiffness K and damping 2 Pi2 K are proportional, so that a mode of frequency w decays at the rate Pi2 w^2, and one
    that is overdamped at that of its slower part.
    """
    segments, groups = body.scene.segments, body.groups
    lump = body.scene.tube_mass / segments
    mass = np.diag([lump] * (segments - 1) + [lump / 2 + 1 - groups.foot_mass_fraction])
    stretch = np.eye(segments) - np.eye(segments, k=-1)
    squared = np.sort(eigh(segments * stretch.T @ stretch, mass, eigvals_only=True))
    rates = -np.real(-groups.damping_ratio * squared + np.emath.sqrt((groups.damping_ratio * squared) ** 2 - squared))
    return [float(samples) for samples in 1 / (rates * body.hold * body.holds_per_sample)]


Functions = dict[str, list[NDArray[np.float64]]]


def needed(task: str, drive: NDArray[np.float64]) -> Functions:
    """Functions of the input's past that a task is made of, set by set."""
    centred = 2 * drive - 1

    def past(delay: int, degree: int = 1) -> NDArray[np.float64]:
        polynomial = np.polynomial.legendre.Legendre.basis(degree)(centred)
        return np.concatenate([np.zeros(delay), polynomial[: len(polynomial) - delay]])

    def products(delays: range, gap: int) -> list[NDArray[np.float64]]:
        return [past(k) * past(k + gap) for k in delays]

    if task.startswith("NARMA-2 "):
        return {
            "u(t-k), k < 12": [past(k) for k in range(12)],
            "its square, k < 12": [past(k, 2) for k in range(12)],
            "its cube, k < 12": [past(k, 3) for k in range(12)],
            "u(t-k) u(t-k-1), k < 6": products(range(6), 1),
        }
    if task.startswith("NARMA-10"):
        return {
            "u(t-k), k < 10": [past(k) for k in range(10)],
            "u(t-k), 10 ≤ k < 25": [past(k) for k in range(10, 25)],
            "u(t) u(t-9)": products(range(1), 9),
            "u(t-k) u(t-k-9), k = 1, 2": products(range(1, 3), 9),
            "u(t-k) u(t-k-9), 3 ≤ k < 16": products(range(3, 16), 9),
        }
    if task.startswith("parity-3"):
        return {
            f"parity of bits {d} to {d + 2} ago": [past(d) * past(d + 1) * past(d + 2)] for d in (0, 1, 2, 3, 4, 6, 8)
        }
    return {
        f"u(t-k), {low} ≤ k < {high}": [past(k) for k in range(low, high)]
        for low, high in ((0, 10), (10, 20), (20, 30), (30, 40))
    }


def diagnosis(task: str, reservoirs: dict[str, Reservoir], length: int = 8000, washout: int = 400) -> dict[str, Any]:
    """What a task needs, by what is missed without it, and what of it each reservoir holds."""
    problem = TASKS[task].draw(length, TESTS[0])  # type: ignore[attr-defined]
    functions = needed(task, problem.drive)
    known: list[NDArray[np.float64]] = []
    missed = {}
    for name, columns in functions.items():
        known += columns
        prediction, target = predict_held_out(np.column_stack(known)[washout:], problem.targets[washout:])
        missed[name] = nrmse(prediction, target)
    held, degrees = {}, {}
    for name, reservoir in reservoirs.items():
        states = reservoir(problem.drive, TESTS[0])
        held[name] = {}
        for part, columns in functions.items():
            prediction, target = predict_held_out(states[washout:], np.column_stack(columns)[washout:])
            errors = np.mean((prediction - target) ** 2, axis=0) / target.var(axis=0)
            held[name][part] = float(np.maximum(0, 1 - errors).mean())
        basis = "legendre" if CHOSEN[task] == "uniform" else "walsh"
        found = information_processing_capacity(
            states,
            problem.drive,
            basis=basis,
            max_degree=4,
            delays=(60, 30, 12, 8),
            washout=washout,
            budget=20_000,
            support=(0.0, 1.0) if basis == "legendre" else None,
        )
        degrees[name] = {"rank": found.rank, "by_degree": found.by_degree()}
    return {"missed": missed, "held": held, "degrees": degrees}


def measured(task: str, bodies: int, networks: int) -> dict[str, Any]:
    """All about one task; the body is the best by validation of all the searches for bodies."""
    found = {kind: searched(task, kind, networks if kind in NETWORKS else bodies) for kind in SPACES}
    best = max if TASKS[task].metric.more_is_better else min
    winner = best((kind for kind in SPACES if kind not in NETWORKS), key=lambda kind: found[kind]["validation"])
    reservoirs: dict[str, Reservoir] = {
        "body": found[winner]["reservoir"],
        "crawler": found["crawler"]["reservoir"],
        **{kind: found[kind]["reservoir"] for kind in NETWORKS},
        "delay line": DelayLine(FEATURES),
    }
    driven = {name: remembering(each) for name, each in reservoirs.items()}
    tests, with_noise = (
        {
            name: held_out_scores(TASKS[task], read(each), TESTS, validation_seeds=VALIDATION, length=LENGTH)[0]
            for name, each in driven.items()
        }
        for read in (lambda each: each, noisy)
    )
    counts = (6, 12, 20, 30, 40, 60)
    return {
        "input": CHOSEN[task],
        "winner": winner,
        "found": {
            kind: {**each, "reservoir": repr(each["reservoir"]), "features": each["reservoir"].features}
            for kind, each in found.items()
        },
        "probes": probes({name: {**TASKS, **MEASURES}[name] for name in (task, "information capacity")}, {}),
        "tests": tests,
        "with_noise": with_noise,
        "curves": {name: curve(task, each, counts) for name, each in reservoirs.items() if name != "crawler"},
        "diagnosis": diagnosis(task, reservoirs),
        "mode_memories": mode_memories(found["waves"]["reservoir"]),
    }


def cell(estimate: Estimate) -> str:
    if math.isnan(estimate.low):
        return f"{estimate.mean:.2f}"
    half = max(estimate.high - estimate.mean, estimate.mean - estimate.low)
    digits = max(2, min(4, 1 - math.floor(math.log10(half)))) if half > 1e-5 else 2
    return f"{estimate.mean:.{digits}f} [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]"


def tables(tasks: dict[str, dict[str, Any]]) -> dict[str, str]:
    """The tables of the page by name."""
    names = NAMES
    rule = "|---|" + "---:|" * len(names)
    made = {}
    for key in ("tests", "with_noise"):
        lines = [f"| task | {' | '.join(names)} |", rule]
        for task, each in tasks.items():
            scores = (cell(mean_score(TASKS[task], each[key][name], FEATURES)) for name in names)
            lines.append(f"| {task} | {' | '.join(scores)} |")
        made[key] = "\n".join(lines)
    others = names[1:]
    lines = [f"| task | {' | '.join(f'less {name}' for name in others)} |", f"|---|{'---:|' * len(others)}"]
    for task, each in tasks.items():
        ours = np.array(each["tests"]["body"])
        pairs = (cell(mean_over_runs(ours - each["tests"][name], bounds=(-math.inf, math.inf))) for name in others)
        lines.append(f"| {task} | {' | '.join(pairs)} |")
    made["differences"] = "\n".join(lines)
    for task, each in tasks.items():
        # Of a capacity no error is left to tell: its targets are functions of the table themselves.
        left = {
            part: f" {error:.2f} |" if "NRMSE" in task else "" for part, error in each["diagnosis"]["missed"].items()
        }
        column = (" error left |", "---:|") if "NRMSE" in task else ("", "")
        lines = [
            f"| functions of the input's past |{column[0]} {' | '.join(names)} |",
            f"|---|{column[1]}{'---:|' * len(names)}",
        ]
        for part, error in left.items():
            held = " | ".join(f"{each['diagnosis']['held'][name][part]:.2f}" for name in names)
            lines.append(f"| {part} |{error} {held} |")
        made[f"why {task}"] = "\n".join(lines)
    lines = [f"| task | {' | '.join(SPACES)} |", f"|---|{'---:|' * len(SPACES)}"]
    for task, each in tasks.items():
        row = (
            f"{found['validation']:.3f} in {found['evaluations'] + found['evaluations before']}"
            for found in map(each["found"].__getitem__, SPACES)
        )
        lines.append(f"| {task} | {' | '.join(row)} |")
    made["searches"] = "\n".join(lines)
    lines = ["| task | reservoir | rank | degree 1 | 2 | 3 | 4 |", "|---|---|---:|---:|---:|---:|---:|"]
    for task, each in tasks.items():
        for name in names:
            degrees = each["diagnosis"]["degrees"][name]
            shares = [degrees["by_degree"].get(key, degrees["by_degree"].get(str(key), 0.0)) for key in (1, 2, 3, 4)]
            lines.append(f"| {task} | {name} | {degrees['rank']} | {' | '.join(f'{x:.1f}' for x in shares)} |")
    made["degrees"] = "\n".join(lines)
    lines = ["| task | slowest mode | a quarter are slower | median | a quarter are faster |", f"|---|{'---:|' * 4}"]
    for task, each in tasks.items():
        if each["winner"] == "waves":
            samples = np.quantile(each["mode_memories"], (1, 0.75, 0.5, 0.25))
            lines.append(f"| {task} | {' | '.join(f'{value:.1f}' for value in samples)} |")
    made["modes"] = "\n".join(lines)
    blocks = ["from stickslip import Groups, Scene\nfrom stickslip.tasks import BodyReservoir"]
    for task, each in tasks.items():
        body = each["found"][each["winner"]]
        blocks.append(f"# {task}: {body['features']} features\n{body['reservoir']}")
    made["configurations"] = "```python\n" + "\n\n".join(blocks) + "\n```"
    return made


def draw(tasks: dict[str, dict[str, Any]]) -> None:
    """Scores against features, a panel a task."""
    with house_style():
        figure, panels = plt.subplots(-(-len(tasks) // 2), 2, figsize=(PAGE_WIDTH, 4.8), layout="constrained")
        for panel, (task, each) in zip(panels.flat, tasks.items(), strict=True):
            for (name, points), color, marker in zip(each["curves"].items(), OKABE_ITO, MARKERS, strict=False):
                panel.plot(points["features"], points["mean"], marker=marker, ms=3.5, color=color, label=name)
            title, score = task.rsplit(" ", 1)
            panel.set(xlabel="features", ylabel=score)
            panel.set_title(title)
            if score == "NRMSE":
                panel.set(ylim=(0, 1.05))
            else:
                panel.set(ylim=(0, None))
        handles, labels = panels.flat[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    save_figure(figure, *(FIGURE.with_suffix(suffix) for suffix in (".png", ".svg")))


def main() -> None:
    """Search, test, and put the tables into the page."""
    parser = argparse.ArgumentParser(description="The best body and network of 60 features for each task, and why.")
    parser.add_argument("--bodies", type=int, default=0, help="further evaluations of every search for a body")
    parser.add_argument("--networks", type=int, default=150, help="evaluations of every search for a network")
    parser.add_argument("--tables", action="store_true", help="make tables and figure of the numbers as they are")
    arguments = parser.parse_args()
    if not arguments.tables:
        tasks = {}
        for task in CHOSEN:
            tasks[task] = measured(task, arguments.bodies, arguments.networks)
            found = tasks[task]["tests"].items()
            print(task, {name: cell(mean_score(TASKS[task], scores, FEATURES)) for name, scores in found}, flush=True)
        keep(RESULTS, {"machine": machine(), "length": LENGTH, "noise": NOISE, "tasks": tasks})
    results = json.loads(RESULTS.read_text(encoding="utf-8"))
    draw(results["tasks"])
    refresh(PAGE, tables(results["tasks"]))


if __name__ == "__main__":
    main()
