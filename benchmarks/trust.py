"""How far to trust a capacity: false positives, power, coverage and bias of the measures, where the truth is known.

Run ``python benchmarks/trust.py``; ``--quick`` takes a tenth of the runs and writes nothing. What is finished is kept
in ``results/trust.json`` case by case, and a run that was broken off goes on from there. The tables go into
`docs/trust.md`.

Beside every rate of ours stands, in brackets, that of the usual thresholds on the same data: one chi-squared quantile
for all delays, twice one for all functions, which take the square of a target for constant.
"""

import argparse
import json
import math
import os
import warnings
from collections.abc import Callable
from pathlib import Path
from statistics import NormalDist
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.special import chdtri

from stickslip.reservoir import (
    delay_line,
    EchoStateNetwork,
    fit_readout,
    information_processing_capacity,
    mean_over_runs,
    memory_capacity,
)
from stickslip.reservoir.orthonormal import orthonormal_basis
from stickslip.reservoir.product_basis import legendre_polynomials, products, terms, walsh
from stickslip.reservoir.significance import chance, effective_events, events_needed
from stickslip.tasks.parity import parity

RESULTS = Path(__file__).parent / "results" / "trust.json"
PAGE = Path(__file__).parents[1] / "docs" / "trust.md"
INPUTS = ("0.5", "0.1", "0.02", "0.01", "uniform")
STATES = ("white", "slow", "heavy", "products")
# States, samples and runs.
SIZES = {(3, 300): 100, (10, 3000): 30, (100, 3000): 8, (10, 100_000): 3}
SIGNIFICANCES = (1e-2, 1e-3)
DELAYS, FACTORS, FUNCTIONS, RESAMPLES = 30, 12, 200, 400

Array = NDArray[np.float64]
Result = dict[str, Any]


def inputs(kind: str, samples: int, random: np.random.Generator) -> Array:
    """Innovations of a dithered valve, or uniform ones."""
    if kind == "uniform":
        return random.uniform(-1, 1, samples)
    return (random.random(samples) < float(kind)) - float(kind)


def states(kind: str, features: int, message: Array, random: np.random.Generator) -> Array:
    """States that are uncorrelated with every function of fewer than four inputs."""
    shape = len(message), features
    if kind == "products":
        past = delay_line(message, FACTORS)
        chosen = [random.choice(FACTORS, 4, replace=False) for _ in range(features)]
        return np.column_stack([past[:, each].prod(axis=1) for each in chosen])
    if kind == "heavy":
        return random.standard_t(2, shape)
    noise = random.normal(size=shape)
    return lfilter([1], [1, -0.99], noise, axis=0) if kind == "slow" else noise


def false_positives(message_kind: str, states_kind: str, features: int, samples: int, runs: int) -> Result:
    """Passes of chance, ours and usual, by measure and significance."""
    found: Result = {}
    for seed in range(runs):
        random = np.random.default_rng([seed, features, samples])
        e = inputs(message_kind, samples + DELAYS, random)
        x = states(states_kind, features, e, random)
        for significance in SIGNIFICANCES:
            for measure, passes in (
                ("held out", _held_out(x, e, significance)),
                ("left out", _left_out(x, e, significance)),
                ("information", _information(x, e, message_kind, significance, seed)),
            ):
                counts = found.setdefault(f"{measure} {significance:g}", [0, 0, 0])
                for i, count in enumerate(passes):
                    counts[i] += int(count)
    return found


def _held_out(x: Array, e: Array, significance: float) -> tuple[int, int, int]:
    try:
        memory = memory_capacity(x, e, DELAYS, washout=0, significance=significance)
    except ValueError:  # no flip came up where one delay is scored
        return 0, 0, 0
    usual = NormalDist().inv_cdf(significance) ** 2 / ((len(x) - DELAYS + 1) // 2)
    return int((memory.profile > memory.cutoff).sum()), int((memory.profile > usual).sum()), DELAYS


def _left_out(x: Array, e: Array, significance: float) -> tuple[int, int, int]:
    if len(x) > 20_000:
        return 0, 0, 0
    try:
        memory = memory_capacity(x, e, DELAYS, washout=0, significance=significance, scoring="leave one out")
    except ValueError:
        return 0, 0, 0
    samples, rank = len(x) - DELAYS + 1, memory.bound
    leverage, s = (rank + 1) / samples, float(chdtri(rank, significance))
    usual = (s - rank - 1) ** 2 / (samples * (s - 2 * leverage * s + samples * leverage**2))
    return int((memory.profile > memory.cutoff).sum()), int((memory.profile > usual).sum()), DELAYS


def _information(x: Array, e: Array, kind: str, significance: float, seed: int) -> tuple[int, int, int]:
    """As the search does, on a choice of functions of all degrees in place of all of them."""
    if np.ptp(e) == 0:  # no flip came up at all
        return 0, 0, 0
    functions = legendre_polynomials(e, 3, (-1, 1)) if kind == "uniform" else walsh(e)
    wanted = [term for degree in (1, 2, 3) for delay in range(FACTORS) for term in terms(degree, delay, len(functions))]
    random = np.random.default_rng(seed)
    wanted = [wanted[i] for i in random.choice(len(wanted), min(FUNCTIONS, len(wanted)), replace=False)]
    basis = orthonormal_basis(x[DELAYS:])
    ours = usual = 0
    for first in range(0, len(wanted), 20):
        rows = products(functions, wanted[first : first + 20], DELAYS)
        rows = rows - rows.mean(axis=1, keepdims=True)
        projected, total = rows @ basis, np.vecdot(rows, rows)
        explained = np.divide(np.vecdot(projected, projected), total, out=np.zeros(len(rows)), where=total > 0)
        passed = explained > chance(basis, rows, significance, explained).cutoff
        passed &= effective_events(basis, rows) > events_needed(functions, significance)
        ours += int(passed.sum())
        usual += int((explained > 2 * chdtri(basis.shape[1], significance) / len(basis)).sum())
    return ours, usual, len(wanted)


def power(message_kind: str, samples: int, capacity: float, runs: int) -> Result:
    """Share of functions of a capacity that are found at a significance of 1e-4, ours and usual, by degree."""
    found: Result = {}
    features, significance = 12, 1e-4
    for seed in range(runs):
        random = np.random.default_rng(seed)
        f = walsh(inputs(message_kind, samples + DELAYS, random))
        for degree in (1, 2):
            wanted = [((delay, 1),) if degree == 1 else ((delay, 1), (delay + 1, 1)) for delay in range(features)]
            rows = products(f, wanted, DELAYS)
            x = (math.sqrt(capacity) * rows + math.sqrt(1 - capacity) * random.normal(size=rows.shape)).T
            basis = orthonormal_basis(x)
            rows = rows - rows.mean(axis=1, keepdims=True)
            projected = rows @ basis
            explained = np.vecdot(projected, projected) / np.vecdot(rows, rows)
            passed = explained > chance(basis, rows, significance, explained).cutoff
            passed &= effective_events(basis, rows) > events_needed(f, significance)
            counts = found.setdefault(f"information, degree {degree}", [0, 0, 0])
            counts[0] += int(passed.sum())
            counts[1] += int((explained > 2 * chdtri(features, significance) / len(basis)).sum())
            counts[2] += features
            if degree == 1:
                e = f[0]
                whole = np.vstack([np.zeros((DELAYS, features)), x])
                memory = memory_capacity(whole, e, features, washout=DELAYS, significance=significance)
                usual = NormalDist().inv_cdf(significance) ** 2 / (samples // 2)
                counts = found.setdefault("memory, held out", [0, 0, 0])
                counts[0] += int((memory.profile > memory.cutoff).sum())
                counts[1] += int((memory.profile > usual).sum())
                counts[2] += features
    return found


POWER = (("0.5", 10_000), ("0.1", 10_000), ("0.1", 50_000))


def coverage_of_memory(case: str, runs: int) -> Result:
    """Runs of which the intervals of 95% hold the truth."""
    found: Result = {
        "runs": runs,
        "capacity": 0,
        "total": 0,
        "corrected, this readout": 0,
        "corrected, best readout": 0,
    }
    found["own estimate"] = 0
    features, samples, delays, noise, dither = MEMORY_CASES[case]
    for seed in range(runs):
        random = np.random.default_rng(seed)
        e = inputs(dither, samples + 200, random)
        e /= math.sqrt(float(dither) * (1 - float(dither)))
        x = noise * random.normal(size=(len(e), max(features, 1)))
        if features:
            x += delay_line(e, features)
        memory = memory_capacity(x, e, delays, resamples=RESAMPLES, seed=seed)
        assert memory.total_interval is not None
        assert memory.corrected_interval is not None
        assert memory.profile_interval is not None
        start = max(200, delays - 1)
        train = start + (len(e) - start) // 2
        targets = np.column_stack([e[start - d : train - d] for d in range(delays)])
        weights = fit_readout(x[start:train], targets).coef_
        hold = np.zeros((delays, weights.shape[1]))
        known = min(features, delays)
        hold[:known, :known] = np.eye(known)
        spread = (weights**2).sum(axis=1) * ((features > 0) + noise**2)
        along = np.maximum(np.sum(weights * hold, axis=1), 0)
        truth, best = along**2 / spread, np.full(features, 1 / (1 + noise**2)).sum()
        low, high = memory.profile_interval
        found["capacity"] += int(low[0] <= truth[0] <= high[0])
        found["total"] += int(memory.total_interval[0] <= truth.sum() <= memory.total_interval[1])
        low, high = memory.corrected_interval
        found["corrected, this readout"] += int(low <= truth[memory.profile > memory.cutoff].sum() <= high)
        found["corrected, best readout"] += int(low <= best <= high)
        found["own estimate"] += int(
            memory.total_interval[0] <= memory.total <= memory.total_interval[1] and low <= memory.corrected <= high
        )
    return found


MEMORY_CASES = {
    "4 noisy taps, 12 delays, 2000 samples": (4, 2000, 12, 1.0, "0.5"),
    "20 noisy taps, 30 delays, 1000 samples": (20, 1000, 30, 1.0, "0.5"),
    "4 good taps, 12 delays, 2000 samples": (4, 2000, 12, 0.1, "0.5"),
    "noise, 200 delays, 2000 samples": (0, 2000, 200, 1.0, "0.5"),
    "4 noisy taps, 200 delays, 2000 samples": (4, 2000, 200, 1.0, "0.5"),
    "4 noisy taps, dither 0.1, 12 delays, 4000 samples": (4, 4000, 12, 1.0, "0.1"),
}


def coverage_of_information(case: str, runs: int) -> Result:
    """Runs of which the intervals of 95% hold the truth, and what the totals are with and without their correction."""
    found: Result = {"runs": runs, "capacity": 0, "total": 0, "sum": 0.0, "raw": 0.0}
    features, samples, noise, dither = INFORMATION_CASES[case]
    share = 1 / (1 + noise**2)
    found["truth"] = features * share
    for seed in range(runs):
        random = np.random.default_rng(seed)
        e = inputs(dither, samples + 200, random)
        z = e / math.sqrt(float(dither) * (1 - float(dither)))
        x = delay_line(z, features) + noise * random.normal(size=(len(e), features))
        capacity = information_processing_capacity(x, e, max_degree=1, delays=features, patience=None)
        low, high = capacity.capacity_interval
        found["capacity"] += int(low[0] <= share <= high[0])
        found["total"] += int(capacity.total_interval[0] <= share * len(capacity.terms) <= capacity.total_interval[1])
        found["sum"] += capacity.total / runs
        found["raw"] += float(np.sum(1 - (1 - capacity.capacity) * (1 - capacity.chance))) / runs
    return found


INFORMATION_CASES = {
    "4 half bits, 2000 samples": (4, 2000, 1.0, "0.5"),
    "60 half bits, 1200 samples": (60, 1200, 1.0, "0.5"),
    "30 bits less a fifth, 1200 samples": (30, 1200, 0.5, "0.5"),
    "60 tenths of bits, 1200 samples": (60, 1200, 3.0, "0.5"),
    "12 half bits, dither 0.1, 4000 samples": (12, 4000, 1.0, "0.1"),
}


def coverage_over_runs(case: str, runs: int) -> Result:
    """Intervals over 3, 5 and 10 runs that hold the mean, ours and Student's, and how many there are."""
    random = np.random.default_rng(1)
    if case.startswith("parity"):
        order = int(case[len("parity-")])
        pool = []
        for seed in range(max(runs // 4, 50)):
            bits = np.random.default_rng([7, seed]).integers(0, 2, 3000)
            network = EchoStateNetwork(12, input_scaling=0.5, seed=seed)
            capacity = memory_capacity(network.states(bits), parity(bits, order).astype(float), 20)
            pool.append(capacity.corrected)
        mean = float(np.mean(pool))

        def draw(count: int) -> Array:
            return random.choice(np.array(pool), count)

    else:
        law, mean = {
            "normal": (lambda n: random.normal(5, 1, n), 5.0),
            "exponential": (lambda n: random.exponential(1, n), 1.0),
            "lognormal": (lambda n: random.lognormal(0, 1, n), math.exp(0.5)),
            "gamma of shape 0.3": (lambda n: random.gamma(0.3, 1, n), 0.3),
            "1 in one run of five, else 0": (lambda n: (random.random(n) < 0.2).astype(float), 0.2),
        }[case]
        draw = law
    found: Result = {"runs": runs}
    for count in (3, 5, 10):
        hits = [0, 0, 0]
        for _ in range(runs):
            values = draw(count)
            # Equal runs have no interval.
            hits[2] += int(np.ptp(values) > 0)
            for i, bounds in enumerate(((0.0, math.inf), (-math.inf, math.inf))):
                each = mean_over_runs(values, bounds=bounds)
                hits[i] += int(each.low <= mean <= each.high)
        found[str(count)] = hits
    return found


RUNS_CASES = (
    "normal",
    "exponential",
    "lognormal",
    "gamma of shape 0.3",
    "1 in one run of five, else 0",
    "parity-1 of the network",
    "parity-2 of the network",
    "parity-3 of the network",
)


def cases(scale: float) -> dict[str, Callable[[], Result]]:
    """All that is measured, by name."""
    made: dict[str, Callable[[], Result]] = {}
    for (features, samples), count in SIZES.items():
        runs = max(1, round(scale * count))
        for message in INPUTS:
            for kind in STATES:
                # Of four factors among twelve delays there are 495 products, and a rank needs them to differ.
                states_count = min(features, 40) if kind == "products" else features
                made[f"false positives: {message}, {kind}, {features} states, {samples} samples"] = (
                    lambda m=message, k=kind, n=states_count, t=samples, r=runs: false_positives(m, k, n, t, r)
                )
    for message, samples in POWER:
        for capacity in (0.003, 0.006, 0.012, 0.025, 0.05):
            made[f"power: {message}, {samples} samples, {capacity}"] = lambda m=message, t=samples, c=capacity: power(
                m, t, c, max(2, round(scale * 200_000 / t))
            )
    for case in MEMORY_CASES:
        made[f"memory: {case}"] = lambda c=case: coverage_of_memory(c, max(10, round(scale * 200)))
    for case in INFORMATION_CASES:
        made[f"information: {case}"] = lambda c=case: coverage_of_information(c, max(10, round(scale * 200)))
    for case in RUNS_CASES:
        made[f"over runs: {case}"] = lambda c=case: coverage_over_runs(c, max(20, round(scale * 2000)))
    return made


def tables(done: dict[str, Result]) -> dict[str, str]:
    """Of Markdown, by the name of their marks."""
    made = {}
    for measure in ("held out", "left out", "information"):
        lines = [_row(["states", "significance", *(f"dither {m}" if m != "uniform" else m for m in INPUTS)])]
        lines.append("|---|---:|" + "---:|" * len(INPUTS))
        for kind in STATES:
            for significance in SIGNIFICANCES:
                cells = []
                for message in INPUTS:
                    counts = np.zeros(3)
                    for features, samples in SIZES:
                        one = done[f"false positives: {message}, {kind}, {features} states, {samples} samples"]
                        counts += one[f"{measure} {significance:g}"]
                    cells.append(f"{counts[0] / counts[2]:.4f} ({counts[1] / counts[2]:.4f})" if counts[2] else "-")
                lines.append(_row([kind, f"{significance:g}", *cells]))
        made[f"false positives {measure}"] = "\n".join(lines)
    capacities = sorted({float(name.rsplit(", ", 1)[1]) for name in done if name.startswith("power")})
    lines = [_row(["", "inputs", *(f"capacity {c:g}" for c in capacities)]), "|---|---|" + "---:|" * len(capacities)]
    for measure in ("memory, held out", "information, degree 1", "information, degree 2"):
        for message, samples in POWER:
            counts = [done[f"power: {message}, {samples} samples, {c}"][measure] for c in capacities]
            lines.append(
                _row(
                    [
                        measure,
                        f"dither {message}, {samples} samples",
                        *(f"{a / n:.2f} ({b / n:.2f})" for a, b, n in counts),
                    ]
                )
            )
    made["power"] = "\n".join(lines)
    what = ("capacity", "total", "corrected, this readout", "corrected, best readout", "own estimate")
    lines = [_row(["memory", *what]), "|---|" + "---:|" * len(what)]
    for case in MEMORY_CASES:
        one = done[f"memory: {case}"]
        lines.append(_row([case, *(f"{100 * one[key] / one['runs']:.1f}%" for key in what)]))
    made["coverage of memory"] = "\n".join(lines)
    lines = [_row(["information", "capacity", "total", "truth", "corrected", "as fitted"]), "|---|" + "---:|" * 5]
    for case in INFORMATION_CASES:
        one = done[f"information: {case}"]
        shares = [f"{100 * one[key] / one['runs']:.1f}%" for key in ("capacity", "total")]
        lines.append(_row([case, *shares, *(f"{one[key]:.2f}" for key in ("truth", "sum", "raw"))]))
    made["coverage of information"] = "\n".join(lines)
    lines = [_row(["score", "3 runs", "5 runs", "10 runs"]), "|---|---:|---:|---:|"]
    for case in RUNS_CASES:
        one = done[f"over runs: {case}"]
        cells = [
            f"{100 * a / given:.1f}% ({100 * b / given:.1f}%)" + ("" if given == one["runs"] else f" of {given}")
            for a, b, given in (one[n] for n in ("3", "5", "10"))
        ]
        lines.append(_row([case, *cells]))
    made["coverage over runs"] = "\n".join(lines)
    return made


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Measure what is missing, print the tables and keep them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of the runs, printed only")
    parser.add_argument("--fresh", action="store_true", help="forget what was measured before")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)
    resumed = RESULTS.exists() and not arguments.quick and not arguments.fresh
    results: Result = json.loads(RESULTS.read_text(encoding="utf-8")) if resumed else {"cases": {}}
    done = results["cases"]
    for name, measure in cases(0.1 if arguments.quick else 1.0).items():
        if name in done:
            continue
        done[name] = measure()
        print(name, json.dumps(done[name]), flush=True)
        if not arguments.quick:
            keep(RESULTS, {"machine": machine("scipy"), "cases": done})
    made = tables(done)
    for name, table in made.items():
        print(f"\n{name}\n{table}")
    if not arguments.quick:
        refresh(PAGE, made)


if __name__ == "__main__":
    main()
