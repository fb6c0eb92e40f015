"""Whether memory lives at the edge of chaos: maps, a line through the edge, chaos on the ground, and verdicts.

Run ``python benchmarks/edge.py``; ``--quick`` takes less than three minutes. Maps are kept in ``runs/edge`` and gone on
with. Numbers go into `benchmarks/results/edge.json`, tables and verdicts into `docs/edge.md`, figures into
`docs/images`; a quick run prints them and leaves the page alone.
"""

import argparse
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_lyapunov
from scipy.stats import binomtest

from stickslip import lyapunov_spectrum, memory_capacity, parameter_map, simulate
from stickslip.common.extras import optional_import
from stickslip.common.figures import save_figure
from stickslip.common.sharing import processors
from stickslip.crawler import Groups, State
from stickslip.reservoir import Estimate, mean_over_runs
from stickslip.studies.maps.edge import Best, best_cell, chaotic, difference, edge_cells, rank_correlation
from stickslip.studies.maps.figures import crossings, plot_map
from stickslip.tasks import body_states, dithered, innovation

with optional_import():
    import xarray as xr

RESULTS = Path(__file__).parent / "results" / "edge.json"
PAGE = Path(__file__).parents[1] / "docs" / "edge.md"
IMAGES = Path(__file__).parents[1] / "docs" / "images"
DUFFING = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
DEBORAH = (0.05, 8.0)
PLACES = {"anchored": {"anchored": True}, "ground": {}}
CHAIN = {"segments": 3, "tube_mass": 0.3}
READ = {"raw": 1, "4 nodes": 4}
LONG = "anchored", 0.5, 0.02  # where a linear body remembers beyond 20 delays


@dataclass(frozen=True)
class Size:
    """How much of everything."""

    name: str
    columns: int  # every so manieth of DUFFING
    rows: int
    seeds: int
    holds: int
    line: int
    line_holds: int
    ground: int
    chain: int
    words: int
    long_holds: int
    long_delays: int


FULL = Size("full", 1, 7, 8, 2000, 33, 4000, 7, 5, 300, 8000, 150)
QUICK = Size("quick", 3, 5, 4, 1500, 13, 2000, 5, 3, 60, 3000, 60)


class Study:
    """The maps of a study, each kept in a folder."""

    def __init__(self, size: Size, folder: Path, processes: int) -> None:
        self.size, self._folder, self._processes = size, folder / size.name, processes

    def map(self, name: str, x: Any, y: Any = None, **asked: Any) -> xr.Dataset:
        """A map of that name, made or gone on with."""
        print(f"{name} ...", flush=True)
        return parameter_map(
            x,
            y,
            store=self._folder / f"{name.replace(' ', '_')}.zarr",
            processes=self._processes,
            **{"seeds": self.size.seeds, "holds": self.size.holds, "inputs": "bits", **asked},
        )


def name_of(place: str, hold: float, damping: float, read: str) -> str:
    return f"{place}, hold {hold:g}, Π₂ {damping:g}, {read}"


def maps_of_all(study: Study) -> dict[str, xr.Dataset]:
    """Memory, parity and exponents over Π₁ and Π₄, by scene, hold, damping and what is read."""
    x = ("duffing", DUFFING[:: study.size.columns])
    y = ("deborah", np.geomspace(*DEBORAH, study.size.rows))
    found = {}
    for place, scene in PLACES.items():
        for hold in (0.5, 2.0):
            for damping in (0.02, 0.05):
                common = {"scene": scene, "hold": hold, "groups": {"damping_ratio": damping}}
                exponents = study.map(
                    f"{place} {hold} {damping} exponents",
                    x,
                    y,
                    measures=["lyapunov", "start", "work"],
                    virtual_nodes=1,
                    **common,
                )
                for read, nodes in READ.items():
                    own = study.map(
                        f"{place} {hold} {damping} {read}",
                        x,
                        y,
                        measures=["memory", "parity"],
                        virtual_nodes=nodes,
                        **common,
                    )
                    found[name_of(place, hold, damping, read)] = own.merge(exponents.drop_vars("status"))
                if (place, hold, damping) == LONG:
                    delays = study.size.long_delays
                    asked = {"delays": delays, "holds": study.size.long_holds, **common}
                    own = study.map(f"long {place}", x, y, measures=["memory", "parity"], virtual_nodes=1, **asked)
                    name = f"{name_of(place, hold, damping, 'raw')}, {delays} delays"
                    found[name] = own.merge(exponents.drop_vars("status"))
    return found


def said(estimate: Estimate, digits: int = 2) -> str:
    if not np.isfinite(estimate.low):
        return f"{estimate.mean:.{digits}f}"
    return f"{estimate.mean:.{digits}f} [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]"


def at(found: xr.Dataset, best: Best) -> str:
    dims = found["status"].dims
    values = [float(found[dim][place]) for dim, place in zip(dims, best.cell, strict=True)]
    signs = {"duffing": "Π₁", "deborah": "Π₄"}
    return ", ".join(f"{signs[str(dim)]} {value:.3g}" for dim, value in reversed(list(zip(dims, values, strict=True))))


def exponent_at(found: xr.Dataset, cell: tuple[int, ...]) -> Estimate:
    return mean_over_runs(found.lyapunov.values[cell])


def where_memory_is_largest(maps: Mapping[str, xr.Dataset]) -> tuple[list[list[str]], dict[str, Any]]:
    """A row a map: the cell of most memory and its exponent, the best cell at the edge, and how much they differ."""
    rows, told = (
        [["map", "chaotic cells", "most memory", "at", "exponent there", "best at the edge", "at", "most less edge"]],
        {},
    )
    for name, found in maps.items():
        exponents, memory = found.lyapunov.values, found.memory.values
        best, edge = best_cell(memory), best_cell(memory, edge_cells(exponents.mean(axis=-1)))
        assert best is not None
        share = chaotic(exponents)
        row = [
            name,
            f"{share.sum()} of {share.size}",
            said(best.estimate),
            at(found, best),
            said(exponent_at(found, best.cell), 3),
        ]
        told[name] = {"chaotic": int(share.sum()), "cells": share.size, "most": numbers(best.estimate)}
        told[name] |= {"at": at(found, best), "exponent": numbers(exponent_at(found, best.cell))}
        if edge is None:
            row += ["no edge", "", ""]
        else:
            more = difference(best, edge)
            row += [said(edge.estimate), at(found, edge), said(more)]
            told[name] |= {"edge": numbers(edge.estimate), "more": numbers(more)}
        rows.append(row)
    return rows, told


def over_all_cells(maps: Mapping[str, xr.Dataset]) -> tuple[list[list[str]], dict[str, Any]]:
    """Rank correlations of capacities with the exponent and with its distance from 0, over the cells of a map."""
    rows, told = [["map", "capacity", "most", "exponent there", "best at the edge", "with λ", "with −abs(λ)"]], {}
    for name, found in maps.items():
        exponent = found.lyapunov.mean("seed").values
        edge = edge_cells(exponent)
        for capacity in ("memory", "parity_2", "parity_3"):
            values = found[capacity].values
            best, beside = best_cell(values), best_cell(values, edge)
            assert best is not None
            mean = values.mean(axis=-1)
            both = rank_correlation(mean, exponent), rank_correlation(mean, -np.abs(exponent))
            there = f"{float(exponent[best.cell]):.3f}"
            rows.append(
                [
                    name,
                    capacity.replace("_", " of "),
                    said(best.estimate),
                    there,
                    "" if beside is None else said(beside.estimate),
                    *(f"{each:.2f}" for each in both),
                ]
            )
            told[f"{name}: {capacity}"] = {
                "with exponent": both[0],
                "with closeness": both[1],
                "most": best.estimate.mean,
                "exponent": float(exponent[best.cell]),
                "edge": None if beside is None else beside.estimate.mean,
            }
    return rows, told


LINES = {"hold 0.5, Π₂ 0.02": (0.5, 0.02), "hold 2, Π₂ 0.05": (2.0, 0.05)}


def lines_through_the_edge(study: Study) -> tuple[dict[str, xr.Dataset], list[list[str]], dict[str, Any]]:
    """Anchored, along Π₁, at a lag of the fluid at which the exponent changes its sign: capacities by degree."""
    x = ("duffing", np.geomspace(0.1, 100.0, study.size.line))
    lines: dict[str, xr.Dataset] = {}
    told: dict[str, Any] = {}
    heading = [
        "line, read",
        "capacity",
        "largest at Π₁ (over seeds)",
        "λ there",
        "most",
        "beside λ = 0",
        "most less edge",
    ]
    rows = [heading]
    for line, (hold, damping) in LINES.items():
        groups = {"damping_ratio": damping, "deborah": 0.5}
        common = {"scene": PLACES["anchored"], "hold": hold, "groups": groups, "holds": study.size.line_holds}
        exponents = study.map(f"line {hold} exponents", x, measures=["lyapunov", "work"], virtual_nodes=1, **common)
        mean = exponents.lyapunov.mean("seed").values
        edge = edge_cells(mean)
        told[line] = {"crossings": crossings(x[1], mean)}
        for read, nodes in READ.items():
            measures = ["memory", "parity", "capacity"]
            own = study.map(f"line {hold} {read}", x, measures=measures, virtual_nodes=nodes, **common)
            lines[f"{line}, {read}"] = found = own.merge(exponents.drop_vars("status"))
            series = {name: found[name].values for name in ("memory", "parity_2", "parity_3")}
            for degree in (1, 2, 3):
                series[f"degree {degree}"] = found.capacity.sel(degree=degree).transpose("duffing", "seed").values
            for name, values in series.items():
                best, beside = best_cell(values), best_cell(values, edge)
                assert best is not None
                places = found.duffing.values[values.argmax(axis=0)]
                row = [f"{line}, {read}", name.replace("_", " of ")]
                row += [f"{np.median(places):.2g} ({places.min():.2g} to {places.max():.2g})"]
                row += [said(exponent_at(found, best.cell), 3), said(best.estimate)]
                more = None if beside is None else difference(best, beside)
                row += ["", ""] if beside is None or more is None else [said(beside.estimate), said(more)]
                rows.append(row)
                told[f"{line}, {read}: {name}"] = {
                    "at": float(np.median(places)),
                    "exponent": float(mean[best.cell]),
                    "most": numbers(best.estimate),
                    "edge": None if beside is None else numbers(beside.estimate),
                    "more": None if more is None else numbers(more),
                }
    return lines, rows, told


def numbers(estimate: Estimate) -> list[float]:
    return [estimate.mean, estimate.low, estimate.high]


def chaos_on_the_ground(study: Study) -> tuple[list[list[str]], dict[str, Any]]:
    """Low damping and strong stiffening under fair bits."""
    x = ("duffing", np.geomspace(100.0, 2000.0, study.size.ground))
    y = ("deborah", np.geomspace(*DEBORAH, study.size.rows))
    common = {"groups": {"damping_ratio": 0.002}, "hold": 0.5}
    exponents = study.map("low damping exponents", x, y, measures=["lyapunov", "start"], virtual_nodes=1, **common)
    rows, told = (
        [
            [
                "read",
                "chaotic cells",
                "largest λ",
                "most memory",
                "at",
                "λ there",
                "most of a chaotic cell",
                "most less chaotic",
            ]
        ],
        {},
    )
    for read, nodes in READ.items():
        found = study.map(f"low damping {read}", x, y, measures=["memory", "parity"], virtual_nodes=nodes, **common)
        found = found.merge(exponents.drop_vars("status"))
        where = chaotic(found.lyapunov.values)
        best, inside = best_cell(found.memory.values), best_cell(found.memory.values, where)
        top = best_cell(found.lyapunov.values, least=None)
        assert best is not None
        assert top is not None
        row = [
            read,
            f"{where.sum()} of {where.size}",
            said(top.estimate, 3),
            said(best.estimate),
            at(found, best),
            said(exponent_at(found, best.cell), 3),
        ]
        row += ["", ""] if inside is None else [said(inside.estimate), said(difference(best, inside))]
        rows.append(row)
        told[read] = {"chaotic": int(where.sum()), "cells": where.size, "largest": top.estimate.mean}
    return rows, told


def chaotic_words(study: Study) -> tuple[list[list[str]], dict[str, Any]]:
    """Short periodic words on the ground, bodies at random, friction as ever: how many move chaotically."""
    random = np.random.default_rng(0)
    tries, holds, washout = study.size.words, study.size.holds, study.size.holds // 2
    bodies = [
        Groups(
            duffing=float(random.uniform(0.0, 200.0)),
            deborah=float(np.exp(random.uniform(*np.log(DEBORAH)))),
            damping_ratio=float(random.choice([0.02, 0.05])),
        )
        for _ in range(tries)
    ]
    lengths = np.exp(random.uniform(np.log(0.5), np.log(4.0), tries))
    words = ["".join(map(str, random.integers(0, 2, random.integers(2, 9)))) for _ in range(tries)]
    commands = np.array([np.resize([int(bit) for bit in word], holds) for word in words])
    found = lyapunov_spectrum(bodies, commands, lengths, washout=washout, tolerance=1e-7)
    first, error = found.exponents[:, 0], found.standard_error[:, 0]
    where = np.flatnonzero((first > 3.0 * error) & (first > 1e-3))
    low, high = binomtest(len(where), tries).proportion_ci(method="wilson")
    flipped = np.array([dithered(command, 0.1, 0) for command in commands])
    under_flips = lyapunov_spectrum(bodies, flipped, lengths, washout=washout, tolerance=1e-6).exponents[:, 0]
    states = body_states(simulate(bodies, flipped, lengths, tolerance=1e-6, samples_per_hold=4))
    each = zip(states, flipped, commands, strict=True)
    memory = np.array([memory_capacity(x, innovation(valve, command, 0.1), 20).corrected for x, valve, command in each])
    rows = [["word", "hold", "Π₁", "Π₂", "Π₄", "λ", "λ under flips", "memory of the flips"]]
    for i in sorted(where.tolist(), key=lambda i: -first[i])[:8]:
        body = bodies[i]
        row = [words[i], f"{lengths[i]:.2f}", f"{body.duffing:.0f}", f"{body.damping_ratio:g}", f"{body.deborah:.2f}"]
        rows.append([*row, f"{first[i]:.3f} ± {error[i]:.3f}", f"{under_flips[i]:.3f}", f"{memory[i]:.2f}"])
    calm = np.setdiff1d(np.arange(tries), where)
    rows.append(
        [
            f"median of the {len(calm)} that are not chaotic",
            "",
            "",
            "",
            "",
            f"{np.median(first[calm]):.3f}",
            f"{np.median(under_flips[calm]):.3f}",
            f"{np.median(memory[calm]):.2f}",
        ]
    )
    told = {"tries": tries, "chaotic": len(where), "share": [len(where) / tries, low, high]}
    told |= {
        "largest": float(first.max()),
        "memory of chaotic": median_of(memory[where]),
        "memory of others": median_of(memory[calm]),
    }
    told |= {"chaotic under flips": int((under_flips[where] > 0.0).sum())}
    return rows, told


def median_of(values: NDArray[np.float64]) -> float | None:
    return float(np.median(values)) if len(values) else None


def chains(study: Study) -> tuple[list[list[str]], dict[str, Any]]:
    """A chain of three segments, whose edge is where two starts no longer come together."""
    x = ("duffing", np.array([0.0, 2.0, 20.0, 80.0, 200.0])[:: 1 if study.size.chain > 3 else 2])
    y = ("deborah", np.geomspace(*DEBORAH, study.size.chain))
    rows, told = (
        [["scene", "cells that keep their start", "most memory", "at", "keeps its start", "most of a cell that does"]],
        {},
    )
    for place, scene in PLACES.items():
        found = study.map(
            f"chain {place}",
            x,
            y,
            measures=["memory", "start"],
            virtual_nodes=1,
            scene=scene | CHAIN,
            groups={"damping_ratio": 0.02},
            seeds=4,
            holds=study.size.holds // 2,
        )
        kept = found.start_difference.mean("seed").values > _KEPT
        best, inside = best_cell(found.memory.values), best_cell(found.memory.values, kept)
        assert best is not None
        row = [
            place,
            f"{kept.sum()} of {kept.size}",
            said(best.estimate),
            at(found, best),
            "yes" if kept[best.cell] else "no",
        ]
        rows.append([*row, "" if inside is None else said(inside.estimate)])
        told[place] = {
            "kept": int(kept.sum()),
            "cells": kept.size,
            "most": best.estimate.mean,
            "best keeps": bool(kept[best.cell]),
        }
    return rows, told


_KEPT = 1e-3


def spread_of_work(study: Study) -> tuple[list[list[str]], dict[str, Any]]:
    """How much work differs over inputs, and over starts that differ by a thousandth under one input."""
    inputs, holds, washout = 20, study.size.holds, study.size.holds // 3
    starts = [State(deformation=0.001 * k) for k in range(6)]
    rows = [["scene", "Π₁", "Π₄", "λ", "work a hold", "spread over inputs", "spread over starts", "share of starts"]]
    told = {}
    valves = np.array([dithered(np.zeros(holds, np.int64), 0.5, seed) for seed in range(inputs)])
    for place, scene in PLACES.items():
        for duffing in (0.5, 20.0, 200.0):
            for deborah in (0.05, 0.5, 5.0):
                groups = Groups(damping_ratio=0.02, duffing=duffing, deborah=deborah)
                works = np.array([work_between(groups, valves, scene, start, washout) for start in starts])
                over_inputs = float(works[0].std(ddof=1))
                over_starts = float(np.sqrt(works.var(axis=0, ddof=1).mean()))
                found = lyapunov_spectrum(groups, valves[:4], 0.5, scene=scene, washout=washout, tolerance=1e-6)
                exponent, error = found.exponents[0], found.standard_error[0]
                share = over_starts / over_inputs
                rows.append(
                    [
                        place,
                        f"{duffing:g}",
                        f"{deborah:g}",
                        f"{exponent:.3f} ± {error:.3f}",
                        f"{works.mean():.2g}",
                        f"{over_inputs:.2g}",
                        f"{over_starts:.1g}",
                        f"{share:.1g}",
                    ]
                )
                told[f"{place}, Π₁ {duffing:g}, Π₄ {deborah:g}"] = {
                    "exponent": exponent,
                    "share": share,
                    "over inputs": over_inputs,
                }
    return rows, told


def work_between(
    groups: Groups, valves: NDArray[np.int64], scene: Mapping[str, Any], start: State, washout: int
) -> NDArray[np.float64]:
    """Work a hold after the washout, for each input."""
    whole, before = (
        simulate(groups, given, 0.5, scene=scene, initial=start, tolerance=1e-6).work
        for given in (valves, valves[:, :washout])
    )
    return np.asarray(whole - before) / (valves.shape[1] - washout)


def exact_profile(groups: Groups, hold: float, delays: int) -> NDArray[np.float64]:
    """Memory of a linear anchored body, raw states and fair bits, exactly: b' A'^d C^-1 A^d b with C = A C A' + b b'.

    H. Jaeger, "Short term memory in echo state networks", GMD Report 152, 2001; O. L. White, D. D. Lee and
    H. Sompolinsky, Physical Review Letters 92, 148102, 2004.
    """
    payload, lag = 1.0 - groups.foot_mass_fraction, groups.deborah
    rates = np.array(
        [
            [0.0, 1.0, 0.0],
            [-1.0 / payload, -2.0 * groups.damping_ratio / payload, 1.0 / payload],
            [0.0, 0.0, -1.0 / lag],
        ]
    )
    flow = expm(rates * hold)
    impulse = np.linalg.solve(rates, flow - np.eye(3)) @ np.array([0.0, 0.0, 1.0 / lag])
    covariance = solve_discrete_lyapunov(flow, np.outer(impulse, impulse))
    profile, response = [], impulse
    for _ in range(delays):
        profile.append(float(response @ np.linalg.solve(covariance, response)))
        response = flow @ response
    return np.array(profile)


def modes(study: Study) -> tuple[list[list[str]], dict[str, Any]]:
    """Linear anchored bodies: memory by delay, exactly and measured, beside the rates of the body's modes."""
    rows = [
        [
            "Π₂",
            "Π₄",
            "λ",
            "−1/Π₄",
            "memory in all, exactly",
            "to delay 20, exactly",
            "measured",
            "mean delay",
            "half-life of the profile's tail",
            "ln 2 / (2 abs(rate) hold)",
        ]
    ]
    told, delays, holds = {}, 3000, 4 * study.size.holds
    valve = dithered(np.zeros(holds, np.int64), 0.5, 0)
    for damping in (0.02, 0.05, 0.2):
        for deborah in (0.05, 0.5, 5.0):
            groups = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=damping, deborah=deborah)
            exact = exact_profile(groups, 0.5, delays)
            states = body_states(simulate(groups, valve, 0.5, scene={"anchored": True}))
            measured = memory_capacity(states, valve - 0.5, 20)
            rate = -damping / (1.0 - groups.foot_mass_fraction)
            slowest = max(rate, -1.0 / deborah)
            tail = np.cumsum(exact[::-1])[::-1]
            first = int(np.flatnonzero(tail > 1e-9)[-1])
            middle = first // 2
            half_life = np.log(2.0) * (first - middle) / np.log(tail[middle] / tail[first])
            rows.append(
                [
                    f"{damping:g}",
                    f"{deborah:g}",
                    f"{rate:.4f}",
                    f"{-1.0 / deborah:.2f}",
                    f"{exact.sum():.3f}",
                    f"{exact[:20].sum():.3f}",
                    f"{measured.total:.3f}",
                    f"{np.arange(delays) @ exact / exact.sum():.1f}",
                    f"{half_life:.1f}",
                    f"{np.log(2.0) / (2.0 * -slowest * 0.5):.1f}",
                ]
            )
            told[f"Π₂ {damping:g}, Π₄ {deborah:g}"] = {
                "exact": exact.sum(),
                "to 20": exact[:20].sum(),
                "measured": measured.total,
            }
    return rows, told


def forgetting(maps: Mapping[str, xr.Dataset]) -> tuple[list[list[str]], dict[str, Any]]:
    """Whether bodies of negative exponent, and no others, come together from two starts."""
    rows, told = [["scene and body", "λ < 0, forget", "λ < 0, keep", "λ > 0, forget", "λ > 0, keep", "undecided"]], {}
    for name, found in maps.items():
        if not name.endswith("raw"):
            continue
        exponents = found.lyapunov.values
        above, below = chaotic(exponents), chaotic(-exponents)
        kept = found.start_difference.mean("seed").values > _KEPT
        counts = [
            int((sign & keeps).sum()) for sign, keeps in ((below, ~kept), (below, kept), (above, ~kept), (above, kept))
        ]
        undecided = int((~above & ~below).sum())
        rows.append([name.removesuffix(", raw"), *map(str, counts), str(undecided)])
        told[name.removesuffix(", raw")] = counts
    return rows, told


def work_and_memory(maps: Mapping[str, xr.Dataset]) -> tuple[list[list[str]], dict[str, Any]]:
    """Along Π₁, for each Π₄: where memory is largest, and the work there."""
    rows, told = (
        [
            [
                "map",
                "rows of Π₄",
                "largest at the least Π₁",
                "inside",
                "at the largest Π₁",
                "work there over the row's most",
                "with work, rank correlation",
            ]
        ],
        {},
    )
    for name, found in maps.items():
        memory, work = found.memory.mean("seed").values, found.work.mean("seed").values
        places = memory.argmax(axis=1)
        last = memory.shape[1] - 1
        counts = [int((places == 0).sum()), int(((places > 0) & (places < last)).sum()), int((places == last).sum())]
        there = work[np.arange(len(places)), places] / work.max(axis=1)
        own = [rank_correlation(*pair) for pair in zip(memory, work, strict=True)]
        rows.append(
            [
                name,
                str(len(places)),
                *map(str, counts),
                f"{np.median(there):.2f} ({there.min():.2f} to {there.max():.2f})",
                f"{np.median(own):.2f}",
            ]
        )
        told[name] = {"rows": len(places), "first": counts[0], "inside": counts[1], "last": counts[2]}
    return rows, told


def verdicts(told: Mapping[str, Any]) -> str:
    """What the numbers say of the paper's claims, in sentences."""
    largest = told["largest memory"]
    each_claim = (
        _where_an_edge_is(largest),
        _whether_memory_is_at_it(largest),
        _why(told["modes"]),
        _whether_it_peaks_with_work(told["work"]),
        _whether_products_peak(told["line"]),
        _whether_starts_are_forgotten(told["forgetting"]),
        _chaos_on_the_ground(told["ground"], told["words"]),
        _what_spreads_work(told["spread of work"]),
        _what_a_chain_does(told["chain"]),
    )
    return "\n".join(f"- {each}" for each in each_claim)


def _where_an_edge_is(largest: Mapping[str, Any]) -> str:
    """Of the raw states, whose exponents are those of the body."""
    raw = {name: each for name, each in largest.items() if name.endswith("raw")}
    chaos = {place: [each["chaotic"] for name, each in raw.items() if name.startswith(place)] for place in PLACES}
    cells = next(iter(raw.values()))["cells"]
    low, high = min(chaos["anchored"]), max(chaos["anchored"])
    ground = sum(chaos["ground"])
    verdict = "of the anchored body only" if low and not ground else "not as the paper has it"
    return (
        f"**C4, a curve λ = 0 in Π₁ × Π₄: {verdict}.** Under fair bits {low} to {high} of {cells} cells are "
        f"chaotic where "
        f"the body is anchored, and {ground} of {cells * len(chaos['ground'])} on the ground, at Π₂ 0.02 and 0.05."
    )


def _whether_memory_is_at_it(largest: Mapping[str, Any]) -> str:
    with_edge = [each for each in largest.values() if "more" in each]
    margins = [each["more"][0] for each in with_edge]
    ahead = sum(each["more"][1] > 0.0 for each in with_edge)
    behind = sum(each["more"][2] < 0.0 for each in with_edge)
    exponents = [each["exponent"][0] for each in largest.values()]
    verdict = "no" if ahead and not behind else "not told"
    return (
        f"**C5, memory is largest at the edge: {verdict}.** Over {len(largest)} maps the cell of most memory "
        f"has an exponent "
        f"of {min(exponents):.3f} to {max(exponents):.3f}. It holds {min(margins):.2f} to {max(margins):.2f} "
        f"more than the "
        f"best cell at the edge in the {len(with_edge)} maps that have one: more by the 95% interval in "
        f"{ahead}, less in "
        f"{behind}."
    )


def _why(modes: Mapping[str, Any]) -> str:
    off = max(abs(each["exact"] - 3.0) for each in modes.values())
    return (
        f"**Why: a linear body holds all that its states can.** Three states remember 3 at most, and {len(modes)} "
        f"linear bodies, at three dampings and lags, remember 3 exactly (to {off:.0e}), whatever their exponents: the "
        f"slower of λ and −1/Π₄ decides how far back memory reaches, by a half-life of ln 2 / (2 abs(rate) hold), "
        f"and not how much of it there is."
    )


def _whether_it_peaks_with_work(work: Mapping[str, Any]) -> str:
    first, inside, last = (sum(each[key] for each in work.values()) for key in ("first", "inside", "last"))
    rows = first + inside + last
    verdict = "no" if inside < 0.5 * rows else "in part"
    return (
        f"**C3, along Π₁ memory peaks at moderate work: {verdict}.** Of {rows} rows of Π₄ memory is largest at "
        f"the least Π₁, "
        f"where most work is done, in {first}, inside in {inside}, and at the largest Π₁ in {last}."
    )


def _whether_products_peak(lines: Mapping[str, Any]) -> str:
    series = {name: each for name, each in lines.items() if ": " in name}
    found = {
        kind: [each for name, each in series.items() if name.endswith(ends) and each["most"][0] >= _WORTH]
        for kind, ends in {
            "linear": ("memory", "degree 1"),
            "products": ("parity_2", "parity_3", "degree 2", "degree 3"),
        }.items()
    }
    at_edge = {kind: sum(not each["more"] or each["more"][1] <= 0.0 for each in rows) for kind, rows in found.items()}
    exponents = [each["exponent"] for each in found["products"]]
    where = "on the contracting side of the edge" if max(exponents) < 0.0 else "on both sides of the edge"
    return (
        f"**Products of inputs** (parities and capacities of degrees 2 and 3) are largest {where}, at exponents of "
        f"{min(exponents):.3f} to {max(exponents):.3f} along two lines through λ = 0, and "
        f"{'not' if not at_edge['products'] else 'in part'} at it: of {len(exponents)} series that reach {_WORTH}, "
        f"{len(exponents) - at_edge['products']} are larger there than beside λ = 0 by the 95% interval, and of "
        f"{len(found['linear'])} of linear memory {len(found['linear']) - at_edge['linear']}."
    )


_WORTH = 0.05


def _whether_starts_are_forgotten(forgetting: Mapping[str, Any]) -> str:
    counts = np.sum(list(forgetting.values()), axis=0).tolist()
    return (
        f"**Echo-state property:** of {sum(counts)} cells whose exponent is told from 0, {counts[0]} contract "
        f"and forget "
        f"their start, {counts[3]} are chaotic and keep it, {counts[1]} contract and have not forgotten it yet, and "
        f"{counts[2]} are chaotic and forget it."
    )


def _chaos_on_the_ground(low: Mapping[str, Any], words: Mapping[str, Any]) -> str:
    share = [f"{each:.1%}" for each in words["share"][1:]]
    return (
        f"**Chaos on the ground** exists at low damping (Π₂ 0.002, Π₁ 100 to 2000: {low['raw']['chaotic']} of "
        f"{low['raw']['cells']} cells under fair bits) and under short periodic words ({words['chaotic']} of "
        f"{words['tries']} random tries, 95% interval {share[0]} to {share[1]}); of these "
        f"{words['chaotic under flips']} have an exponent above 0 once a tenth of the bits are flipped."
    )


def _what_spreads_work(spread: Mapping[str, Any]) -> str:
    calm = [each["share"] for name, each in spread.items() if name.startswith("ground")]
    wild = [
        each["share"] for name, each in spread.items() if name.startswith("anchored") and each["exponent"] > _CHAOTIC
    ]
    return (
        f"**C10, chaos of stick-slip spreads the work: {'no' if max(calm) < 0.1 else 'in part'}.** On the "
        f"ground starts that "
        f"differ by a thousandth come to at most {max(calm):.1g} of the spread that inputs make; where the body "
        f"is anchored "
        f"and chaotic, and neither sticks nor slips, to {min(wild):.1f} to {max(wild):.1f} of it."
    )


_CHAOTIC = 0.01


def _what_a_chain_does(chain: Mapping[str, Any]) -> str:
    each_place = [
        f"{place} {each['kept']} of {each['cells']} cells keep their start, and the cell of most memory "
        f"{'is one of them' if each['best keeps'] else 'is none of them'}"
        for place, each in chain.items()
    ]
    return f"**A chain of three segments:** {'; '.join(each_place)}."


def table(rows: list[list[str]]) -> str:
    lines = [rows[0], [" --- ".strip(), *["---:"] * (len(rows[0]) - 1)], *rows[1:]]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def tables(results: Mapping[str, Any]) -> dict[str, str]:
    """The page's tables and verdicts."""
    return {
        "verdicts": verdicts(results["told"]),
        **{name: table(rows) for name, rows in results["rows"].items()},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer of everything; the page stays as it is")
    parser.add_argument("--folder", type=Path, default=Path("runs/edge"))
    parser.add_argument("--processes", type=int, default=processors())
    arguments = parser.parse_args()
    study = Study(QUICK if arguments.quick else FULL, arguments.folder, arguments.processes)
    maps = maps_of_all(study)
    lines, line_rows, line_told = lines_through_the_edge(study)
    made = {
        "largest memory": where_memory_is_largest(maps),
        "all cells": over_all_cells(maps),
        "line": (line_rows, line_told),
        "work": work_and_memory(maps),
        "forgetting": forgetting(maps),
        "modes": modes(study),
        "ground": chaos_on_the_ground(study),
        "words": chaotic_words(study),
        "chain": chains(study),
        "spread of work": spread_of_work(study),
    }
    results = {
        "machine": machine("xarray", "zarr"),
        "size": asdict(study.size),
        "told": {name: numbers for name, (_, numbers) in made.items()},
        "rows": {name: rows for name, (rows, _) in made.items()},
    }
    for name, text in tables(results).items():
        print(f"\n{name}\n{text}")
    drawn = {
        "edge": plot_map(maps[name_of("anchored", 0.5, 0.02, "raw")], ["lyapunov", "memory"]),
        "edge_line": plot_map(lines["hold 2, Π₂ 0.05, raw"], ["lyapunov", "memory", "parity_2"]),
    }
    folder = arguments.folder if arguments.quick else IMAGES
    for ax in drawn["edge"].axes[:2]:
        ax.set_xscale("symlog", linthresh=1.0)  # most happens near 0
    for name, figure in drawn.items():
        save_figure(figure, *(folder / f"{name}.{form}" for form in ("png", "svg")))
    if not arguments.quick:
        keep(RESULTS, results)
        refresh(PAGE, tables(results))


if __name__ == "__main__":
    main()
