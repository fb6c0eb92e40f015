"""The house style of figures: colours, markers, lines, and how they are written. Importing this imports matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .extras import optional_import
from .files import atomically

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.figure import Figure

__all__ = ["MARKERS", "OKABE_ITO", "house_style", "save_figure"]

# M. Okabe and K. Ito, "Color universal design" (2008): told apart by all common forms of colour vision.
OKABE_ITO = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442", "#000000")
MARKERS = "os^Dvp*X"

_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": plt.cycler(color=OKABE_ITO),
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "savefig.bbox": "tight",
    "savefig.dpi": 200,
}


@contextmanager
def house_style() -> Iterator[None]:
    """Draw in the style of all figures of this package, and leave matplotlib's settings as they were."""
    with plt.rc_context(_STYLE):
        yield
        interactive = plt.isinteractive()
    # The first figure loads the backend, and a notebook's says for good that figures are shown.
    (plt.ion if interactive else plt.ioff)()


def save_figure(figure: Figure, *files: Path) -> None:
    """Write a figure to files, each whole or not at all and in the form that its suffix names, and close it."""
    with house_style():
        for file in files:
            atomically(file, figure.savefig)
    plt.close(figure)
