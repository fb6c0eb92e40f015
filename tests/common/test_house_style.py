"""The house style: colours that can be told apart, settings given back, and figures written whole."""

import matplotlib
import pytest
from matplotlib import pyplot as plt
from PIL import Image

from stickslip.common.figures import BODY, house_style, MARKERS, OKABE_ITO, OPEN, PAGE_WIDTH, save_figure, SLIDES, SMALL


def test_the_colours_are_those_of_okabe_and_ito():
    # Red, green and blue of their table, blue and vermillion first.
    table = [(0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167)]
    table += [(230, 159, 0), (86, 180, 233), (240, 228, 66), (0, 0, 0)]
    assert [tuple(round(255 * part) for part in matplotlib.colors.to_rgb(color)) for color in OKABE_ITO] == table
    assert len(set(MARKERS)) == len(MARKERS) == len(OKABE_ITO)


def test_an_open_valve_is_blue_as_in_the_pictures_and_a_body_is_not():
    (red, _, blue), (warm, _, cold), (grey, *others) = (matplotlib.colors.to_rgb(each) for each in (OPEN, BODY, SLIDES))
    assert red < blue
    assert warm > cold
    assert others == [grey, grey]


def test_the_style_holds_within_its_block_only():
    plt.switch_backend(matplotlib.get_backend())  # chosen when it is first asked for
    before = matplotlib.rcParams.copy()
    with house_style():
        inside = matplotlib.rcParams.copy()
        figure, ax = plt.subplots()
        assert not ax.spines["top"].get_visible()
        assert not ax.spines["right"].get_visible()
        assert [ax.plot([0, 1])[0].get_color() for _ in OKABE_ITO] == list(OKABE_ITO)
    assert inside["font.size"] == 9
    assert inside["lines.linewidth"] == 1.3
    assert inside["legend.frameon"] is False
    assert matplotlib.rcParams == before
    plt.close(figure)


def test_a_notebook_that_begins_to_show_figures_within_the_block_goes_on_to():
    """Its backend is loaded by the first figure, and says then that figures are shown."""
    try:
        with house_style():
            plt.ion()
        assert plt.isinteractive()
        assert matplotlib.rcParams["font.size"] != 9
    finally:
        plt.ioff()


def test_no_letter_of_the_style_is_below_eight_points_and_its_colours_are_those_of_all():
    with house_style():
        sizes = {
            name: value for name, value in matplotlib.rcParams.items() if name.endswith("size") and "label" in name
        }
        cycle = [each["color"] for each in matplotlib.rcParams["axes.prop_cycle"]]
        assert matplotlib.rcParams["legend.fontsize"] == matplotlib.rcParams["legend.title_fontsize"] == SMALL == 8
    assert min(value for value in sizes.values() if isinstance(value, float | int)) == 8
    assert tuple(cycle) == OKABE_ITO
    assert PAGE_WIDTH == 6.5


def test_a_figure_is_written_in_every_form_at_the_style_s_resolution_and_closed(tmp_path):
    figure = plt.figure(figsize=(4.0, 1.0))
    figure.add_axes((0.5, 0.1, 0.2, 0.8))
    save_figure(figure, tmp_path / "one.png", tmp_path / "two.svg")
    assert {path.name for path in tmp_path.iterdir()} == {"one.png", "two.svg"}
    with Image.open(tmp_path / "one.png") as picture:
        assert picture.info["dpi"] == pytest.approx((200, 200), rel=1e-3)
        assert 160 < picture.width < 400  # cut to what is drawn, of four inches
    drawn = (tmp_path / "two.svg").read_text(encoding="utf-8")
    assert "<svg" in drawn
    assert "<dc:date>" not in drawn
    assert not plt.fignum_exists(figure.number)


def test_a_figure_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    file = tmp_path / "one.png"
    file.write_bytes(b"old")
    figure = plt.figure()

    def fail(path, metadata):
        path.write_bytes(b"half")
        raise OSError("full")

    monkeypatch.setattr(figure, "savefig", fail)
    with pytest.raises(OSError, match="full"):
        save_figure(figure, file)
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("one.png", b"old")]
    plt.close(figure)
