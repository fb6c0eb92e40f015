import pytest
from looks import FIGURES, look_of, written
from matplotlib import pyplot as plt


@pytest.mark.parametrize("name", FIGURES["train"])
def test_nothing_of_a_figure_moves_unseen(name):
    assert look_of(FIGURES["train"][name]()) == written()["train"][name]
    plt.close("all")
