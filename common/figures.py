"""The house style of figures: colours, markers, lines, and how they are written. Importing this imports matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from importlib import resources
from pathlib import Path

from .extras import optional_import
from .files import atomically

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib import rc_params_from_file
    from matplotlib.figure import Figure

__all__ = ["BODY", "MARKERS", "OKABE_ITO", "OPEN", "PAGE_WIDTH", "SLIDES", "SMALL", "house_style", "save_figure"]

# M. Okabe and K. Ito, "Color universal design" (2008): told apart by all common forms of colour vision.
OKABE_ITO = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442", "#000000")
MARKERS = "os^Dvp*X"

PAGE_WIDTH = 6.5
"""Inches: the width of a page, and of a figure on it."""

SMALL = 8
"""Points: the smallest letters."""

SLIDES, OPEN, BODY = "0.88", "#CDE8F7", "#FBEBC8"
"""Shades of what a motion does: the foot slides, the valve is open, the body reaches from foot to payload."""

with resources.as_file(resources.files(__package__) / "house.mplstyle") as _file:
    _STYLE = rc_params_from_file(_file, use_default_template=False)


@contextmanager
def house_style() -> Iterator[None]:
    """Draw in the style of all figures of this package, and leave matplotlib's settings as they were."""
    with plt.rc_context(_STYLE):
        yield
        interactive = plt.isinteractive()
    # The first figure loads the backend, and a notebook's says for good that figures are shown.
    (plt.ion if interactive else plt.ioff)()


def save_figure(figure: Figure, *files: Path) -> None:
    """Write a figure to files, each whole or not at all and in the form that its suffix names, and close it.

    The same figure makes the same file: an SVG has no date.
    """
    with house_style():
        for file in files:
            metadata = {"Date": None} if file.suffix == ".svg" else None
            atomically(file, partial(figure.savefig, metadata=metadata))
    plt.close(figure)
