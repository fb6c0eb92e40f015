"""What every solver needs for the crawlers at the edges of the ranges: its steps, and its error in tolerances.

`python tests/judges/counted_steps.py` counts and measures them, and writes them to `counted_steps.json`. The error is
that of the stored 50-digit references; of a row without one it is the distance from the run at the finest tolerance.
It is steady where a start that differs by a few roundings has it too, and where it is larger than what they come to.
"""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from extreme_rows import LIGHT, Row, ROWS, stored

from stickslip.common.files import atomically
from stickslip.crawler import Groups, Scene, simulate, SolverError, State
from stickslip.crawler.solvers import solvers_for

__all__ = ["COUNTED", "NO_BOUND", "STEADY", "TABLE", "TOLERANCES", "attempt", "cases", "error_of", "written"]

TABLE = Path(__file__).with_name("counted_steps.json")
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12, 1e-15)
FINEST = TOLERANCES[-1]
NO_BOUND = 2_000_000
# The part of itself by which a steady error may move, and the least that rounding leaves alone.
STEADY, LEAST_STEADY = 0.01, 1e-11
SAMPLED = ("deformation", "velocity", "foot", "foot_velocity")
SYMMETRIC = Scene(ratchet=False)

# Without a reference: what the extremes do not ask of a step.
MORE = {
    "free both ways": Row(Groups(static_friction=0.0, kinetic_friction=0.0), "11110000", scene=SYMMETRIC),
    "free both ways, undamped": Row(
        Groups(damping_ratio=0.0, static_friction=0.0, kinetic_friction=0.0), "10", 20.0, scene=SYMMETRIC
    ),
    "uphill": Row(scene=Scene(slope=0.2)),
    "downhill both ways": Row(scene=Scene(slope=-0.2, ratchet=False)),
    "anchored": Row(Groups(duffing=50.0), scene=Scene(anchored=True)),
    "anchored and faint": Row(valve="0", hold=50.0, scene=Scene(anchored=True), initial=State(1e-7)),
    "at rest": Row(valve="0", hold=1e3),
    "unstable": Row(Groups(duffing=0.1, radial_coupling=2.0, damping_ratio=1.0), "1100", 2.0),
    "unstable, from its top": Row(
        Groups(duffing=0.0, radial_coupling=2.0, deborah=1e6, static_friction=9.0),
        "1",
        8.0,
        initial=State(-1.0 + 1e-4, 0.0, 1.0),
    ),
    "stiff and grazing": Row(
        Groups(damping_ratio=1e2, static_friction=2e-3, kinetic_friction=2e-3), scene=SYMMETRIC, samples_per_hold=3
    ),
    "light foot, faint friction": Row(
        Groups(foot_mass_fraction=LIGHT, static_friction=1e-4, kinetic_friction=1e-4), scene=SYMMETRIC
    ),
    "faint friction": Row(Groups(static_friction=1e-5, kinetic_friction=5e-6), "1100", scene=SYMMETRIC),
    "sliding at the start": Row(initial=State(0.2, -0.3, 0.5, 0.1, 0.7)),
    "chain of two": Row(Groups(duffing=50.0), scene=Scene(segments=2, tube_mass=0.3)),
    "chain of three, both ways": Row(
        Groups(duffing=20.0, damping_ratio=0.02), scene=Scene(segments=3, tube_mass=4.0, ratchet=False)
    ),
    "chain of two, anchored": Row(
        Groups(duffing=300.0, radial_coupling=0.0), scene=Scene(segments=2, tube_mass=4.0, anchored=True)
    ),
    "chain of twelve, light": Row(scene=Scene(segments=12, tube_mass=0.05)),
    "chain of eight, overdamped": Row(Groups(damping_ratio=2.0), scene=Scene(segments=8, tube_mass=0.3)),
}
COUNTED = ROWS | MORE
# A Taylor series takes more steps than any budget, or slips on its own error, of the size of the friction.
_LEFT_OUT = {
    ("four stiff", "taylor"),
    ("four stiff, slippery", "taylor"),
    ("linear, four stiff", "taylor"),
    ("Pi2 = 1e4", "taylor"),
    ("Pi2 = 1e4, default friction", "taylor"),
    ("light foot, faint friction", "taylor"),
}


def cases(name: str) -> list[tuple[str, float]]:
    """The solvers and tolerances by which a row is counted."""
    row = COUNTED[name]
    solvers = [solver for solver in solvers_for(row.groups, row.scene) if (name, solver) not in _LEFT_OUT]
    return [(solver, tolerance) for solver in solvers for tolerance in TOLERANCES]


def attempt(row: Row, solver: str, tolerance: float, max_steps: int):
    """The trajectory, or None where the budget was spent."""
    try:
        return simulate(
            row.groups,
            row.schedule,
            row.hold,
            tolerance=tolerance,
            solver=solver,
            max_steps=max_steps,
            **row.options,
        )
    except SolverError as error:
        if not str(error).startswith(f"the step budget of {max_steps} was spent at time "):
            raise
        return None


@cache
def _reference(name: str) -> dict[str, np.ndarray]:
    if name in ROWS:
        return {key: np.array(values, dtype=float) for key, values in stored()[name]["samples"].items()}
    row = COUNTED[name]
    finest = attempt(row, solvers_for(row.groups, row.scene)[0], FINEST, NO_BOUND)
    return {key: getattr(finest, key) for key in SAMPLED}


def error_of(name: str, done) -> float:
    """Largest error of a sample."""
    return max(float(np.abs(getattr(done, key) - values).max()) for key, values in _reference(name).items())


def written() -> dict[str, dict[str, list]]:
    """Steps, error in tolerances and whether that is steady, by row and by solver and tolerance."""
    return json.loads(TABLE.read_text(encoding="utf-8"))


def _steps(row: Row, solver: str, tolerance: float) -> int:
    """The least budget that is enough."""
    low, high = 0, 1
    while attempt(row, solver, tolerance, high) is None:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if attempt(row, solver, tolerance, middle) is None else (low, middle)
    return high


def _is_steady(name: str, solver: str, tolerance: float, error: float) -> bool:
    if error * tolerance < LEAST_STEADY:
        return False
    row = COUNTED[name]
    for roundings in (-16, -5, 1, 7):
        there = row.initial.deformation
        moved = row.initial._replace(deformation=there + roundings * 2.0**-53 * max(1.0, abs(there)))
        done = attempt(replace(row, initial=moved), solver, tolerance, NO_BOUND)
        if abs(error_of(name, done) / tolerance - error) > STEADY * error:
            return False
    return True


def _count() -> None:
    table: dict[str, dict[str, list]] = {}
    for name, row in COUNTED.items():
        table[name] = {}
        for solver, tolerance in cases(name):
            error = error_of(name, attempt(row, solver, tolerance, NO_BOUND)) / tolerance
            counts = [_steps(row, solver, tolerance), float(f"{error:.3g}"), _is_steady(name, solver, tolerance, error)]
            table[name][f"{solver} {tolerance:g}"] = counts
    rows = [f"  {json.dumps(name)}: {json.dumps(row)}" for name, row in table.items()]
    text = "{\n" + ",\n".join(rows) + "\n}\n"
    atomically(TABLE, lambda file: file.write_text(text, encoding="utf-8"))


if __name__ == "__main__":
    _count()
