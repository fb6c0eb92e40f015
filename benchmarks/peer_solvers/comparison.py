"""What each solver costs, and how many times stickslip's cost that is at equal error."""

from collections.abc import Iterable
from functools import partial
from typing import Any

from measuring import quartiles, take_turns

from peer_solvers.own import KERNEL, LIBRARY, SIMULATE
from peer_solvers.problem import Contender, FOOT, HOLD, WORD

__all__ = ["GOALS", "Row", "cheapest", "measure", "meet"]

GOALS = (1e-3, 1e-6, 1e-9, 1e-12)
# Rounding alone comes to this at the end, and a smaller error is luck.
ROUNDING = 1e-13
BUDGET = 1.5  # seconds for each setting of a solver, after which it sits rounds out
DURATION = HOLD * len(WORD)

Row = dict[str, Any]


def measure(contenders: list[Contender], rounds: int) -> list[Row]:
    """Error and cost of every solver, and its cost as a ratio to stickslip's at no greater error."""
    rows = []
    for contender in contenders:
        foot, slips = contender.run(WORD)
        row = contender._asdict() | {"foot": foot, "slips": slips, "error": abs(foot - FOOT)}
        del row["run"]
        rows.append(row)
    works = {str(i): partial(contender.run, WORD) for i, contender in enumerate(contenders)}
    for row, turns in zip(rows, take_turns(works, rounds, BUDGET).values(), strict=True):
        row["turns"] = {turn: seconds * 1e6 / DURATION for turn, seconds in turns.items()}
        row["microseconds per time unit"] = quartiles(list(row["turns"].values()))
    for row in rows:
        row["times stickslip"] = {
            method: ratio(row, cheapest(rows, LIBRARY, method, row["error"])) for method in (KERNEL, SIMULATE)
        }
    return rows


def median(row: Row) -> float:
    """Microseconds per time unit."""
    return float(row["microseconds per time unit"][1])


def cheapest(rows: list[Row], library: str, method: str, error: float) -> Row | None:
    """The cheapest setting of a method that is no less accurate than `error`, as are all tighter ones tried.

    A loose setting that comes out right by luck is not taken.
    """
    settings = [row for row in rows if (row["library"], row["method"]) == (library, method)]
    safe = []
    for row in sorted(settings, key=lambda row: row["tolerance"]):
        if row["error"] > max(error, ROUNDING):
            break
        safe.append(row)
    return min(safe, key=median, default=None)


def ratio(row: Row, other: Row | None) -> Row | None:
    """Quartiles, over the rounds both took part in, of what `row` costs as a multiple of `other`."""
    if other is None:
        return None
    both = row["turns"].keys() & other["turns"].keys()
    return {
        "setting": other["setting"],
        "quartiles": quartiles([row["turns"][turn] / other["turns"][turn] for turn in both]),
    }


def meet(goal: float, rows: list[Row]) -> Iterable[Row]:
    """The cheapest setting there of each method that reaches an accuracy, and its cost as a multiple of stickslip's."""
    ours = {method: cheapest(rows, LIBRARY, method, goal) for method in (KERNEL, SIMULATE)}
    for library, method in dict.fromkeys((row["library"], row["method"]) for row in rows):
        best = cheapest(rows, library, method, goal)
        if best is not None:
            yield {
                "goal": goal,
                **{key: best[key] for key in ("library", "method", "setting", "error", "microseconds per time unit")},
                "times stickslip": {method: ratio(best, other) for method, other in ours.items()},
            }
