"""Quick fronts of speed against other reservoir tasks than memory, and what their policies do.

Run ``python benchmarks/front_targets.py``. The cells of each target are kept in ``runs/front_targets`` as they end, and
a run that was stopped goes on where it stopped. What they came to is then kept in
``benchmarks/results/front_targets.json``, and the tables are written into ``docs/trade.md`` between their marks.
"""

import argparse
import json
import os
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh

from stickslip.envs import StickSlipCrawlerEnv
from stickslip.reservoir import Estimate
from stickslip.studies.benchmark.report import as_markdown, cell
from stickslip.studies.trade.cells import conditions_of
from stickslip.studies.trade.front import area, estimated, Front, fronts, gain, Point
from stickslip.studies.trade.judgement import held_out_seeds, judge
from stickslip.studies.trade.plan import QUICK, Trade, TRAINED
from stickslip.studies.trade.portrait import imitation, portrait
from stickslip.studies.trade.registers import register_runs
from stickslip.studies.trade.running import TradeFolder
from stickslip.train.policies import Policy

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "front_targets.json"
PAGE = ROOT / "docs" / "trade.md"

EVERY: dict[str, Any] = {
    **QUICK,
    "weights": (0.0, 0.2, 0.5, 0.9, 1.0),
    "dithers": (0.25,),
    "conditioned": False,
    "judges": 8,
    "holds": 6000,
}
# Short episodes overpay products at longer delays and rarer flips: see docs/reward.md.
TARGETS: dict[str, dict[str, Any]] = {
    "parity": {"hold": 0.5, "target": "parity", "target_order": 2, "delays": 4},
    "narma": {"hold": 0.5, "target": "narma", "target_order": 2},
}
UNDISTURBED = 600  # holds without flips, of which the last third is looked at
LONGEST_PERIOD = 32
LONGEST_REGISTER = 4  # bits, as many valve states as the policies see
AS_GOOD = 0.005  # of agreement: a register of fewer bits is then taken


def trade_for(target: str) -> Trade:
    """What is asked for one target."""
    return Trade(**EVERY, env_kwargs=TARGETS[target])


def undisturbed(policy: Policy) -> list[int]:
    """What a policy commands where no command is flipped, once it is under way."""
    environment = StickSlipCrawlerEnv(**{**policy.env_kwargs, "dither": 0.0, "memory_weight": 0.0})
    observation, _ = environment.reset(seed=0)
    commands = []
    for _ in range(UNDISTURBED):
        command = int(policy.predict(observation))
        observation, *_ = environment.step(command)
        commands.append(command)
    return commands[-UNDISTURBED // 3 :]


def in_words(commands: list[int]) -> str:
    """Valve held, or the word that is repeated, from its longest run of open on; or that there is none."""
    row = np.array(commands)
    for period in range(1, LONGEST_PERIOD + 1):
        if (row[period:] == row[:-period]).all():
            word = "".join(map(str, row[:period]))
            turned = max(word[k:] + word[:k] for k in range(period))
            return {"1": "held open", "0": "held shut"}.get(turned, turned)
    return "no period"


def played(policy: Policy) -> dict[str, Any]:
    """What a policy does without flips, how often it opens the valve with them, and which register does the same."""
    seen = portrait(policy)
    registers = {bits: imitation(seen, bits) for bits in range(LONGEST_REGISTER + 1)}
    best = max(each.agreement for each in registers.values())
    bits = next(bits for bits, each in registers.items() if each.agreement >= best - AS_GOOD)
    table, settings = registers[bits].table, conditions_of(policy)
    alone = judge(
        ["register"],
        lambda seed: register_runs([table], settings.dither, EVERY["holds"], seed),
        settings,
        seeds=held_out_seeds(EVERY["judges"]),
    )
    return {
        "without flips": in_words(undisturbed(policy)),
        "open": float(seen.commands.mean()),
        "register": "".join(map(str, table)),
        "agreement": registers[bits].agreement,
        "speeds": alone.speeds[0].tolist(),
        "memories": alone.memories[0].tolist(),
    }


def tables(results: dict[str, Any]) -> dict[str, str]:
    """The page's tables, by their marks."""
    made = {}
    for target, kept in results["targets"].items():
        front = front_of(target, kept)
        made[f"{target} points"] = as_markdown(points(front))
        made[f"{target} played"] = as_markdown(doings(front, kept["played"]))
    made["target areas"] = as_markdown(areas({name: front_of(name, kept) for name, kept in results["targets"].items()}))
    return made


def front_of(target: str, kept: dict[str, Any]) -> Front:
    """The front of what is kept of a target."""
    trade = trade_for(target)
    [front] = fronts(trade, {each: kept["cells"][each.name] for stage in trade.cells() for each in stage})
    return front


def points(front: Front) -> list[list[str]]:
    """Best schedules and every policy, under a row of headings."""
    told = [["", "weight", "speed", "capacity", "of the body", "reward above the best schedule"]]
    fastest = max(front.open_loop, key=lambda point: point.mean[0])
    richest = max(front.open_loop, key=lambda point: point.mean[1])
    rows: list[tuple[str, Point]] = [(f"fastest word, {fastest.name}", fastest)]
    rows += [(f"word of most capacity, {richest.name}", richest)]
    rows += [(point.kind, point) for point in front.held]
    rows += [("policy", point) for point in front.chosen]
    for name, point in rows:
        told.append(
            [
                name,
                "" if point.weight is None else f"{point.weight:g}",
                cell(estimated(point.speeds), 3),
                cell(estimated(point.memories), 3),
                "" if point.body_memories is None else cell(estimated(point.body_memories), 3),
                "" if point.weight is None else cell(front.lead(point), 3, "+"),
            ]
        )
    return told


def doings(front: Front, kept: dict[str, Any]) -> list[list[str]]:
    """What every policy does, under a row of headings."""
    told = [
        [
            "weight",
            "without flips",
            "commands open",
            "register",
            "commands as the policy's",
            "its speed",
            "its capacity",
        ]
    ]
    for point in front.chosen:
        each = kept[point.name]
        told.append(
            [
                f"{point.weight:g}",
                each["without flips"],
                f"{each['open']:.0%}",
                each["register"],
                f"{each['agreement']:.1%}",
                *(cell(estimated(np.array(each[values])), 3) for values in ("speeds", "memories")),
            ]
        )
    return told


def areas(found: dict[str, Front]) -> list[list[str]]:
    """Hypervolumes of every target, under a row of headings."""
    told = [["target", "open loop, hypervolume from (0, 0)", "policies", "% above"]]
    for name, front in found.items():
        more = gain(front.chosen, front.open_loop)
        percent = Estimate(100 * more.mean, 100 * more.low, 100 * more.high, more.runs)
        told.append([name, cell(area(front.open_loop), 3), cell(area(front.chosen), 3), cell(percent, 0, "+")])
    return told


def main() -> None:
    """Do what is left, and write it down."""
    parser = argparse.ArgumentParser(description="Fronts of speed against other tasks than memory.")
    parser.add_argument("--folder", type=Path, default=ROOT / "runs" / "front_targets")
    parser.add_argument("--processes", type=int, default=1)
    chosen = parser.parse_args()
    kept: dict[str, Any] = {}
    for target in TARGETS:
        folder = TradeFolder(chosen.folder / target, trade_for(target))
        for finished in folder.run(processes=chosen.processes):
            told = "" if finished.cell is None else finished.cell.name
            print(f"{target}: {finished.done}/{finished.of} {told}", flush=True)
        found = folder.results()
        trained = [each for each in found if each.kind == TRAINED]
        kept[target] = {
            "cells": {each.name: result for each, result in found.items()},
            "played": {each.name: played(folder.policy(each)) for each in trained},
        }
    keep(RESULTS, {"machine": machine("torch", "stable-baselines3"), "targets": kept})
    refresh(PAGE, tables(json.loads(RESULTS.read_text(encoding="utf-8"))))


if __name__ == "__main__":
    main()
