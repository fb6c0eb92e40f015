"""Whether a figure can be read on a page: its width, the size of its letters, and words that lie on each other."""

from itertools import combinations

from matplotlib.text import Text

from stickslip.common.figures import PAGE_WIDTH, SMALL

__all__ = ["assert_legible"]


def assert_legible(figure):
    """A figure is no wider than a page, has no letter below the smallest, and no two words overlap."""
    assert figure.get_size_inches()[0] <= PAGE_WIDTH
    figure.draw_without_rendering()
    words = [each for each in figure.findobj(Text) if each.get_visible() and each.get_text().strip()]
    assert words
    small = [each.get_text() for each in words if each.get_fontsize() < SMALL]
    assert not small, small
    told = []
    for ax in figure.axes:
        told += [ax.xaxis.label, ax.yaxis.label, *(ax.title, ax._left_title, ax._right_title), *ax.texts]
        told += [ax.get_legend()] if ax.get_legend() else []
    told += figure.legends
    boxes = {each: each.get_window_extent() for each in told if each.get_visible() and _said(each)}
    over = [
        (_said(one), _said(other))
        for (one, first), (other, second) in combinations(boxes.items(), 2)
        if first.padded(-1.0).overlaps(second.padded(-1.0))
    ]
    assert not over, over


def _said(artist):
    return artist.get_text().strip() if isinstance(artist, Text) else "a legend"
