"""Figures of a benchmark by their artists: what is written, and which number stands where."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.colors import to_hex
from matplotlib.container import BarContainer, ErrorbarContainer

from stickslip.reservoir import Estimate, mean_over_runs
from stickslip.studies.benchmark.figures import (
    plot_information,
    plot_predictions,
    plot_profiles,
    plot_scores,
    plot_sweep,
)
from stickslip.studies.benchmark.figures.style import styles_of
from stickslip.studies.benchmark.records import Record
from stickslip.studies.benchmark.sweep import SWEPT
from stickslip.tasks import MEASURES, TASKS

mpl.use("agg")

KNOWN = {**TASKS, **MEASURES}
COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
MARKERS = "os^DvpX"
ONE_OF_EACH_UNIT = {
    "NARMA-2 NRMSE": "NRMSE (of the target's standard deviation)",
    "memory capacity": "capacity (functions of the input)",
    "waveform accuracy": "accuracy (share of samples)",
    "Lorenz valid time": "valid prediction time (Lyapunov times)",
    "kernel rank above 0.001": "rank (dimensions)",
    "echo index": "echo index (trajectories)",
}


@pytest.fixture(autouse=True)
def _closed():
    yield
    plt.close("all")


def legend_of(figure):
    [legend] = figure.legends
    return [text.get_text() for text in legend.get_texts()]


def place(segment):
    return [tuple(float(value) for value in point) for point in segment]


def test_scores_stand_at_their_means_between_the_ends_of_their_intervals():
    tasks = ("NARMA-2 NRMSE", "NARMA-5 NRMSE", "Lorenz NRMSE")
    found = {
        (task, name): Estimate(mean := 0.1 * row + 0.03 * column + 0.2, mean - 0.01, mean + 0.02, 5)
        for row, task in enumerate(tasks)
        for column, name in enumerate(("a", "b", "c", "d"))
    }
    figure = plot_scores(found, TASKS)
    [ax] = figure.axes
    bars = [each for each in ax.containers if isinstance(each, ErrorbarContainer)]
    assert [each.get_label() for each in bars] == legend_of(figure) == ["a", "b", "c", "d"]
    for column, (name, bar) in enumerate(zip("abcd", bars, strict=True)):
        rows = np.arange(3) + 0.62 * ((column + 0.5) / 4 - 0.5)
        mine = [found[task, name] for task in tasks]
        points = [(each.mean, row) for each, row in zip(mine, rows, strict=True)]
        np.testing.assert_allclose(bar[0].get_xydata(), points)
        assert (bar[0].get_color(), bar[0].get_marker()) == (COLORS[column], MARKERS[column])
        spans = [place(segment) for segment in bar[2][0].get_segments()]
        expected = [((each.low, row), (each.high, row)) for each, row in zip(mine, rows, strict=True)]
        np.testing.assert_allclose(spans, expected)
    assert [label.get_text() for label in ax.get_yticklabels()] == [f"{task} ↓" for task in tasks]
    assert ax.get_ylim() == (2.5, -0.5)  # the first row is on top
    # Every other row is shaded.
    assert [(patch.get_y(), patch.get_height()) for patch in ax.patches] == [(0.5, 1.0)]


def test_every_kind_of_score_has_a_panel_with_its_unit_and_its_chance():
    found = {(task, "a"): Estimate(2.0, np.nan, np.nan, 1) for task in ONE_OF_EACH_UNIT}
    figure = plot_scores(found, KNOWN)
    assert [ax.get_xlabel() for ax in figure.axes] == list(ONE_OF_EACH_UNIT.values())
    for ax, task in zip(figure.axes, ONE_OF_EACH_UNIT, strict=True):
        metric = KNOWN[task].metric
        assert ax.get_yticklabels()[0].get_text() == f"{task} {'↑' if metric.more_is_better else '↓'}"
        chance = [place(each.get_segments()[0]) for each in ax.collections if each.get_linestyle()[0][1]]
        assert chance == [[(metric.chance, -0.45), (metric.chance, 0.45)]]
        # Of a single seed there is no interval: the bar has no length.
        [bar] = ax.containers
        assert place(bar[2][0].get_segments()[0]) == [(2.0, 0.0), (2.0, 0.0)]


def test_differences_have_their_line_at_none_and_keep_their_colours():
    found = {("memory capacity", name): Estimate(0.5, 0.4, 0.6, 5) for name in ("b", "c")}
    [ax] = plot_scores(found, TASKS, against="a").axes
    assert ax.get_xlabel() == "difference from the a: capacity (functions of the input)"
    assert [bar[0].get_color() for bar in ax.containers] == COLORS[1:3]
    assert [bar[0].get_marker() for bar in ax.containers] == ["s", "^"]
    # Also where it is not differences that chance alone makes: an accuracy's chance is a half.
    accuracy = {("waveform accuracy", "b"): Estimate(0.1, 0.0, 0.2, 5)}
    [ax] = plot_scores(accuracy, TASKS, against="a").axes
    assert [place(e.get_segments()[0])[0][0] for e in ax.collections if e.get_linestyle()[0][1]] == [0.0]


def test_profiles_are_drawn_with_the_interval_of_every_delay():
    profiles = {
        "a": [[1.0, 0.5, 0.2, 0.03], [0.9, 0.7, 0.1, 0.0], [1.0, 0.6, 0.3, 0.0]],
        "b": [[0.5, 0.4, 0.3, 0.2]],
    }
    records = [
        Record(task, name, seed, 0.0, {"profile": profile})
        for task in ("memory capacity", "parity-2 capacity")
        for name, of_seeds in profiles.items()
        for seed, profile in enumerate(of_seeds)
    ]
    figure = plot_profiles(records)
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["memory capacity", "parity-2 capacity"]
    assert [ax.get_xlabel() for ax in figure.axes] == ["delay (samples)"] * 2
    assert [ax.get_ylabel() for ax in figure.axes] == ["capacity at this delay", ""]
    assert legend_of(figure) == ["a", "b"]
    for ax in figure.axes:
        assert [line.get_color() for line in ax.lines] == COLORS[:2]
        each = [mean_over_runs(values, bounds=(0.0, 1.0)) for values in np.array(profiles["a"]).T]
        np.testing.assert_allclose(ax.lines[0].get_xydata(), [(k, one.mean) for k, one in enumerate(each)])
        np.testing.assert_allclose(ax.lines[1].get_ydata(), profiles["b"][0])
        outline = {place([point])[0] for point in ax.collections[0].get_paths()[0].vertices}
        assert {(float(k), end) for k, one in enumerate(each) for end in (one.low, one.high)} <= outline
        assert to_hex(ax.collections[0].get_facecolor()[0]) == COLORS[0].lower()
        assert ax.get_xlim() == (-0.5, 5.5)  # four delays at least
        assert ax.get_ylim() == (-0.02, 1.05)


def test_profiles_end_where_all_have_forgotten():
    def drawn(last):
        profile = [0.5] * (last + 1) + [0.02] * (12 - last)
        other = [0.5, *[0.0] * 12]
        both = [Record("memory capacity", name, 0, 0.0, {"profile": p}) for name, p in (("a", profile), ("b", other))]
        [ax] = plot_profiles(both).axes
        return ax.get_xlim()[1]

    assert [drawn(last) for last in (2, 4, 9)] == [5.5, 5.5, 10.5]


def test_information_is_stacked_by_degree():
    details = {
        "a": [{"by degree": {"1": 2.0, "2": 1.0}, "rank": 4}, {"by degree": {"1": 3.0, "2": 0.5}, "rank": 5}],
        "b": [{"by degree": {"1": 1.0, "3": 0.25}, "rank": 12}],
    }
    records = [
        Record("information capacity", name, seed, sum(each["by degree"].values()), each)
        for name, of_seeds in details.items()
        for seed, each in enumerate(of_seeds)
    ]
    figure = plot_information(records)
    [ax] = figure.axes
    bars = {each.get_label(): each for each in ax.containers if isinstance(each, BarContainer)}
    spans = {label: [(bar.get_x(), bar.get_width()) for bar in each] for label, each in bars.items()}
    assert spans == {
        "degree 1 (memory)": [(0.0, 2.5), (0.0, 1.0)],
        "degree 2": [(2.5, 0.75), (1.0, 0.0)],
        "degree 3": [(3.25, 0.0), (1.0, 0.25)],
    }
    assert [to_hex(each[0].get_facecolor()) for each in bars.values()] == [color.lower() for color in COLORS[:3]]
    assert len({each[0].get_hatch() for each in bars.values()}) == 3
    assert [label.get_text() for label in ax.get_yticklabels()] == ["a", "b"]
    assert ax.get_ylim()[0] > ax.get_ylim()[1]  # the first is on top
    interval = mean_over_runs([3.0, 3.5], bounds=(0.0, np.inf))
    [error] = [each for each in ax.containers if isinstance(each, ErrorbarContainer)]
    np.testing.assert_allclose(place(error[2][0].get_segments()[0]), [(interval.low, 0), (interval.high, 0)])
    np.testing.assert_allclose(place(error[2][0].get_segments()[1]), [(1.25, 1), (1.25, 1)])
    [ranks] = [each for each in ax.collections if each.get_label() == "rank of the states"]
    assert [place(segment) for segment in ranks.get_segments()] == [
        [(4.5, -0.38), (4.5, 0.38)], [(12.0, 0.62), (12.0, 1.38)]
    ]  # fmt: skip
    assert sorted(legend_of(figure)) == sorted([*bars, "rank of the states"])
    assert ax.get_xlabel() == "capacity (functions of the input)"
    assert ax.get_xlim() == (0.0, pytest.approx(1.04 * 12))


def predictions(tasks, names, samples=100):
    return [
        Record(
            task,
            name,
            seed,
            0.25 + 0.125 * k + seed,
            {"prediction": [k + seed / 4] * samples, "target": [0.5 + seed] * samples},
        )
        for task in tasks
        for k, name in enumerate(names)
        for seed in (2, 1)
    ]


def test_predictions_are_those_of_the_first_seed_under_their_scores():
    names = ("other", "echo-state network", "another", "delay line", "crawler")
    figure = plot_predictions(predictions(("NARMA-2 NRMSE", "Lorenz NRMSE", "NARMA-5 NRMSE"), names))
    assert [ax.get_title(loc="left") for ax in figure.axes[:3]] == [
        f"{task}: 1.75, 1.62, 1.38" for task in ("NARMA-2 NRMSE", "Lorenz NRMSE", "NARMA-5 NRMSE")
    ]
    for ax in figure.axes[:3]:
        assert [line.get_label() for line in ax.lines] == ["target", "crawler", "delay line", "echo-state network"]
        np.testing.assert_allclose(
            [line.get_ydata() for line in ax.lines], np.outer([1.5, 4.25, 3.25, 1.25], np.ones(80))
        )
        assert [line.get_color() for line in ax.lines] == ["0.8", COLORS[4], COLORS[3], COLORS[1]]
    assert [ax.get_xlabel() for ax in figure.axes] == ["", "", "held-out sample", "held-out sample"]
    assert [ax.axison for ax in figure.axes] == [True, True, True, False]
    assert figure.get_supylabel() == "target's own unit"
    assert legend_of(figure) == ["target", "crawler", "delay line", "echo-state network"]
    assert figure.legends[0].get_title().get_text() == "a title gives the scores in this order"


def test_predictions_of_others_are_drawn_in_their_order():
    [ax] = plot_predictions(predictions(["Lorenz NRMSE"], ("x", "delay line", "y", "z")), samples=7).axes
    assert [line.get_label() for line in ax.lines] == ["target", "delay line", "x", "y"]
    assert {len(line.get_ydata()) for line in ax.lines} == {7}
    assert ax.get_xlabel() == "held-out sample"


SWEPT_LABELS = {
    "hold": "hold ($t_c$)",
    "amplitude": "peak pressure (relative)",
    "duffing": r"duffing $\Pi_1$",
    "damping_ratio": r"damping ratio $\Pi_2$",
    "deborah": r"Deborah number $\Pi_4$",
    "radial_coupling": r"radial coupling $\Pi_5$",
    "foot_mass_fraction": "foot mass fraction $r$",
    "static_friction": "static friction $s$",
    "kinetic_friction": "kinetic friction $k$",
    "slope": "slope (weight along the ground)",
}


@pytest.mark.parametrize("name", SWEPT)
def test_a_sweep_names_its_number(name):
    each = [Estimate(1.0, 0.5, 1.5, 3), Estimate(2.0, 1.0, 2.5, 3)]
    [ax] = plot_sweep(name, [0.5, 2.0], {"memory capacity": each}, TASKS).axes
    assert ax.get_xlabel() == SWEPT_LABELS[name]


def test_a_sweep_has_a_panel_a_task():
    tasks = ("NARMA-2 NRMSE", "memory capacity", "waveform accuracy", "Lorenz valid time")
    found = {task: [Estimate(k + m, k + m - 0.25, k + m + 0.5, 5) for m in (1, 2, 3)] for k, task in enumerate(tasks)}
    values = [0.25, 0.5, 1.0]
    figure = plot_sweep("hold", values, found, TASKS)
    assert [ax.axison for ax in figure.axes] == [True] * 4 + [False] * 2
    for ax, (task, each) in zip(figure.axes, found.items(), strict=False):
        metric = TASKS[task].metric
        assert ax.get_title(loc="left") == f"{task} {'↑' if metric.more_is_better else '↓'}"
        assert ax.get_ylabel() == metric.name
        assert ax.get_xscale() == "linear"  # over a factor of four at most
        [bar] = ax.containers
        np.testing.assert_array_equal(bar[0].get_xydata(), [(v, one.mean) for v, one in zip(values, each, strict=True)])
        spans = [place(segment) for segment in bar[2][0].get_segments()]
        assert spans == [[(v, one.low), (v, one.high)] for v, one in zip(values, each, strict=True)]
        chance = [line for line in ax.lines if line.get_linestyle() == "--"]
        assert [set(line.get_ydata()) for line in chance] == [{metric.chance}]


@pytest.mark.parametrize(("values", "scale"), [([1.0, 4.0], "linear"), ([1.0, 4.5], "log"), ([0.0, 9.0], "linear")])
def test_a_wide_sweep_is_logarithmic_where_it_can_be(values, scale):
    found = {"memory capacity": [Estimate(1.0, np.nan, np.nan, 1)] * 2}
    [ax] = plot_sweep("slope", values, found, TASKS).axes
    assert ax.get_xscale() == scale
    if scale == "log":
        assert [label.get_text() for label in ax.get_xticklabels()] == ["1", "4.5"]
        assert len(ax.get_xticks(minor=True)) == 0


@pytest.mark.parametrize("without", [None, "the one left out"])
def test_no_two_reservoirs_of_a_benchmark_look_alike(without):
    styles = styles_of([str(i) for i in range(40)], without)
    assert len(set(styles.values())) == 40
