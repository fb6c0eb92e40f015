"""Lyapunov exponents: check values, how far they are from closed forms and SciPy, and what they cost.

Run ``python benchmarks/exponents.py``. The tables go into the docs, and all numbers into
`benchmarks/results/exponents.json`. Costs are medians of ratios within one round, of one crawler on one thread.
"""

import argparse
import math
import os
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, quartiles, refresh, take_turns
from scipy.integrate import solve_ivp

from stickslip import Groups, lyapunov_spectrum, simulate

RESULTS = Path(__file__).parent / "results" / "exponents.json"
PAGE = Path(__file__).parents[1] / "docs" / "lyapunov.md"
ANCHORED = {"anchored": True}
BITS = np.random.default_rng(0).integers(0, 2, (8, 4200))
BODIES = {
    "anchored, `Pi1 = Pi5 = 0`, `Pi2 = 0.02`": (
        {"duffing": 0.0, "radial_coupling": 0.0, "damping_ratio": 0.02},
        ANCHORED,
    ),
    "anchored, `Pi1 = 2`, `Pi2 = 0.02`": ({"duffing": 2.0, "damping_ratio": 0.02}, ANCHORED),
    "anchored, `Pi1 = 200`, `Pi2 = 0.02`": ({"duffing": 200.0, "damping_ratio": 0.02}, ANCHORED),
    "on the ground, default": ({}, {}),
    "on the ground, `Pi1 = 200`, `Pi2 = 0.02`": ({"duffing": 200.0, "damping_ratio": 0.02}, {}),
    "on the ground, `Pi1 = 1000`, `Pi2 = 0.002`, `Pi4 = 8`": (
        {"duffing": 1000.0, "damping_ratio": 0.002, "deborah": 8.0},
        {},
    ),
    "on the ground, friction both ways": ({}, {"ratchet": False}),
    "no friction at all": ({"static_friction": 0.0, "kinetic_friction": 0.0}, {"ratchet": False}),
}
"""Looked at under fair bits, hold 0.5."""


def row_of(name: str) -> dict[str, Any]:
    """Exponents of a body."""
    groups, scene = BODIES[name]
    found = lyapunov_spectrum(groups, BITS, 0.5, scene=scene)
    return {
        "body": name,
        "exponents": found.exponents.tolist(),
        "standard_error": found.standard_error.tolist(),
        "divergence": found.divergence,
        "foot": "none" if math.isnan(found.foot_exponent) else f"{found.foot_exponent:g}".replace("-inf", "−∞"),
        "stops": found.stops,
        "verdict": found.verdict,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """The check values."""
    lines = ["| body | first | second | sum | divergence | foot | stops | verdict |", f"|---|{'---:|' * 6}---|"]
    for row in rows:
        told = [f"{a:.4f} ± {b:.4f}" for a, b in zip(row["exponents"], row["standard_error"], strict=True)]
        sums = [f"{sum(row['exponents']):.4f}", f"{row['divergence']:.4f}"]
        cells = [row["body"], *told, *sums, row["foot"], str(row["stops"]), row["verdict"]]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def differences() -> dict[str, float]:
    """How far exponents are from what is known of them."""
    damped = -0.02 / 0.7
    linear = _spectrum("anchored, `Pi1 = Pi5 = 0`, `Pi2 = 0.02`")
    chaotic = _spectrum("anchored, `Pi1 = 200`, `Pi2 = 0.02`")
    ours, theirs = against_scipy()
    return {
        "linear body, anchored: both from -Pi2 / (1 - r)": float(np.abs(linear - damped).max()),
        "chaotic body, anchored: the sum from -2 Pi2 / (1 - r)": float(abs(chaotic.sum() - 2.0 * damped)),
        "chaotic body, anchored: the first from SciPy's variational equations at 1e-12": abs(ours - theirs),
    }


def difference_table(found: dict[str, float]) -> str:
    """What `differences` found."""
    lines = ["| difference | per natural time |", "|---|---:|"]
    return "\n".join([*lines, *(f"| {name} | {size:.0e} |" for name, size in found.items())])


def cost_table(ratios: dict[str, list[float]]) -> str:
    """Time of the exponents over that of the motion."""
    lines = ["| body | exponents over motion |", "|---|---:|"]
    return "\n".join([*lines, *(f"| {name} | {middle:.1f} |" for name, (_, middle, _) in ratios.items())])


def tables(results: dict[str, Any]) -> dict[str, str]:
    """Of the page, by the names of their places."""
    return {
        "exponents": table(results["rows"]),
        "differences": difference_table(results["differences"]),
        "cost": cost_table(results["cost"]),
    }


def _spectrum(name: str) -> Any:
    groups, scene = BODIES[name]
    return lyapunov_spectrum(groups, BITS[0], 0.5, scene=scene).exponents


def against_scipy(holds: int = 200) -> tuple[float, float]:
    """First exponent of a chaotic anchored body by a short run, and by SciPy's variational equations."""
    groups = Groups(duffing=200.0, damping_ratio=0.02)
    found = lyapunov_spectrum(groups, BITS[0, :holds], 0.5, scene=ANCHORED, washout=0)
    stiffness = 1.0 / (1.0 - groups.foot_mass_fraction)
    decay = groups.damping_ratio * stiffness

    def size(z: float, v: float) -> float:
        return math.sqrt((v + decay * z) ** 2 + (stiffness - decay**2) * z**2)

    def rates(_t: float, y: Any, u: float) -> list[float]:
        z, v, p, dz, dv = y
        force = p * (1.0 + groups.radial_coupling * z) - z - groups.duffing * z**3 - 2.0 * groups.damping_ratio * v
        change = (p * groups.radial_coupling - 1.0 - 3.0 * groups.duffing * z**2) * dz - 2.0 * groups.damping_ratio * dv
        return [v, force * stiffness, (u - p) / groups.deborah, dv, change * stiffness]

    state, total = np.array([0.0, 0.0, 0.0, 1.0, 1.0]), 0.0
    state[3:] /= size(1.0, 1.0)
    for u in BITS[0, :holds]:
        state = solve_ivp(rates, (0.0, 0.5), state, "DOP853", args=(float(u),), rtol=1e-12, atol=1e-13).y[:, -1]
        grown = size(*state[3:])
        total += math.log(grown)
        state[3:] /= grown
    return float(found.exponents[0]), total / found.time


def costs(rounds: int) -> dict[str, list[float]]:
    """Quartiles of the exponents' time over that of the motion alone."""
    found = {}
    for name in ("anchored, `Pi1 = 200`, `Pi2 = 0.02`", "on the ground, default"):
        groups, scene = BODIES[name]
        works = {
            "motion": lambda groups=groups, scene=scene: simulate(groups, BITS[0], 0.5, scene=scene),
            "exponents": lambda groups=groups, scene=scene: lyapunov_spectrum(
                groups, BITS[0], 0.5, scene=scene, threads=1
            ),
        }
        for work in works.values():
            work()
        seconds = take_turns(works, rounds)
        found[name] = quartiles([seconds["exponents"][turn] / seconds["motion"][turn] for turn in seconds["motion"]])
    return found


def main() -> None:
    """Print the tables, put them into the page and keep the results."""
    parser = argparse.ArgumentParser(description="Check values of Lyapunov exponents, and what they cost.")
    parser.add_argument("--rounds", type=int, default=15, help="turns of motion and exponents (default 15)")
    rounds = parser.parse_args().rounds
    results = {
        "machine": machine("scipy"),
        "rows": [row_of(name) for name in BODIES],
        "differences": differences(),
        "cost": costs(rounds),
    }
    made = tables(results)
    print("\n\n".join(made.values()))
    refresh(PAGE, made)
    keep(RESULTS, results)


if __name__ == "__main__":
    main()
