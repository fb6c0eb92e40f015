import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from stickslip.reservoir import MemoryCapacity
from stickslip.studies.benchmark.figures import _styles
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


def test_it_draws_where_it_is_told():
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert plot_memory_profile({"a": memory(3)}, ax=right) is figure
    assert (len(left.lines), len(right.lines)) == (0, 1)


@pytest.mark.parametrize("count", [0, 9])
def test_bad_input(count):
    with pytest.raises(ValueError, match=f"memories must hold 1 to 8 curves, got {count}"):
        plot_memory_profile({str(i): memory(3) for i in range(count)})


@pytest.mark.parametrize("without", [None, "the one left out"])
def test_no_two_reservoirs_of_a_benchmark_look_alike(without):
    styles = _styles([str(i) for i in range(40)], without)
    assert len(set(styles.values())) == 40
