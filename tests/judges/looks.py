"""How figures are drawn: every line, bar, shade, text and legend in words, with its numbers, its colours and its sizes.

`python tests/judges/looks.py` draws the figures from numbers that are made up, and writes the words to `looks.json`.
Other tests say what a figure has to show; this is for what nobody would think of, so that nothing of it moves unseen.
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.colors import to_hex

from stickslip.common.files import atomically
from stickslip.crawler import Groups, Scene, simulate
from stickslip.reservoir import Estimate, MemoryCapacity
from stickslip.studies.benchmark.figures import (
    plot_information,
    plot_predictions,
    plot_profiles,
    plot_scores,
    plot_sweep,
)
from stickslip.studies.benchmark.records import Record
from stickslip.studies.work_precision import (
    Case,
    plot_work_precision,
    recommend,
    Reference,
    Row,
    Timing,
    WorkPrecision,
)
from stickslip.studies.work_precision.case import DEFORMATION, FOOT, MEAN_SPEED, RMS_DEFORMATION, SLIP_RATE
from stickslip.tasks import plot_memory_profile, TASKS
from stickslip.train.evaluations import Evaluation, write_evaluations
from stickslip.train.figures import plot_learning, plot_trade
from stickslip.train.schedules import Performance

__all__ = ["FIGURES", "look_of", "written"]

TABLE = Path(__file__).with_name("looks.json")


def numbers(values):
    """To six digits, as text."""
    return " ".join(f"{float(value) + 0.0:.6g}" for value in np.ravel(np.ma.filled(values, np.nan)))


def color(value):
    """As hexadecimal digits, with opacity; several where there are several."""
    if isinstance(value, str) or np.ndim(value) == 1:
        return value if isinstance(value, str) and value == "none" else to_hex(value, keep_alpha=True)
    return ",".join(to_hex(each, keep_alpha=True) for each in value)


def text_of(text):
    """A text, its place, size and colour."""
    place = numbers(text.get_position())
    look = f"{text.get_ha()} {text.get_va()} {text.get_fontsize():g} {color(text.get_color())}"
    return f"{text.get_text()!r} at {place} {look}"


def artist(each):
    """One thing that is drawn: kind, label, look and place."""
    words = [type(each).__name__, repr(each.get_label()), f"z{each.get_zorder():g}", f"alpha {each.get_alpha()}"]
    if isinstance(each, mpl.lines.Line2D):
        words += [each.get_linestyle(), f"{each.get_linewidth():g}", color(each.get_color())]
        words += [str(each.get_marker()), f"{each.get_markersize():g}", color(each.get_markerfacecolor())]
        words += [color(each.get_markeredgecolor()), f"{each.get_markeredgewidth():g}", numbers(each.get_xydata())]
    elif isinstance(each, mpl.collections.Collection):
        words += [color(each.get_facecolor()), color(each.get_edgecolor()), numbers(each.get_linewidth())]
        words += ["dashes " + numbers(dashes or ()) for _, dashes in each.get_linestyle()]
        words += [numbers(path.vertices) for path in each.get_paths()]
    elif isinstance(each, mpl.patches.Patch):
        words += [color(each.get_facecolor()), color(each.get_edgecolor()), f"{each.get_linewidth():g}"]
        words += [str(each.get_hatch()), numbers(each.get_patch_transform().transform(each.get_path().vertices))]
    elif isinstance(each, mpl.text.Text):
        words += [text_of(each), numbers(each.xy), str(each.anncoords), str(each.get_path_effects() != [])]
    return " | ".join(words)


def legend_of(legend):
    """Its entries, and how they are set."""
    words = [repr(text.get_text()) for text in legend.get_texts()]
    words += [repr(legend.get_title().get_text()), f"{legend.get_title().get_fontsize():g}"]
    words += [f"columns {legend._ncols}", f"loc {legend._loc} {getattr(legend, '_outside_loc', None)}"]
    anchor = legend.get_bbox_to_anchor().transformed(legend.axes.transAxes.inverted()) if legend.axes else None
    words += [numbers(anchor.bounds) if anchor else "", numbers([text.get_fontsize() for text in legend.get_texts()])]
    return "legend " + " | ".join(words + [type(handle).__name__ for handle in legend.legend_handles])


def axes_of(ax):
    """What lies in axes, and they themselves."""
    grid = ax.get_subplotspec().get_gridspec()
    yield f"axes {ax.axison} of {grid.nrows} {grid.ncols}, heights {grid.get_height_ratios()}"
    for name, axis, limits, shared in (
        ("x", ax.xaxis, ax.get_xlim(), ax.get_shared_x_axes()),
        ("y", ax.yaxis, ax.get_ylim(), ax.get_shared_y_axes()),
    ):
        tick = axis.get_major_ticks()[0]
        fixed = isinstance(axis.get_major_formatter(), mpl.ticker.FixedFormatter)
        labels = [label.get_text() for label in axis.get_ticklabels()] if fixed else ""
        yield (
            f"{name} {axis.get_scale()} {numbers(limits)} | {axis.label.get_text()!r} | shared by "
            f"{len(shared.get_siblings(ax))} | {labels} | {type(axis.get_major_locator()).__name__} "
            f"{type(axis.get_minor_locator()).__name__} {type(axis.get_minor_formatter()).__name__} | "
            f"{tick.tick1line.get_markersize():g} {tick.label1.get_visible()} {tick.gridline.get_visible()} "
            f"{color(tick.gridline.get_color())} {tick.gridline.get_linewidth():g}"
        )
    for title in (ax._left_title, ax.title, ax._right_title):
        if title.get_text():
            yield f"title {title.get_text()!r} {title.get_fontsize():g} {title.get_ha()}"
    yield "spines " + " ".join(name for name, spine in ax.spines.items() if spine.get_visible())
    for each in (*ax.lines, *ax.collections, *ax.patches, *ax.texts, *ax.images):
        yield artist(each)
    if ax.get_legend() is not None:
        yield legend_of(ax.get_legend())


def look_of(figure):
    """The figure as a list of texts."""
    said = [f"figure {numbers(figure.get_size_inches())} {type(figure.get_layout_engine()).__name__}"]
    said += [text_of(text) for text in (figure._suptitle, figure._supxlabel, figure._supylabel) if text is not None]
    said += [legend_of(legend) for legend in figure.legends]
    for ax in figure.axes:
        said += axes_of(ax)
    return said


# The figures


def _estimates(*means):
    return [Estimate(mean, mean - 0.0625, mean + 0.125, 3) for mean in means]


def _scores(*, against=None):
    names, tasks = ("crawler", "delay line", "other"), ("NARMA-2 NRMSE", "NARMA-5 NRMSE", "waveform accuracy")
    found = {
        (task, name): one
        for row, task in enumerate(tasks)
        for name, one in zip(names, _estimates(0.25 + row, 0.5, 0.75), strict=True)
    }
    return plot_scores(found, TASKS, against=against)


def _records(task, **details):
    return [
        Record(task, name, seed, 0.5 + 0.25 * seed, {key: make(k + seed) for key, make in details.items()})
        for k, name in enumerate(("crawler", "delay line", "other", "one more"))
        for seed in range(2)
    ]


def _work_precision(*, comparable=True):
    case = Case(Groups(duffing=0.75), Scene(slope=0.0625), holds=4)
    run = simulate(case.groups, [0.0] * 4, case.hold)
    floors = {FOOT: 1e-12, DEFORMATION: 1e-13}
    if not comparable:
        floors = {MEAN_SPEED: 0.01, SLIP_RATE: 0.02, RMS_DEFORMATION: 0.005}
    rows = tuple(
        Row(solver, tolerance, dict.fromkeys(floors, scale * tolerance), 3, agree, Timing(0.75 * t, t, 1.5 * t))
        for solver, tolerance, scale, t, agree in (
            ("taylor", 1e-3, 0.5, 1.0, False),
            ("taylor", 1e-6, 0.25, 4.0, True),
            ("radau", 1e-6, 0.125, 16.0, True),
        )
    )
    made = WorkPrecision(case, Reference("taylor", run, (), comparable, {}, floors, (3,)), rows, (), 100.0)
    return plot_work_precision(made, recommend(made, 1e-5))


def _memory(count):
    delays = np.arange(count)
    return MemoryCapacity(delays, 0.5**delays, cutoff=0.03125, bound=7)


def _performances(**each):
    return {
        name: Performance(speed, MemoryCapacity(np.arange(1), np.array([memory]), 0.0, 1))
        for name, (speed, memory) in each.items()
    }


def _trade():
    schedules = _performances(**{"0": (0.0, 0.5), "10": (0.25, 0.75), "110": (0.5, 0.25), "100": (0.125, 0.125)})
    return plot_trade(schedules, _performances(slow=(0.125, 0.875), fast=(0.75, 0.5)))


def _learning():
    with TemporaryDirectory() as folder:
        table = Path(folder) / "evaluations.csv"
        write_evaluations(table, [Evaluation(100 * k, 0.25 * k, 0.5 * k, 1.0 / k) for k in (1, 2, 4)])
        return plot_learning(table)


FIGURES = {
    "crawler": {
        "trajectory": lambda: simulate({"duffing": 0.0, "radial_coupling": 0.0}, [1, 1, 1, 0.25, 0, 0], 1.0).plot(),
    },
    "tasks": {
        "memory": lambda: plot_memory_profile({"crawler": _memory(4), "delay line": _memory(6)}),
    },
    "train": {
        "trade": _trade,
        "learning": _learning,
    },
    "studies": {
        "scores": _scores,
        "differences": lambda: _scores(against="network"),
        "profiles": lambda: plot_profiles(
            [
                record
                for task in ("memory capacity", "parity-2 capacity")
                for record in _records(task, profile=lambda k: [1.0, 0.5, 0.25 * (k == 0), 0.0, 0.0])
            ]
        ),
        "information": lambda: plot_information(
            _records("information capacity", **{"by degree": lambda k: {"1": 2.0, "2": 0.5 * k}, "rank": lambda k: k})
        ),
        "predictions": lambda: plot_predictions(
            [
                record
                for task in ("NARMA-2 NRMSE", "NARMA-5 NRMSE", "Lorenz NRMSE")
                for record in _records(task, prediction=lambda k: [k, 0.5, 1.0], target=lambda k: [0.25, 0.5, k])
            ]
        ),
        "sweep": lambda: plot_sweep(
            "deborah",
            [0.5, 1.0, 4.0],
            {name: _estimates(1.0, 2.0, 1.5) for name in ("NARMA-2 NRMSE", "memory capacity")},
            TASKS,
        ),
        "work and precision": _work_precision,
        "work and statistics": lambda: _work_precision(comparable=False),
    },
}
"""What draws each, by folder and name."""


def written():
    """The words of each figure, by folder and name."""
    return json.loads(TABLE.read_text(encoding="utf-8"))


def _write():
    looks = {folder: {name: look_of(draw()) for name, draw in each.items()} for folder, each in FIGURES.items()}
    text = json.dumps(looks, indent=1, ensure_ascii=False) + "\n"
    atomically(TABLE, lambda file: file.write_text(text, encoding="utf-8"))
    plt.close("all")


if __name__ == "__main__":
    mpl.use("agg")
    _write()
