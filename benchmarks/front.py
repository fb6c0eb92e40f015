"""The front of speed against memory, in full: `stickslip trade` at four dithers, and the page that tells of it.

Run ``python benchmarks/front.py``: three trainings of each kind at the dither that is shown, two at some weights at the
others. The cells are kept in ``runs/front`` as they end, and a run that was stopped goes on where it stopped;
``--dask ADDRESS`` has a cluster do the work. ``--weights``, ``--dithers`` and ``--seeds`` take a part of it, which a
later run adds to; ``--quick`` makes the front of ``stickslip trade --quick`` instead. What they came to is then kept in
``benchmarks/results/front.json``, the tables are written into ``docs/trade.md`` and the README between their marks, and
the figures are drawn into ``docs/images``. The points go into ``explore/front.json`` too, which the package ships for
``stickslip explore``; ``--ship`` writes nothing but that, from what is kept, and ``--draw`` only draws the front.
"""

import argparse
import json
import os
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh

from stickslip.common.figures import save_figure
from stickslip.common.sharing import processors
from stickslip.reservoir import Estimate
from stickslip.studies.benchmark.report import as_markdown, cell
from stickslip.studies.trade.figure import plot_front
from stickslip.studies.trade.front import estimated, Front, fronts, gain, Point
from stickslip.studies.trade.learned import Learned, learned
from stickslip.studies.trade.plan import FULL, QUICK, Trade
from stickslip.studies.trade.report import areas, figure_of, table, write_report
from stickslip.studies.trade.running import TradeFolder

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "front.json"
PAGE = ROOT / "docs" / "trade.md"
IMAGES = ROOT / "docs" / "images"
SHIPPED = ROOT / "explore" / "front.json"
SHOWN = 0.1
_PLANE = ("speed", "memory")
ASKED: dict[str, Any] = {**FULL, "env_kwargs": {"hold": 0.5}}
DITHERS = (0.0, 0.05, SHOWN, 0.25)
ELSEWHERE: dict[str, Any] = {
    "weights": (0.0, 0.2, 0.3, 0.4),
    "floors": (),
    "seeds": 2,
    "conditioned": False,
}
"""What is asked for at the other dithers instead."""


def made_of(results: dict[str, Any]) -> list[Front]:
    """The fronts of what is kept, one a dither."""
    trades = [Trade(**asked) for asked in results["asked"]]
    return [
        front
        for trade in trades
        for front in fronts(trade, {cell: results["cells"][cell.name] for stage in trade.cells() for cell in stage})
    ]


def tables(results: dict[str, Any]) -> dict[str, str]:
    """The page's tables, by their marks."""
    found = made_of(results)
    [shown] = [front for front in found if front.dither == SHOWN]
    return {
        "asked": asked_in_words(next(Trade(**asked) for asked in results["asked"] if SHOWN in asked["dithers"])),
        "areas": as_markdown(areas(shown)),
        "points": as_markdown(table(shown)),
        "dithers": as_markdown(of_dithers(found)),
        "registers": as_markdown(registers(results["registers"])),
    }


def asked_in_words(trade: Trade) -> str:
    """What everything is judged on."""
    of_each = "a weight and above each floor" if trade.floors else "a weight"
    trainings = (
        f"there is one training {of_each}" if trade.seeds == 1 else f"there are {trade.seeds} trainings {of_each}"
    )
    return (
        f"All are means over {trade.judges} seeds that no training, search or choice has seen, runs of {trade.holds}"
        f" holds each, with 95% intervals. Words have up to {trade.longest} bits; {trainings}."
    )


def of_dithers(found: list[Front]) -> list[list[str]]:
    """Speeds and areas at every dither, under a row of headings."""
    told = [
        ["dither", "speed limit", "fastest policy", "% of the limit", "open loop, area", "policies, % above", "knee"]
    ]
    for front in found:
        fastest, knee = front.fastest, front.knee
        assert fastest is not None
        noisy = front.dither > 0
        told.append(
            [
                f"{front.dither:g}",
                cell(front.speed_limit, 3),
                cell(estimated(fastest.speeds), 3),
                f"{100 * fastest.mean[0] / front.speed_limit.mean:.1f}",
                areas(front)[1][1] if noisy else "",
                cell(_percent(gain(front.chosen, front.open_loop)), 0, "+") if noisy else "",
                "" if knee is None else f"({knee.mean[0]:.2f}, {knee.mean[1]:.2f})",
            ]
        )
    return told


def registers(kept: dict[str, Any]) -> list[list[str]]:
    """The registers that imitate the policies, under a row of headings."""
    told = [["policy", "register's bits", "command after each past", "commands as the policy's", "speed", "memory"]]
    for name, each in kept.items():
        speeds, memories = (cell(estimated(np.array(each[values])), 3) for values in ("speeds", "memories"))
        told.append([name, str(each["bits"]), each["table"], f"{each['agreement']:.1%}", speeds, memories])
    return told


def summary(front: Front) -> list[list[str]]:
    """What drives the valve, in five rows under a row of headings."""
    words = front.open_loop
    knee, fastest = front.knee, front.fastest
    assert knee is not None
    assert fastest is not None
    quickest = max(words, key=lambda point: point.mean[0])
    [held] = [point for point in front.held if point.kind == "held open"]
    rows: list[tuple[str, Point]] = [
        (f"fastest open-loop word, {quickest.name}", quickest),
        ("valve held open", held),
        ("fastest policy", fastest),
        (f"policy of the knee, {_trained_for(knee)}", knee),
    ]
    told = [[f"what drives the valve, dither {front.dither:g}", "speed (z_c/t_c)", "memory capacity"]]
    told += [[name, cell(estimated(point.speeds), 3), cell(estimated(point.memories))] for name, point in rows]
    return [*told, ["the limit of speed, by dynamic programming", cell(front.speed_limit, 3), ""]]


def shipped(found: list[Front]) -> dict[str, Any]:
    """The points of the fronts with a memory, as `stickslip.explore` ships them: means to four digits."""

    def told(points: Sequence[Point]) -> list[dict[str, Any]]:
        return [
            {"name": point.name, **{name: round(value, 4) for name, value in zip(_PLANE, point.mean, strict=True)}}
            for point in points
        ]

    return {
        "written by": "python benchmarks/front.py --ship",
        "fronts": [
            {
                "dither": front.dither,
                "open loop": told(front.open_loop),
                "held": told(front.held),
                "policies": told(front.chosen),
                "conditioned": told(sorted(front.conditioned, key=lambda point: point.weight or 0.0)),
                "limit": round(front.speed_limit.mean, 4),
            }
            for front in found
            if front.dither > 0.0
        ],
    }


def main() -> None:
    """Do what is left of the trade, and write it down."""
    parser = argparse.ArgumentParser(description="The front of speed against memory.")
    parser.add_argument("--folder", type=Path, default=ROOT / "runs" / "front")
    parser.add_argument("--dask", default=None, help="address of a Dask scheduler")
    parser.add_argument("--processes", type=int, default=processors())
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--weights", type=float, nargs="+")
    parser.add_argument("--dithers", type=float, nargs="+")
    parser.add_argument("--seeds", type=int)
    parser.add_argument("--ship", action="store_true", help="only write what the package ships, from what is kept")
    parser.add_argument("--draw", action="store_true", help="only draw the front anew, from what is kept")
    chosen = parser.parse_args()
    if chosen.draw:
        kept = made_of(json.loads(RESULTS.read_text(encoding="utf-8")))
        save_figure(plot_front(next(front for front in kept if front.dither == SHOWN)), IMAGES / "front.png")
        return
    if chosen.ship:
        _ship()
        return
    asked = {**ASKED, **(QUICK if chosen.quick else {})}
    said = {name: getattr(chosen, name) for name in ("weights", "seeds") if getattr(chosen, name) is not None}
    every = []
    cells: dict[str, Any] = {}
    for dither in chosen.dithers or DITHERS:
        every.append({**asked, **({} if dither == SHOWN else ELSEWHERE), **said, "dithers": (dither,)})
        trade = Trade(**every[-1])
        folder = TradeFolder(chosen.folder, trade)
        for finished in folder.run(processes=chosen.processes, dask=chosen.dask):
            print(f"{finished.done}/{finished.of}", "" if finished.cell is None else finished.cell.name, flush=True)
        found = folder.results()
        cells |= {cell.name: result for cell, result in found.items()}
        if dither == SHOWN:
            write_report(folder, fronts(trade, found))
            [shown] = fronts(trade, found)
            imitating = _imitating(learned(folder, shown))
    keep(
        RESULTS,
        {
            "machine": machine("torch", "stable-baselines3"),
            "asked": every,
            "cells": cells,
            "registers": imitating,
        },
    )
    _ship()
    refresh(PAGE, tables(json.loads(RESULTS.read_text(encoding="utf-8"))))
    refresh(ROOT / "README.md", {"front": as_markdown(summary(shown))})
    for name in ("front", "learned"):
        shutil.copy(chosen.folder / figure_of(shown, name), IMAGES / f"{name}.png")


def _ship() -> None:
    keep(SHIPPED, shipped(made_of(json.loads(RESULTS.read_text(encoding="utf-8")))))


def _trained_for(point: Point) -> str:
    return f"memory_weight {point.weight:g}" if point.floor is None else f"a floor of {point.floor:g} on speed"


def _imitating(seen: Learned | None) -> dict[str, Any]:
    assert seen is not None
    return {
        name: {
            "bits": bits,
            "table": register.name,
            "agreement": seen.imitations[name][bits].agreement,
            "speeds": register.speeds.tolist(),
            "memories": register.memories.tolist(),
        }
        for name, (bits, register) in seen.registers.items()
    }


def _percent(share: Estimate) -> Estimate:
    return Estimate(100 * share.mean, 100 * share.low, 100 * share.high, share.runs)


if __name__ == "__main__":
    main()
