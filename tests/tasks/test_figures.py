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
    assert ax.get_xlabel() == "delay $d$ (holds)"
    assert [len(line.get_xdata()) for line in ax.lines[:2]] == [5, 9]
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), memory(5).profile)
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels[:2] == ["crawler: total 2.5 of at most 7", "delay line: total 4.5 of at most 7"]
    assert len({line.get_color() for line in ax.lines[:2]}) == 2


def test_the_figure_says_what_is_drawn_where():
    profile = np.array([0.9, 0.5, 0.25])
    some = MemoryCapacity(np.array([0, 2, 5]), profile, cutoff=np.array([0.02, 0.03, 0.01]), bound=9)
    other = MemoryCapacity(np.array([0, 1]), np.array([0.2, 0.1]), cutoff=0.05, bound=3)
    [ax] = plot_memory_profile({"some": some, "other": other}).axes
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), [0, 2, 5])
    *curves, border = ax.lines
    assert [line.get_label().split(":")[0] for line in curves] == ["some", "other"]
    assert [line.get_color() for line in curves] == ["#0072B2", "#D55E00"]
    assert len({line.get_marker() for line in curves}) == 2
    assert {(line.get_linestyle(), line.get_linewidth(), line.get_markersize()) for line in curves} == {("-", 1, 3.5)}
    [chance] = ax.patches
    assert (chance.get_label(), chance.get_y(), chance.get_height()) == ("what chance gives, below 0.05", 0, 0.05)
    assert set(border.get_ydata()) == {0.05}
    assert ax.get_ylabel() == "recalled share $MC_d$"
    assert "1 is all of it" in ax.get_title(loc="left")
    assert ax.get_ylim() == (-0.02, 1.05)
    assert ax.get_xlim() == (-0.3, pytest.approx(6.3))
    assert ax.get_legend().get_title().get_text() == "total: the sum over all delays, chance taken off"
    assert all(tick == int(tick) for tick in ax.get_xticks())


def test_nothing_is_drawn_beyond_where_all_is_forgotten():
    forgets = MemoryCapacity(np.arange(40), np.where(np.arange(40) < 7, 0.5, 0.001), cutoff=0.01, bound=12)
    [ax] = plot_memory_profile({"a": forgets}).axes
    assert ax.get_xlim()[1] == pytest.approx(7.3)


def test_it_draws_where_it_is_told():
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert plot_memory_profile({"a": memory(3)}, ax=right) is figure
    assert (len(left.lines), len(right.lines)) == (0, 2)


@pytest.mark.parametrize("count", [0, 9])
def test_bad_input(count):
    with pytest.raises(ValueError, match=f"memories must hold 1 to 8 curves, got {count}"):
        plot_memory_profile({str(i): memory(3) for i in range(count)})
