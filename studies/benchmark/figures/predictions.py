"""The figure of predictions against their target."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ....common.extras import optional_import
from ..records import Record
from .style import order_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_predictions"]

_DRAWN_TOGETHER = ("crawler", "delay line", "echo-state network")


def plot_predictions(records: Sequence[Record], samples: int = 80) -> Figure:
    """Predictions against their target, a panel a task, on the first held-out samples of one seed.

    Parameters
    ----------
    records : sequence of Record
        With predictions; of the reservoirs at most three are drawn, crawler, delay line and echo-state network first.
    samples : int

    Returns
    -------
    matplotlib.figure.Figure
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ....common.figures import house_style, PAGE_WIDTH, SMALL

    titles, styles = order_of(records)
    preferred = [name for name in _DRAWN_TOGETHER if name in styles]
    drawn = [*preferred, *(name for name in styles if name not in preferred)][:3]
    columns = min(2, len(titles))
    rows = -(-len(titles) // columns)
    with house_style():
        figure, axes = plt.subplots(
            rows, columns, squeeze=False, figsize=(PAGE_WIDTH, 0.7 + 1.3 * rows), layout="constrained"
        )
        for ax, title in zip(axes.flat, titles, strict=False):
            mine = [record for record in records if record.task == title]
            first = min(record.seed for record in mine)
            of_first = {record.reservoir: record for record in mine if record.seed == first}
            target = next(iter(of_first.values())).details["target"][:samples]
            ax.plot(target, color="0.8", lw=3.0, label="target")
            for reservoir in drawn:
                record = of_first[reservoir]
                ax.plot(record.details["prediction"][:samples], lw=0.9, color=styles[reservoir][0], label=reservoir)
            errors = ", ".join(f"{of_first[name].score:.2f}" for name in drawn)
            ax.set_title(f"{title}: {errors}", loc="left", fontsize=SMALL)
            ax.margins(x=0.01)
        for ax in axes.flat[len(titles) :]:
            ax.set_axis_off()
        for ax in axes[-1]:
            ax.set_xlabel("held-out sample")
        figure.supylabel("target's own unit", fontsize=9)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        order = "a title gives the scores in this order"
        figure.legend(handles, labels, loc="outside upper center", ncols=4, title=order)
    return figure
