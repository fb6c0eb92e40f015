"""What a policy has learned, in pictures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.extras import optional_import
from .portrait import Imitation, Portrait

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_learned", "plot_schedule", "plot_switching"]

_HOLDS = 48
_GRID = 160
_POINTS = 3000
_SMALL = 8
_Z, _V, _VALVE = 0, 1, 4


def plot_learned(
    portraits: Mapping[str, Portrait],
    responses: Mapping[str, NDArray[np.float64]],
    imitations: Mapping[str, Mapping[int, Imitation]],
) -> Figure:
    """What policies have learned: a schedule, a switching line, answers to a flip, and the registers that imitate them.

    Parameters
    ----------
    portraits : mapping of str to Portrait
        By the names to show; the first one's schedule is drawn, and the last one's switching line.
    responses : mapping of str to (lags,) array
        Of each: see `stickslip.studies.trade.portrait.response`.
    imitations : mapping of str to mapping of int to Imitation
        Of each, by their bits.

    Returns
    -------
    matplotlib.figure.Figure
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ...common.figures import house_style, MARKERS

    (first, scheduled), *_, (last, switched) = *portraits.items(), *portraits.items()
    with house_style():
        figure, axes = plt.subplots(2, 2, figsize=(7.2, 5.4), layout="constrained")
        plot_schedule(scheduled, axes[0, 0])
        plot_switching(switched, axes[0, 1])
        for name, marker in zip(portraits, MARKERS, strict=False):
            axes[1, 0].plot(responses[name], "-", marker=marker, ms=3, lw=1, label=name)
            agreements = {bits: each.agreement for bits, each in sorted(imitations[name].items())}
            axes[1, 1].plot(agreements.keys(), agreements.values(), "-", marker=marker, ms=4, label=name)
        axes[1, 0].set(xlabel="holds since one flip", ylabel="commands that differ for it", ylim=(0, 1))
        axes[1, 1].set(xlabel="last valve states that a register sees", ylabel="commands as the policy's")
        axes[1, 1].set(ylim=(0.45, 1.02))
        axes[1, 0].legend(fontsize=_SMALL)
        axes[1, 1].legend(fontsize=_SMALL, loc="lower right")
        titles = (f"a  {first}: schedule", f"b  {last}: switching line", "c  answer to a flip", "d  registers")
        for title, ax in zip(titles, axes.flat, strict=True):
            ax.set_title(title, loc="left", fontsize=9)
    return figure


def plot_schedule(of: Portrait, ax: Axes) -> None:
    """Commands, flips and the stretch that comes of them."""
    from ...common.figures import OKABE_ITO

    commands, valves = of.commands[0, :_HOLDS], of.valves[0, :_HOLDS]
    stretch = of.observations[0, : _HOLDS + 1, _Z]
    holds = np.arange(_HOLDS + 1)
    low, high = min(0.0, float(stretch.min())), float(stretch.max())
    height = 0.1 * (high - low)
    base = low - 1.8 * height
    ax.fill_between(
        holds, base, base + height * np.append(commands, commands[-1]), step="post", color="0.6", lw=0, label="opens"
    )
    for k in np.flatnonzero(commands != valves).tolist():
        ax.axvspan(k, k + 1, color=OKABE_ITO[1], alpha=0.35, lw=0)
    ax.fill_between([], [], color=OKABE_ITO[1], alpha=0.35, lw=0, label="flipped")
    ax.plot(holds, stretch, "o-", ms=2, lw=0.9, color=OKABE_ITO[0])
    ax.set(xlabel="hold", ylabel="deformation ($z_c$)", xlim=(0, _HOLDS), ylim=(base, high + 2.5 * height))
    ax.legend(loc="upper right", fontsize=_SMALL, ncols=2, borderaxespad=0.1)


def plot_switching(of: Portrait, ax: Axes) -> None:
    """Deformation and velocity at each decision, and the line on which it changes, for the past on which it hangs most.

    The line is drawn for the median pressure and foot velocity after that past.
    """
    from ...common.figures import OKABE_ITO

    seen, asked = np.concatenate(of.observations), np.concatenate(of.commands)
    past = telling_past(seen[:, _VALVE:], asked)
    after = (seen[:, _VALVE:] == past).all(axis=1)
    some = np.flatnonzero(~after)[:_POINTS]
    ax.plot(seen[some, _Z], seen[some, _V], ".", ms=1, color="0.85", zorder=0, rasterized=True)
    for command, color, name in ((1, OKABE_ITO[0], "opens"), (0, OKABE_ITO[1], "shuts")):
        chosen = np.flatnonzero(after & (asked == command))[:_POINTS]
        ax.plot(seen[chosen, _Z], seen[chosen, _V], ".", ms=2.5, color=color, label=name, rasterized=True)
    reach = [np.linspace(*ends, _GRID) for ends in (ax.get_xlim(), ax.get_ylim())]
    z, v = np.meshgrid(*reach)
    grid = np.tile(np.median(seen[after], axis=0), (z.size, 1)).astype(np.float32)
    grid[:, _Z], grid[:, _V] = z.ravel(), v.ravel()
    outputs = of.policy.outputs(grid, of.weight if of.policy.conditioned else None)
    lead = (outputs[:, 1] - outputs[:, 0]).reshape(z.shape)
    if lead.min() < 0 < lead.max():
        ax.contour(z, v, lead, [0.0], colors="black", linewidths=0.9)
    # As one writes a word: the oldest first.
    word = "".join(str(int(state)) for state in past[::-1])
    ax.set(xlabel="deformation ($z_c$)", ylabel="velocity ($z_c / t_c$)")
    ax.legend(
        loc="lower left",
        title=f"after {word} it",
        fontsize=_SMALL,
        title_fontsize=_SMALL,
        markerscale=3,
        borderaxespad=0.1,
    )


def telling_past(pasts: NDArray[np.float32], asked: NDArray[np.int64]) -> NDArray[np.float32]:
    """The past after which both commands are given most often: the rarer of the two is most frequent.

    Parameters
    ----------
    pasts : (n, bits) array of 0 and 1
    asked : (n,) array of 0 and 1

    Returns
    -------
    (bits,) array
    """
    distinct, which = np.unique(pasts, axis=0, return_inverse=True)
    opened = np.bincount(which.ravel(), weights=asked, minlength=len(distinct))
    shut = np.bincount(which.ravel(), weights=1 - asked, minlength=len(distinct))
    best: NDArray[np.float32] = distinct[int(np.argmax(np.minimum(opened, shut)))]
    return best
