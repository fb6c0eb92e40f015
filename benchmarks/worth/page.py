"""The measurements as tables in Markdown, and their places in the page."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from .cost import RUNS, SIMULATE, STEP, STEP_WITHOUT_MEMORY
from .experiments import BODIES, CHAOTIC, EPISODE, POLICIES, RANDOM, SEEDS, TASKS, WORDS
from .settings import ALL, ENVIRONMENT_DEFAULT, name_of, REFERENCE, SIMULATE_DEFAULT, TOLERANCES
from .summary import exponent_from, Loss, loss, tolerance_effect

__all__ = [
    "STATISTICS",
    "exponent",
    "price",
    "return_loss",
    "score_loss",
    "speed_error",
    "tables",
    "trained",
]

Results = Mapping[str, Any]

STATISTICS = ("mean", "variance", "memory capacity")
_DIGITS = 1e-12  # differences below this share are rounding
_REPEATABLE = 1e-9  # a speed that differs by more between the two tightest tolerances is of chaotic motion


def tables(results: Results) -> dict[str, str]:
    """Every table by its name."""
    makers: dict[str, Callable[[Results], str]] = {
        "scores": _scores,
        "score differences": _score_differences,
        "crawling": _crawling,
        "policies": _policies,
        "training": _training,
        "parting": _parting,
        "chaos": _chaos,
        "cost": _cost,
        "simulate": _simulate_step,
        "environment": _environment_step,
    }
    return {name: make(results) for name, make in makers.items()}


def score_loss(results: Results, body: str, task: str, tolerance: float) -> Loss:
    """Loss of a task's score."""
    return loss(*(results[f"tasks/{body}/{name_of(t)}"][task] for t in (tolerance, REFERENCE)))


def return_loss(results: Results, body: str, policy: str, tolerance: float) -> Loss:
    """Loss of a fixed policy's return."""
    return loss(*(results[f"fixed policy/{body}/{name_of(t)}"][policy]["return"] for t in (tolerance, REFERENCE)))


def speed_error(results: Results, body: str, schedule: str, tolerance: float) -> float:
    """Largest relative error of a schedule's speed."""
    speed, true = (
        np.array(results[f"crawling/{body}/{name_of(t)}"][schedule]["speed"]) for t in (tolerance, REFERENCE)
    )
    return float(np.max(np.abs(speed / true - 1.0)))


def trained(results: Results, lesson: str, tolerance: float) -> dict[str, list[float]]:
    """What the policies trained at a tolerance came to, by seed."""
    prefix = f"trained/{lesson}/{name_of(tolerance)}/"
    records = [record for key, record in results.items() if key.startswith(prefix)]
    return {name: [record[name] for record in records] for name in records[0]}


def exponent(results: Results, duffing: float) -> float:
    """Rate at which chaotic motions part, over the tolerances between coarse and rounding."""
    middle = [tolerance for tolerance in TOLERANCES if 1e-9 <= tolerance <= 1e-3]
    parted = [np.median(results[f"chaos/{duffing}/{name_of(tolerance)}"]["parted"]) for tolerance in middle]
    return exponent_from(middle, parted)


def _scores(results: Results) -> str:
    rows = []
    for body in BODIES:
        for task in TASKS:
            true = results[f"tasks/{body}/{name_of(REFERENCE)}"][task]
            shares = [_share(score_loss(results, body, task, t).relative) for t in TOLERANCES]
            rows.append([body, task, f"{np.mean(true):.3f}", f"{np.std(true, ddof=1):.3f}", *shares])
    return _markdown(["body", "score", "mean", "spread", *map(name_of, TOLERANCES)], rows, left=2)


def _score_differences(results: Results) -> str:
    shown = (1e-2, 1e-3, 1e-4, 1e-6, 1e-9)
    rows = []
    for body in BODIES:
        for task in TASKS:
            losses = [score_loss(results, body, task, t) for t in shown]
            rows.append([body, task, *(f"{each.bias:+.0e} ± {each.scatter:.0e}" for each in losses)])
    return _markdown(["body", "score", *map(name_of, shown)], rows, left=2)


def _crawling(results: Results) -> str:
    rows = []
    for body in BODIES:
        for schedule in (*WORDS, RANDOM):
            true = results[f"crawling/{body}/{name_of(REFERENCE)}"][schedule]
            errors = [_share(speed_error(results, body, schedule, t)) for t in TOLERANCES]
            wrong = [_miscounted(results, body, schedule, t) for t in TOLERANCES]
            cells = [f"{error} ({slips})" for error, slips in zip(errors, wrong, strict=True)]
            name = schedule if repeatable(results, body, schedule) else f"{schedule}, chaotic"
            rows.append([body, name, f"{np.mean(true['speed']):.4f}", str(sum(true["slips"])), *cells])
    return _markdown(["body", "schedule", "speed", "slips", *map(name_of, TOLERANCES)], rows, left=2)


def repeatable(results: Results, body: str, schedule: str) -> bool:
    """Whether the motion can be had to any accuracy, as chaotic motion cannot."""
    return speed_error(results, body, schedule, TOLERANCES[-1]) < _REPEATABLE


def _miscounted(results: Results, body: str, schedule: str, tolerance: float) -> int:
    """Slips too many and too few, added over runs."""
    counted, true = (
        np.array(results[f"crawling/{body}/{name_of(t)}"][schedule]["slips"]) for t in (tolerance, REFERENCE)
    )
    return int(np.abs(counted - true).sum())


def _policies(results: Results) -> str:
    rows = []
    for body in BODIES:
        for policy in POLICIES:
            true = results[f"fixed policy/{body}/{name_of(REFERENCE)}"][policy]["return"]
            shares = [_share(return_loss(results, body, policy, t).relative) for t in TOLERANCES]
            changed = [_changed(results, body, policy, t) for t in TOLERANCES]
            cells = [f"{share} ({count})" for share, count in zip(shares, changed, strict=True)]
            rows.append([body, policy, f"{np.mean(true):.0f}", f"{np.std(true, ddof=1):.0f}", *cells])
    return _markdown(["body", "policy", "return", "spread", *map(name_of, TOLERANCES)], rows, left=2)


def _changed(results: Results, body: str, policy: str, tolerance: float) -> int:
    """Commands that differ from the reference's, of all episodes."""
    given, true = (
        "".join(results[f"fixed policy/{body}/{name_of(t)}"][policy]["commands"]) for t in (tolerance, REFERENCE)
    )
    return (int(given, 16) ^ int(true, 16)).bit_count()


def _training(results: Results) -> str:
    rows = []
    for lesson, tolerance in _trainings(results):
        record = trained(results, lesson, tolerance)
        judged = np.array(record["judged"])
        rows.append(
            [
                lesson,
                name_of(tolerance),
                " ".join(f"{reward:.4f}" for reward in judged),
                f"{judged.mean():.4f} ± {judged.std(ddof=1):.4f}",
                f"{np.max(np.abs(judged - record['as trained'])):.0e}",
                f"{np.median(record['seconds']):.0f}",
            ]
        )
    head = ["task", "trained at", "reward per step, by seed", "mean ± spread", "gap", "seconds"]
    return _markdown(head, rows, left=3)


def _trainings(results: Results) -> Iterable[tuple[str, float]]:
    """Tasks and tolerances that policies were trained at."""
    found = {tuple(key.split("/")[1:3]) for key in results if key.startswith("trained/")}
    return sorted(((lesson, float(tolerance)) for lesson, tolerance in found), key=lambda pair: (pair[0], -pair[1]))


def _parting(results: Results) -> str:
    rows = []
    for duffing in CHAOTIC:
        times = [np.median(results[f"chaos/{duffing}/{name_of(t)}"]["parted"]) for t in TOLERANCES]
        rows.append([str(duffing), f"{exponent(results, duffing):.3f}", *(f"{time:.0f}" for time in times)])
    return _markdown(["Pi1", "rate", *map(name_of, TOLERANCES)], rows, left=1)


def _chaos(results: Results) -> str:
    rows = []
    for duffing in CHAOTIC:
        for statistic in STATISTICS:
            table = np.array([results[f"chaos/{duffing}/{name_of(t)}"][statistic] for t in ALL])
            error = table.std(axis=1, ddof=1) / np.sqrt(table.shape[1])
            cells = [f"{mean:.4f} ± {one:.4f}" for mean, one in zip(table.mean(axis=1), error, strict=True)]
            shown = [cells[ALL.index(t)] for t in (1e-2, 1e-4, 1e-6, 1e-9, REFERENCE)]
            rows.append([str(duffing), statistic, *shown, f"{tolerance_effect(table):.2f}"])
    head = ["Pi1", "statistic", *map(name_of, (1e-2, 1e-4, 1e-6, 1e-9, REFERENCE)), "p"]
    return _markdown(head, rows, left=2)


def _cost(results: Results) -> str:
    rows = []
    for job, unit, default in (
        (SIMULATE, "time unit", SIMULATE_DEFAULT),
        (STEP, "step", ENVIRONMENT_DEFAULT),
        (STEP_WITHOUT_MEMORY, "step", ENVIRONMENT_DEFAULT),
    ):
        for body in BODIES:
            for run in RUNS:
                cells = [results[f"cost/{run}"][job][body][name_of(t)] for t in ALL]
                texts = [f"{c['microseconds'][1]:.2f} ({_ratio(c['times'][name_of(default)])})" for c in cells]
                rows.append([f"{job}, us per {unit}", body, run, *texts])
    return _markdown(["", "body", "run", *map(name_of, ALL)], rows, left=3)


def _simulate_step(results: Results) -> str:
    schedules = {
        body: [schedule for schedule in (*WORDS, RANDOM) if repeatable(results, body, schedule)] for body in BODIES
    }
    rows = []
    for tolerance in _neighbours(SIMULATE_DEFAULT):
        scores = [_share(max(score_loss(results, b, task, tolerance).relative for task in TASKS)) for b in BODIES]
        speeds = [_share(max(speed_error(results, b, each, tolerance) for each in schedules[b])) for b in BODIES]
        wrong = sum(_miscounted(results, b, each, tolerance) for b in BODIES for each in schedules[b])
        prices = _prices(results, SIMULATE, tolerance, SIMULATE_DEFAULT)
        rows.append([_bold(tolerance, SIMULATE_DEFAULT), *scores, *speeds, str(wrong), *prices])
    head = ["tolerance", *_each("scores"), *_each("speed"), "slips miscounted", *_each("cost")]
    return _markdown(head, rows, left=1)


def _environment_step(results: Results) -> str:
    rows = []
    for tolerance in _neighbours(ENVIRONMENT_DEFAULT):
        shares = [
            _share(max(return_loss(results, b, policy, tolerance).relative for policy in POLICIES)) for b in BODIES
        ]
        changed = sum(_changed(results, body, policy, tolerance) for body in BODIES for policy in POLICIES)
        prices = [_prices(results, job, tolerance, ENVIRONMENT_DEFAULT) for job in (STEP, SIMULATE)]
        rows.append([_bold(tolerance, ENVIRONMENT_DEFAULT), *shares, str(changed), *prices[0], *prices[1]])
    total = len(BODIES) * len(POLICIES) * len(SEEDS) * EPISODE
    head = ["tolerance", *_each("return"), f"commands changed, of {total}"]
    head += [*_each("cost of a step"), *_each("cost of simulate")]
    return _markdown(head, rows, left=1)


def _each(what: str) -> list[str]:
    return [f"{what}, {body}" for body in BODIES]


def _neighbours(default: float) -> Sequence[float]:
    """One step looser, the default, one step tighter."""
    at = TOLERANCES.index(default)
    return TOLERANCES[at - 1 : at + 2]


def price(results: Results, job: str, body: str, tolerance: float, default: float) -> list[float]:
    """Median cost as a multiple of a default's, of every run."""
    return [results[f"cost/{run}"][job][body][name_of(tolerance)]["times"][name_of(default)][1] for run in RUNS]


def _prices(results: Results, job: str, tolerance: float, default: float) -> list[str]:
    """Of every body, as text."""
    return [" / ".join(f"{each:.2f}" for each in price(results, job, body, tolerance, default)) for body in BODIES]


def _bold(tolerance: float, default: float) -> str:
    return f"**{name_of(tolerance)}**" if tolerance == default else name_of(tolerance)


def _ratio(quartiles: Sequence[float]) -> str:
    low, middle, high = quartiles
    return f"{middle:.2f} [{low:.2f}, {high:.2f}]"


def _share(value: float) -> str:
    """One digit, or that there is nothing but rounding."""
    return f"{value:.0e}" if value >= _DIGITS else "0"


def _markdown(head: Sequence[str], rows: Iterable[Sequence[str]], *, left: int) -> str:
    rule = ["---"] * left + ["---:"] * (len(head) - left)
    return "\n".join("| " + " | ".join(row) + " |" for row in (head, rule, *rows))
