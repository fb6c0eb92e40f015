"""The house style: what it sets, and that nothing of it is left; figures written whole, in the form they are named."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import image
from matplotlib import pyplot as plt

from stickslip.common.figures import house_style, MARKERS, OKABE_ITO, save_figure


def test_the_palette_is_okabe_and_itos():
    """Red, green and blue of blue, vermilion, green, purple, orange, sky blue, yellow and black."""
    published = [
        *((0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167)),
        *((230, 159, 0), (86, 180, 233), (240, 228, 66), (0, 0, 0)),
    ]
    assert [tuple(int(colour[i : i + 2], 16) for i in (1, 3, 5)) for colour in OKABE_ITO] == published
    assert len(set(MARKERS)) == len(MARKERS) == len(OKABE_ITO)


def test_the_style_holds_inside_its_block_alone():
    before = dict(mpl.rcParams)
    with house_style():
        assert mpl.rcParams["axes.prop_cycle"].by_key() == {"color": list(OKABE_ITO)}
        assert mpl.rcParams["font.size"] == 9
        assert mpl.rcParams["lines.linewidth"] == 1.3
        assert not mpl.rcParams["axes.spines.top"]
        assert not mpl.rcParams["axes.spines.right"]
        assert mpl.rcParams["axes.spines.left"]
        assert not mpl.rcParams["legend.frameon"]
        assert mpl.rcParams["savefig.bbox"] == "tight"
    assert dict(mpl.rcParams) == before
    with pytest.raises(RuntimeError, match="inside"), house_style():
        raise RuntimeError("inside")
    assert dict(mpl.rcParams) == before


def test_a_figure_is_written_to_every_file_and_closed(tmp_path):
    figure = plt.figure(figsize=(2, 1))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.imshow(np.eye(2), aspect="auto")
    axes.set_axis_off()
    files = [tmp_path / "figure.png", tmp_path / "figure.svg", tmp_path / "figure.pdf"]
    save_figure(figure, *files)
    assert not plt.fignum_exists(figure.number)
    assert sorted(tmp_path.iterdir()) == sorted(files)
    begins = [file.read_bytes()[:5] for file in files]
    assert begins == [b"\x89PNG\r", b"<?xml", b"%PDF-"]
    # 200 dots an inch, and a tenth of an inch around a tight box.
    height, width, _ = image.imread(files[0]).shape
    assert (width, height) == (pytest.approx(440, abs=4), pytest.approx(240, abs=4))


def test_a_figure_that_cannot_be_written_leaves_the_old_file(tmp_path):
    figure, file = plt.figure(), tmp_path / "figure.octopus"
    file.write_text("old", encoding="utf-8")
    with pytest.raises(ValueError, match="octopus"):
        save_figure(figure, file)
    assert file.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [file]
    plt.close(figure)
