"""What the figures of training show: the words and numbers of what is drawn."""

import math

import numpy as np
import pytest
from matplotlib import pyplot as plt

from stickslip.common.figures import MARKERS, OKABE_ITO
from stickslip.reservoir import MemoryCapacity
from stickslip.train.evaluations import Evaluation, write_evaluations
from stickslip.train.figures import plot_learning, plot_trade
from stickslip.train.schedules import Performance


def performance(speed, memory):
    """Of a corrected memory; chance adds 0.25 that is not to be shown."""
    return Performance(speed, MemoryCapacity(np.arange(2), np.array([memory, 0.25]), 0.25, 2))


SCHEDULES = {
    "0": performance(0.0, 0.875),
    "1": performance(0.1, 0.9),
    "10": performance(0.5, 0.5),  # beaten by the next
    "110": performance(0.6, 0.6),
    "1110": performance(0.8, 0.3),
}
POLICIES = {"careful": performance(0.2, 0.95), "fast": performance(0.9, 0.4)}


@pytest.fixture(autouse=True)
def _nothing_left_open():
    yield
    plt.close("all")


def drawn(ax):
    """Lines by label, all of which can be seen."""
    for line in ax.lines:
        width = line.get_markersize() if line.get_linestyle() == "None" else line.get_linewidth()
        assert line.get_visible()
        assert width >= 0.5
        assert line.get_color() not in ("white", "1.0")
    return {line.get_label(): line for line in ax.lines}


def test_a_trade_is_drawn_at_its_speeds_and_corrected_memories():
    figure = plot_trade(SCHEDULES, POLICIES)
    (ax,) = figure.axes
    lines = drawn(ax)
    assert lines["open-loop schedules"].get_xydata().tolist() == [
        [0.0, 0.875],
        [0.1, 0.9],
        [0.5, 0.5],
        [0.6, 0.6],
        [0.8, 0.3],
    ]
    assert lines["open-loop schedules"].get_linestyle() == "None"
    assert lines["open-loop front"].get_xydata().tolist() == [[0.8, 0.3], [0.6, 0.6], [0.1, 0.9]]
    assert lines["open-loop front"].get_linestyle() == "-"
    assert lines["careful"].get_xydata().tolist() == [[0.2, 0.95]]
    assert lines["fast"].get_xydata().tolist() == [[0.9, 0.4]]
    # The words stand where their schedules are, those of the front only.
    assert {text.get_text(): tuple(text.xy) for text in ax.texts} == {
        "1110": (0.8, 0.3),
        "110": (0.6, 0.6),
        "1": (0.1, 0.9),
    }


def test_a_trade_s_axes_and_signs_say_what_they_are():
    (ax,) = plot_trade(SCHEDULES, POLICIES).axes
    lines = drawn(ax)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("speed ($z_c / t_c$)", "memory capacity, corrected total")
    assert (ax.get_xlim()[0], *ax.get_ylim()) == (0.0, 0.0, pytest.approx(1.08 * 0.9))
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "open-loop schedules",
        "open-loop front",
        "careful",
        "fast",
    ]
    signs = {(lines[name].get_color(), lines[name].get_marker()) for name in POLICIES}
    assert signs == {(OKABE_ITO[0], MARKERS[1]), (OKABE_ITO[1], MARKERS[2])}
    assert lines["open-loop schedules"].get_marker() == MARKERS[0]


def test_a_trade_without_policies_is_that_of_schedules():
    assert set(drawn(plot_trade(SCHEDULES, {}).axes[0])) == {"open-loop schedules", "open-loop front"}


def test_as_many_policies_are_drawn_as_can_be_told_apart():
    seven = {f"policy {i}": performance(i / 10, 0.5) for i in range(7)}
    lines = drawn(plot_trade(SCHEDULES, seven).axes[0])
    assert len({(lines[name].get_color(), lines[name].get_marker()) for name in seven}) == 7
    with pytest.raises(ValueError, match="policies must be at most 7, got 8"):
        plot_trade(SCHEDULES, {**seven, "one more": performance(0.1, 0.1)})


def test_what_has_no_memory_to_show_is_refused():
    with pytest.raises(ValueError, match="schedules must hold at least one performance, got none"):
        plot_trade({}, POLICIES)
    for schedules, policies in (
        (SCHEDULES | {"100": Performance(1.0, None)}, {}),
        (SCHEDULES, {"100": Performance(1.0, None)}),
    ):
        with pytest.raises(ValueError, match="100 was measured without dither and has no memory capacity"):
            plot_trade(schedules, policies)


ROWS = [Evaluation(100, 0.25, 0.5, 0.125), Evaluation(200, 0.75, 0.875, 1.5), Evaluation(300, 0.5, 0.625, 1.0)]


TERMS = {"reward": "reward", "speed": "its speed", "memory": "its memory"}


@pytest.fixture
def table(tmp_path):
    file = tmp_path / "evaluations.csv"
    write_evaluations(file, ROWS)
    return file


def test_a_learning_curve_is_that_of_its_table(table):
    (ax,) = plot_learning(table).axes
    assert {name: line.get_xydata().tolist() for name, line in drawn(ax).items()} == {
        label: [[row.steps, getattr(row, name)] for row in ROWS] for name, label in TERMS.items()
    }
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("environment steps", "mean per step")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == list(TERMS.values())
    styles = [line.get_linestyle() for line in ax.lines]
    assert len(set(styles)) == 3
    assert drawn(ax)["reward"].get_linestyle() == "-"


def test_baselines_are_lines_across_and_noise_is_not_magnified(table):
    write_evaluations(table, [row._replace(reward=1.0 + 0.001 * row.steps, speed=1.0, memory=1.0) for row in ROWS])
    (ax,) = plot_learning(table, baselines={"held open": 0.75, "best word": -0.25}).axes
    lines = drawn(ax)
    assert set(lines["reward of held open: 0.750"].get_ydata()) == {0.75}
    assert set(lines["reward of best word: -0.250"].get_ydata()) == {-0.25}
    assert len({str(line.get_linestyle()) for line in ax.lines[-2:]}) == 2
    low, high = ax.get_ylim()
    assert low <= -0.25
    assert high > 1.3
    assert plot_learning(table).axes[0].get_ylim()[0] == 0.0


def test_terms_that_were_not_told_are_not_drawn(table):
    write_evaluations(table, [row._replace(speed=math.nan) for row in ROWS])
    assert set(drawn(plot_learning(table).axes[0])) == {"reward", "its memory"}
    write_evaluations(table, [ROWS[0]._replace(speed=math.nan, memory=math.nan), *ROWS[1:]])
    assert set(drawn(plot_learning(table).axes[0])) == set(TERMS.values())


def test_figures_are_drawn_where_it_is_asked_for(table):
    figure, (one, other) = plt.subplots(1, 2)
    assert plot_learning(table, ax=one) is figure
    assert plot_trade(SCHEDULES, {}, ax=other) is figure
    assert len(one.lines) == 3
    assert len(other.lines) == 2
    assert len(plt.get_fignums()) == 1
