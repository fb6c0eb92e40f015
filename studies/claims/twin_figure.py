"""C2 as a figure: one spring against the chain, by the tube's mass."""

from __future__ import annotations

from ...common.extras import optional_import
from ...common.figures import house_style, MARKERS, OKABE_ITO
from .twin import MASSES, PAPER_LIMIT, REGIMES, SHARES, Twin

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.figure import Figure

__all__ = ["plot_twin"]


def plot_twin(twin: Twin) -> Figure:
    """NMSE of z by the tube's mass: a line a regime and way of lumping."""
    with house_style():
        figure, ax = plt.subplots(figsize=(6.0, 3.0), layout="constrained")
        for colour, marker, regime in zip(OKABE_ITO, MARKERS, REGIMES, strict=False):
            for line, share in zip(("--", "-"), SHARES, strict=True):
                errors = twin.lumped[regime, share][0].mean(axis=1)
                label = regime if line == "-" else None
                ax.plot(MASSES, errors, marker + line, color=colour, ms=4, label=label)
        ax.axhline(PAPER_LIMIT, color="0.4", ls=":", lw=1)
        ax.annotate(
            f"the paper's {PAPER_LIMIT}", (MASSES[0], PAPER_LIMIT), (0, 3), textcoords="offset points", color="0.3"
        )
        ax.set(xscale="log", yscale="log", xlabel="mass of the tube, of payload and foot", ylabel="NMSE of z")
        ax.set_xticks(MASSES, [str(mass) for mass in MASSES])
        ax.minorticks_off()
        figure.legend(title="a third at each end;\ndashed: half", loc="outside right center")
    return figure
