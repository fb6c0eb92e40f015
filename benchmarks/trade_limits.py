"""Distance against memory before anything is learned: open loop, registers, the speed limit, and who fools the reward.

Run ``python benchmarks/trade_limits.py``, or name parts: ``python benchmarks/trade_limits.py limit audit``. Each part
takes some minutes on two cores and is kept in ``results/trade_limits.json`` when it is done; the tables go into
`docs/trade_limits.md`.
"""

import argparse
import json
import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh

import stickslip
from stickslip.envs.settings import Settings
from stickslip.reservoir import Estimate
from stickslip.studies.trade import best_registers, hypervolume, Judgement, open_loop_front, speed_limit
from stickslip.studies.trade.adversaries import Adversary, Audit, audit
from stickslip.studies.trade.attribution import attribute
from stickslip.studies.trade.conditions import conditions
from stickslip.studies.trade.evolution import evolved_feedback
from stickslip.studies.trade.gap import gap, KINDS, kinds_of, mixed_runs
from stickslip.studies.trade.judgement import held_out_seeds, joined, judge
from stickslip.studies.trade.learned_adversary import learned_adversary
from stickslip.studies.trade.open_loop import schedule_runs
from stickslip.studies.trade.registers import register_runs, Registers, tables_of
from stickslip.studies.trade.richest import richest
from stickslip.studies.trade.rollouts import runs_of
from stickslip.train.policies import Policy

RESULTS = Path(__file__).parent / "results" / "trade_limits.json"
PAGE = Path(__file__).parents[1] / "docs" / "trade_limits.md"

DITHERS = (0.0, 0.05, 0.1, 0.25)
RESOLUTIONS = (10, 14, 20, 28, 40)
LOOKAHEADS = (1, 2, 3, 4)
FLOORS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
BLOCKS = (10, 30, 100, 300, 1000)
GENERATIONS, CHILDREN = 25, 1000
HOLDS = 10_000
WINDOW = 2500
WORDS = ("1", "0", "11100111000")
PLACES: tuple[dict[str, Any], ...] = (
    {},
    *({"hold": hold} for hold in (0.3, 0.7, 1.0)),
    *({"dither": dither} for dither in (0.05, 0.25)),
    *({"groups": {"deborah": deborah}} for deborah in (0.1, 0.25, 1.0)),
    *(
        {"groups": {"static_friction": static, "kinetic_friction": kinetic}}
        for static, kinetic in ((0.15, 0.1), (0.6, 0.4), (0.3, 0.1))
    ),
    *({"groups": {"damping_ratio": damping}} for damping in (0.02, 0.15)),
    {"groups": {"duffing": 0.0, "radial_coupling": 0.0}},
    {"groups": {"duffing": 5.0, "radial_coupling": 0.5}},
    *({"groups": {"foot_mass_fraction": fraction}} for fraction in (0.1, 0.6)),
    {"groups": {"deborah": 0.1, "static_friction": 0.15, "kinetic_friction": 0.1}},
    {"hold": 0.7, "dither": 0.25},
    {"hold": 0.7, "groups": {"deborah": 0.1}},
)

Result = dict[str, Any]


def told(estimate: Estimate) -> list[float]:
    return [estimate.mean, estimate.low, estimate.high]


def told_front(front: Judgement) -> list[Result]:
    return [
        {"name": name, "speed": told(front.speed(name)), "memory": told(front.memory(name))} for name in front.names
    ]


def open_loop() -> Result:
    found = open_loop_front()
    return {"tried": len(found.names), "front": told_front(found.front), "hypervolume": told(found.hypervolume)}


def registers() -> Result:
    found = best_registers(4)
    front = told_front(found.front)
    return {
        "tried": len(found.speeds),
        "front": front,
        "hypervolume": told(found.hypervolume),
        "gap": between(found),
        "mixtures": mixtures(front),
    }


def evolution() -> Result:
    tables = [[int(letter) for letter in row["name"]] for row in results_of("registers")["front"]]
    names = ["".join(map(str, table)) for table in tables]
    found = evolved_feedback(begin=names, generations=GENERATIONS, children=CHILDREN)
    settings, seeds = found.settings, found.front.seeds
    registers = judge(names, lambda seed: register_runs(tables, settings.dither, HOLDS, seed), settings, seeds=seeds)
    held = judge(["1"], lambda seed: register_runs([[1, 1]], settings.dither, HOLDS, seed), settings, seeds=seeds)
    planned = judge(["fastest policy"], fastest_runs(settings, seeds), settings, seeds=seeds)
    return {
        "tried": GENERATIONS * CHILDREN,
        "front": told_front(found.front),
        "hypervolume": told(found.hypervolume),
        "tables": ["".join(map(str, table)) for table in found.feedback.tables.tolist()],
        "thresholds": found.feedback.thresholds.tolist(),
        "together": told(joined(joined(found.front, registers), joined(held, planned)).hypervolume()),
    }


def fastest_runs(settings: Settings, seeds: tuple[int, ...]) -> Callable[[int], Any]:
    """Runs of the policy that the speed limit is."""
    planner = speed_limit(settings.dither, seeds=1, holds=200).policy
    return runs_of(lambda _, observations: planner.predict(observations), 1, settings, seeds=seeds, holds=HOLDS)


def between(every: Registers) -> Result:
    """The most memory of registers that rest, walk or do either."""
    found = gap(every, FLOORS)
    counts = np.bincount(kinds_of(tables_of(every.bits)), minlength=len(KINDS)).tolist()
    rows: Result = {}
    for kind, count in zip(KINDS, counts, strict=True):
        best = [
            None if name is None else told_front(found.judgement)[found.judgement.names.index(name)]
            for name in found.chosen[kind]
        ]
        rows[kind] = {"count": count, "best": best}
    return rows


def mixtures(front: list[Result]) -> list[Result]:
    """Of the knee and held open, and of the knee and the fastest register that remembers more than 3.5."""
    knee = max(front, key=lambda row: row["speed"][0] * row["memory"][0])["name"]
    corner = max(front, key=lambda row: row["speed"][0] if row["memory"][0] > 3.5 else 0.0)["name"]
    settings, rows = conditions(), []
    for slow in ("1" * len(knee), corner):
        runs = mixed_runs(slow, knee, BLOCKS, settings, HOLDS)
        mixed = judge(list(map(str, BLOCKS)), runs, settings, seeds=held_out_seeds(10))
        rows += [{"slow": slow, "knee": knee, **row} for row in told_front(mixed)]
    return rows


def limit() -> Result:
    def one(dither: float, **settings: Any) -> Result:
        began = time.process_time()
        found = speed_limit(dither, threads=1, **settings)
        seconds = time.process_time() - began
        speeds = [float(found.speeds[0])] * 3 if dither == 0.0 else told(found.speed)  # without flips seeds are alike
        return {"speed": speeds, "grid": found.grid_speed, "outside": found.outside, "seconds": seconds}

    return {
        "dithers": {f"{dither:g}": one(dither) for dither in DITHERS},
        "resolutions": {str(points): one(0.1, resolution=points) for points in RESOLUTIONS},
        "lookaheads": {str(holds): one(0.1, lookahead=holds) for holds in LOOKAHEADS},
    }


def told_audit(found: Audit) -> Result:
    return {
        name: {
            "earned": float(found.earned[i].mean()),
            "capacity": float(found.capacities[i].mean()),
            "excess": told(found.excess(name)),
        }
        for i, name in enumerate(found.names)
    }


def reward() -> Result:
    return told_audit(audit(holds=WINDOW))


def learned() -> Result:
    """Policies that PPO found for the reward, and one that was searched for the excess itself."""

    def of(policy: Policy) -> Adversary:
        return lambda _: lambda _, observations: policy.predict(observations)

    shipped = {name: stickslip.pretrained(name) for name in ("knee", "memory")}
    of_reward = {f"PPO at weight {each.env_kwargs['memory_weight']:g}": of(each) for each in shipped.values()}
    [valves] = {each.env_kwargs["valve_history"] for each in shipped.values()}
    rows = told_audit(audit(of_reward, holds=WINDOW, valve_history=valves))
    searched = {"learned for the excess": learned_adversary(holds=WINDOW)}
    return rows | told_audit(audit(searched, holds=WINDOW))


def whose() -> Result:
    settings, seeds = conditions(), held_out_seeds(10)

    tables = [[int(letter) for letter in row["name"]] for row in results_of("registers")["front"]]
    names = ["".join(map(str, table)) for table in tables]
    each = {
        WORDS: schedule_runs(WORDS, settings.dither, HOLDS),
        tuple(names): lambda seed: register_runs(tables, settings.dither, HOLDS, seed),
        ("fastest policy",): fastest_runs(settings, seeds),
    }
    rows: Result = {}
    for some, runs in each.items():
        found = attribute(some, runs, settings, seeds=seeds)
        for name in some:
            rows[name] = {
                "speed": told(found.closed.speed(name)),
                "memory": told(found.closed.memory(name)),
                "body": told(found.body(name)),
                "controller": told(found.controller(name)),
            }
    return rows


def places() -> Result:
    rows: Result = {}
    asked = [{"dither": 0.1, "hold": 0.5, **place} for place in PLACES]
    for i, place in richest(asked, processes=2):
        corner = place.open_loop.points
        closed = place.registers.points
        knee = closed[int(np.argmax(closed.prod(axis=1)))]
        rows[str(i)] = {
            "place": asked[i],
            "open loop": hypervolume(corner),
            "gain": told(place.gain),
            "fastest": float(corner[:, 0].max()),
            "most": float(corner[:, 1].max()),
            "knee": knee.tolist(),
        }
        print(rows[str(i)], flush=True)
    return rows


PARTS: Mapping[str, Callable[[], Result]] = {
    "open loop": open_loop,
    "registers": registers,
    "limit": limit,
    "evolution": evolution,
    "audit": reward,
    "learned": learned,
    "attribution": whose,
    "places": places,
}


def results_of(part: str) -> Result:
    kept: Result = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    if part not in kept:
        raise SystemExit(f"the part {part!r} has to be run before: python benchmarks/trade_limits.py '{part}'")
    found: Result = kept[part]
    return found


def interval(estimate: list[float], digits: int) -> str:
    mean, low, high = estimate
    return f"{mean:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def rows_of(heads: list[str], rows: list[list[str]]) -> str:
    lines = [f"| {' | '.join(heads)} |", f"|---|{'---:|' * (len(heads) - 1)}"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def front_table(found: Result, what: str) -> str:
    rows = [[f"`{row['name']}`", interval(row["speed"], 3), interval(row["memory"], 2)] for row in found["front"]]
    rows.append([f"**hypervolume** of {found['tried']} tried", "", interval(found["hypervolume"], 3)])
    return rows_of([what, "speed", "memory"], rows)


def evolution_table(found: Result) -> str:
    rows = [[row["name"], interval(row["speed"], 3), interval(row["memory"], 2)] for row in found["front"]]
    rows.append([f"**hypervolume** of {found['tried']:,} tried", "", interval(found["hypervolume"], 3)])
    rows.append(
        ["**hypervolume** with registers, held open and the fastest policy", "", interval(found["together"], 3)]
    )
    return rows_of(["number", "speed", "memory"], rows)


def gap_table(found: Result) -> str:
    def cell(row: Result | None) -> str:
        return "none" if row is None else f"{row['memory'][0]:.2f} at {row['speed'][0]:.3f}"

    heads = ["speed at least", *(f"{kind} ({rows['count']:,})" for kind, rows in found.items())]
    rows = [[f"{floor:g}", *(cell(each["best"][i]) for each in found.values())] for i, floor in enumerate(FLOORS)]
    return rows_of(heads, rows)


def mixture_table(found: list[Result]) -> str:
    rows = [
        [f"`{row['slow']}` and `{row['knee']}`", row["name"], interval(row["speed"], 3), interval(row["memory"], 2)]
        for row in found
    ]
    return rows_of(["registers", "holds of a block", "speed", "memory"], rows)


def limit_table(found: Result, key: str, what: str) -> str:
    rows = [
        [name, interval(row["speed"], 4), f"{row['grid']:.4f}", f"{100 * row['outside']:.3f}%", f"{row['seconds']:.1f}"]
        for name, row in found[key].items()
    ]
    return rows_of([what, "speed of the policy", "what the grid says", "outside the grid", "seconds"], rows)


def audit_table(found: Result) -> str:
    rows = [
        [name, f"{row['earned']:.2f}", f"{row['capacity']:.2f}", interval(row["excess"], 3)]
        for name, row in found.items()
    ]
    return rows_of(["policy", "earned", "capacity", "excess"], rows)


def attribution_table(found: Result) -> str:
    rows = [
        [
            f"`{name}`" if name[0] in "01" else name,
            f"{row['speed'][0]:.3f}",
            *(interval(row[key], 2) for key in ("memory", "body", "controller")),
        ]
        for name, row in found.items()
    ]
    return rows_of(["policy", "speed", "memory", "of the body", "of the controller"], rows)


def place_table(found: Result) -> str:
    def named(place: Result) -> str:
        values = {"hold": place["hold"], "dither": place["dither"], **place.get("groups", {})}
        default = {"hold": 0.5, "dither": 0.1}
        differs = [f"{name} {value:g}" for name, value in values.items() if default.get(name) != value]
        return ", ".join(differs) or "the defaults"

    rows = [
        [
            named(row["place"]),
            f"{row['gain'][0] * row['open loop']:.2f}",
            interval([100 * share for share in row["gain"]], 0) + "%",
            f"{row['open loop']:.2f}",
            f"({row['knee'][0]:.2f}, {row['knee'][1]:.2f})",
            f"{row['fastest']:.2f}",
            f"{row['most']:.2f}",
        ]
        for row in sorted(found.values(), key=lambda row: -row["gain"][0] * row["open loop"])
    ]
    heads = [
        "place",
        "area added",
        "gain",
        "open-loop hypervolume",
        "knee of registers",
        "fastest word",
        "most memory of a word",
    ]
    return rows_of(heads, rows)


def tables(found: Result) -> dict[str, str]:
    """Tables of the page, of the parts that are there."""
    made: dict[str, Callable[[], str]] = {
        "open loop": lambda: front_table(found["open loop"], "schedule"),
        "registers": lambda: front_table(found["registers"], "register"),
        "limit": lambda: limit_table(found["limit"], "dithers", "dither"),
        "resolutions": lambda: limit_table(found["limit"], "resolutions", "resolution"),
        "lookaheads": lambda: limit_table(found["limit"], "lookaheads", "lookahead"),
        "evolution": lambda: evolution_table(found["evolution"]),
        "gap": lambda: gap_table(found["registers"]["gap"]),
        "mixtures": lambda: mixture_table(found["registers"]["mixtures"]),
        "audit": lambda: audit_table({**found["audit"], **found.get("learned", {})}),
        "attribution": lambda: attribution_table(found["attribution"]),
        "places": lambda: place_table(found["places"]),
    }
    part = {"resolutions": "limit", "lookaheads": "limit", "gap": "registers", "mixtures": "registers"}
    return {name: make() for name, make in made.items() if part.get(name, name) in found}


def main() -> None:
    """Run the parts, keep each, and write the tables into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], help="all by default")
    for part in parser.parse_args().parts or PARTS:
        began = time.perf_counter()
        found = PARTS[part]()
        print(f"{part}: {time.perf_counter() - began:.0f} s")
        kept = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
        keep(RESULTS, {**kept, part: found, "machine": machine("scipy")})
        made = tables({**kept, part: found})
        print("\n\n".join(made.values()))
        refresh(PAGE, made)


if __name__ == "__main__":
    main()
