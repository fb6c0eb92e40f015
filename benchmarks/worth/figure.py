"""The figure: what each result loses against what it costs, and what is left of chaotic motion."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from stickslip.common.extras import optional_import
from stickslip.common.figures import house_style, MARKERS, OKABE_ITO, PAGE_WIDTH, SMALL

from .cost import SIMULATE, STEP
from .experiments import BODIES, CHAOTIC, POLICIES, RANDOM, TASKS, WORDS
from .page import exponent, price, repeatable, return_loss, score_loss, speed_error, STATISTICS, trained
from .settings import ALL, ENVIRONMENT_DEFAULT, name_of, SIMULATE_DEFAULT, TOLERANCES
from .summary import deviations

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

__all__ = ["draw"]

Results = Mapping[str, Any]
Error = Callable[[str, str, float], float]  # of a body, a result and a tolerance

_DEFAULT, _LIVELY = BODIES
_LINES = {_DEFAULT: "-", _LIVELY: "--"}
_DEFAULTS = {SIMULATE: SIMULATE_DEFAULT, STEP: ENVIRONMENT_DEFAULT}
_BELOW: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.45, -0.2), "ncols": 2}  # of a panel, its legend
_NAMES = {SIMULATE: "simulate", STEP: "a step"}
_QUESTIONS = (
    "what do scores lose?",
    "what does the speed lose?",
    "what does a policy's return lose?",
    "do policies learn less?",
    "when do chaotic motions part?",
    "are their statistics the same?",
)
_FLOOR = 3e-14  # where rounding hides the rest


def draw(results: Results) -> Figure:
    """Six panels, each of one question.

    Parameters
    ----------
    results : mapping
        By key, as `benchmarks/accuracy_worth.py` keeps them.
    """
    with house_style(), plt.rc_context({"font.size": SMALL, "axes.labelsize": SMALL, "svg.hashsalt": "accuracy_worth"}):
        figure, axes = plt.subplots(3, 2, figsize=(PAGE_WIDTH, 10.4), layout="constrained")
        (scores, speeds), (returns, training), (parting, statistics) = axes
        _against_cost(scores, results, SIMULATE, TASKS, lambda b, n, t: score_loss(results, b, n, t).relative, TASKS[0])
        scores.set(ylabel="error / spread over seeds")
        schedules = (*WORDS, RANDOM)
        _name_chaotic(speeds, results, schedules)
        _against_cost(speeds, results, SIMULATE, schedules, lambda b, n, t: speed_error(results, b, n, t), RANDOM)
        speeds.set(ylabel="relative error")
        policies = list(POLICIES)
        _against_cost(
            returns, results, STEP, policies, lambda b, n, t: return_loss(results, b, n, t).relative, policies[1]
        )
        returns.set(ylabel="error / spread over seeds")
        for panel in (scores, returns):
            _hundredth(panel)
        _draw_training(training, results)
        _draw_parting(parting, results)
        _draw_statistics(statistics, results)
        for letter, question, panel in zip("abcdef", _QUESTIONS, axes.flat, strict=True):
            panel.set_title(f"({letter}) {question}", loc="left")
    return figure


def _against_cost(panel: Axes, results: Results, job: str, names: Sequence[str], error: Error, labelled: str) -> None:
    """Error of each result against the cost of the tolerance, a curve for every result and body.

    The curve of the result `labelled`, of the lively body, has the tolerances written beside it.
    """
    styles = list(zip(names, OKABE_ITO, MARKERS, strict=False))
    for body, line in _LINES.items():
        cost = [_cost(results, job, body, tolerance) for tolerance in TOLERANCES]
        for name, color, marker in styles:
            errors = np.maximum([error(body, name, tolerance) for tolerance in TOLERANCES], _FLOOR)
            face = color if line == "-" else "white"
            panel.plot(cost, errors, marker, ls=line, lw=0.9, ms=3.5, color=color, mfc=face)
            if name == labelled and body == _LIVELY:
                _label_tolerances(panel, cost, errors)
    panel.axvline(1.0, color="0.6", lw=0.7, zorder=0)
    default = _DEFAULTS[job]
    panel.set(yscale="log", ylim=(_FLOOR / 3, 10), xlabel=f"cost of {_NAMES[job]} / that at ${_power(default)}$")
    handles = [Line2D([], [], color=color, marker=marker, ls="", ms=3.5, label=name) for name, color, marker in styles]
    handles += [Line2D([], [], color="0.3", lw=0.9, ls=line, label=f"{body} body") for body, line in _LINES.items()]
    handles.append(Line2D([], [], color="0.6", lw=0.7, label=f"default, ${_power(default)}$"))
    panel.legend(handles=handles, fontsize=SMALL, handlelength=2.2, labelspacing=0.25, **_BELOW)


def _name_chaotic(panel: Axes, results: Results, schedules: Sequence[str]) -> None:
    """Say of a curve that does not fall why it does not."""
    tightest = TOLERANCES[-1]
    for body in BODIES:
        for schedule in schedules:
            if not repeatable(results, body, schedule):
                end = (_cost(results, SIMULATE, body, tightest), speed_error(results, body, schedule, tightest))
                panel.annotate(
                    "chaotic", end, xytext=(0, 5), textcoords="offset points", fontsize=SMALL, color="0.35", ha="right"
                )


def _label_tolerances(panel: Axes, cost: Sequence[float], errors: Sequence[float]) -> None:
    for tolerance, x, y in zip(TOLERANCES, cost, errors, strict=True):
        if tolerance == TOLERANCES[1]:  # there is no room between its neighbours
            continue
        panel.annotate(
            f"${_power(tolerance)}$", (x, y), xytext=(5, 3), textcoords="offset points", fontsize=SMALL, color="0.35"
        )


def _power(tolerance: float) -> str:
    return f"10^{{{np.log10(tolerance):.0f}}}"


def _cost(results: Results, job: str, body: str, tolerance: float) -> float:
    """Cost as a multiple of the default's, mean of the runs."""
    return float(np.mean(price(results, job, body, tolerance, _DEFAULTS[job])))


def _hundredth(panel: Axes) -> None:
    panel.axhspan(_FLOOR / 3, 1e-2, color="0.94", lw=0, zorder=-1)


def _draw_training(panel: Axes, results: Results) -> None:
    """Reward per step of every trained policy in a world of high accuracy, less that of the best of its task."""
    found = {tuple(key.split("/")[1:3]) for key in results if key.startswith("trained/")}
    lessons = sorted({lesson for lesson, _ in found})
    tolerances = sorted({float(tolerance) for _, tolerance in found}, reverse=True)
    for index, (lesson, color, marker) in enumerate(zip(lessons, OKABE_ITO, MARKERS, strict=False)):
        judged = np.array([trained(results, lesson, tolerance)["judged"] for tolerance in tolerances])
        seeds = judged.shape[1]
        across = np.arange(len(tolerances))[:, None] + 0.22 * (index - 0.5) + np.linspace(-0.06, 0.06, seeds)
        shortfall = 100.0 * (judged / judged.max() - 1.0)
        label = f"{lesson}: best {judged.max():.4f} a step"
        panel.plot(across.ravel(), shortfall.ravel(), marker, ms=4, color=color, mfc="none", label=label)
    panel.axhline(0.0, color="0.6", lw=0.7, zorder=0)
    panel.set_xticks(range(len(tolerances)), [f"${_power(tolerance)}$" for tolerance in tolerances])
    panel.set(xlabel="tolerance in training", ylabel="reward, less the best of its task (%)")
    panel.set(ylim=(min(-1.0, 1.3 * panel.get_ylim()[0]), 0.2))
    panel.legend(fontsize=SMALL, loc="lower left", title="judged at $10^{-12}$", title_fontsize=SMALL)


def _draw_parting(panel: Axes, results: Results) -> None:
    """When chaotic motions part from the reference."""
    for duffing, color, marker in zip(CHAOTIC, OKABE_ITO, MARKERS, strict=False):
        times = np.array([results[f"chaos/{duffing}/{name_of(t)}"]["parted"] for t in TOLERANCES])
        low, middle, high = np.quantile(times, [0.25, 0.5, 0.75], axis=1)
        label = f"$\\Pi_1$ = {duffing}: rate {exponent(results, duffing):.3f}"
        errors = [middle - low, high - middle]
        panel.errorbar(TOLERANCES, middle, errors, marker=marker, ms=3.5, lw=0.9, color=color, label=label)
    panel.set(xscale="log", xlabel="tolerance", ylabel="time until apart ($t_c$)")
    panel.invert_xaxis()
    panel.legend(fontsize=SMALL, loc="upper left")


def _draw_statistics(panel: Axes, results: Results) -> None:
    """Statistics of chaotic motion at each tolerance, less their mean over tolerances."""
    places = np.arange(len(ALL))
    kinds = [(duffing, statistic) for statistic in STATISTICS for duffing in CHAOTIC]
    for index, (duffing, statistic) in enumerate(kinds):
        table = np.array([results[f"chaos/{duffing}/{name_of(t)}"][statistic] for t in ALL])
        middle, error = (100.0 * each / table.mean() for each in deviations(table))
        group, member = divmod(index, len(CHAOTIC))
        panel.errorbar(
            places + 0.08 * (index - (len(kinds) - 1) / 2),
            middle,
            error,
            fmt=MARKERS[member],
            ms=2.5,
            lw=0.7,
            color=OKABE_ITO[group],
        )
    panel.axhline(0.0, color="0.6", lw=0.7, zorder=0)
    panel.set_xticks(places, [f"{np.log10(t):.0f}".replace("-", "−") for t in ALL])
    panel.set(xlabel="tolerance, as a power of ten", ylabel="deviation from their mean (%)")
    handles = [
        Line2D([], [], color=color, lw=1.3, label=name) for name, color in zip(STATISTICS, OKABE_ITO, strict=False)
    ]
    handles += [
        Line2D([], [], color="0.3", marker=marker, ls="", ms=2.5, label=f"$\\Pi_1$ = {duffing}")
        for duffing, marker in zip(CHAOTIC, MARKERS, strict=False)
    ]
    panel.legend(handles=handles, fontsize=SMALL, labelspacing=0.25, **_BELOW)
