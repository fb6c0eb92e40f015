import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from stickslip.reservoir import MemoryCapacity
from stickslip.tasks import plot_memory_profile

mpl.use("agg")


def memory(delays):
    return MemoryCapacity(np.arange(delays), np.linspace(1, 0, delays), cutoff=0.01, bound=7)


def test_the_figure_shows_every_profile_with_its_total():
    figure = plot_memory_profile({"crawler": memory(5), "delay line": memory(9)})
    [ax] = figure.axes
    assert ax.get_xlabel() == "delay (holds)"
    assert [len(line.get_xdata()) for line in ax.lines] == [5, 9]
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), memory(5).profile)
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels[:2] == ["crawler: 2.50 of 7", "delay line: 4.50 of 7"]
    assert len({line.get_color() for line in ax.lines}) == 2


def test_the_figure_says_what_is_drawn_where():
    profile = np.array([0.9, 0.5, 0.25])
    some = MemoryCapacity(np.array([0, 2, 5]), profile, cutoff=np.array([0.02, 0.03, 0.01]), bound=9)
    other = MemoryCapacity(np.array([0, 1]), np.array([0.2, 0.1]), cutoff=0.05, bound=3)
    [ax] = plot_memory_profile({"some": some, "other": other}).axes
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), [0, 2, 5])
    assert [line.get_label().split(":")[0] for line in ax.lines] == ["some", "other"]
    assert [line.get_color() for line in ax.lines] == ["#0072B2", "#D55E00"]
    assert len({line.get_marker() for line in ax.lines}) == 2
    assert {(line.get_linestyle(), line.get_linewidth(), line.get_markersize()) for line in ax.lines} == {("-", 1, 3.5)}
    [chance] = ax.patches
    assert (chance.get_label(), chance.get_y(), chance.get_height()) == ("chance", 0, 0.05)
    assert ax.get_ylabel() == "memory capacity $MC_d$"
    assert ax.get_ylim() == (-0.02, 1.05)
    assert ax.get_legend().get_title().get_text() == "corrected total of bound"
    assert all(tick == int(tick) for tick in ax.get_xticks())


def test_it_draws_where_it_is_told():
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert plot_memory_profile({"a": memory(3)}, ax=right) is figure
    assert (len(left.lines), len(right.lines)) == (0, 1)


@pytest.mark.parametrize("count", [0, 9])
def test_bad_input(count):
    with pytest.raises(ValueError, match=f"memories must hold 1 to 8 curves, got {count}"):
        plot_memory_profile({str(i): memory(3) for i in range(count)})
