"""The front in a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast, TYPE_CHECKING

import numpy as np

from ...common.extras import optional_import
from ...train.schedules import pareto_front
from .front import Front, Point

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_front"]

_SIZE = (4.6, 3.9)  # inches
_SMALL = 8
_ISO_LINES = 6
_CAPACITIES = {
    "memory": "memory capacity (holds)",
    "parity": "capacity for products of flips",
    "narma": "capacity for the NARMA series",
}


def plot_front(front: Front, *, weight: float = 0.2, ax: Axes | None = None) -> Figure:
    """Speed against memory at one dither: what open loop reaches, the limit of speed, and the policies.

    Parameters
    ----------
    front : Front
        With a dither above 0.
    weight : float, in [0, 1]
        Of memory in the reward whose lines of equal reward are drawn.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there is no dither, and so no memory to show.
    """
    # matplotlib is optional, and slow to import
    with optional_import():
        from matplotlib import pyplot as plt

    from ...common.figures import house_style, OKABE_ITO

    if front.dither == 0:
        raise ValueError("front must have a dither above 0 to have memory, got 0")
    policy_color, conditioned_color, limit_color = OKABE_ITO[0], OKABE_ITO[1], OKABE_ITO[7]
    with house_style():
        if ax is None:
            _, ax = plt.subplots(figsize=_SIZE, layout="constrained")
        limit = front.speed_limit.mean
        every = _means(front.points)
        right, top = 1.12 * max(limit, every[:, 0].max()), 1.12 * every[:, 1].max()
        ax.set(xlim=(0, right), ylim=(0, top))

        _equal_reward(ax, weight, right, top)
        open_loop = _means(front.open_loop)
        edge = open_loop[pareto_front(open_loop)]
        ax.fill_between(*_staircase(edge), color="0.92", lw=0, zorder=0)
        ax.plot(*_staircase(edge), color="0.6", lw=0.8, zorder=1)
        ax.plot(*edge.T, "o", ms=2.5, color="0.45", zorder=2, label="best open-loop words")
        ax.axvline(limit, color=limit_color, ls="--", lw=0.9, zorder=1)
        ax.annotate(
            "speed limit", (limit, 0.02 * top), xytext=(-3, 0), textcoords="offset points", rotation=90, ha="right",
            va="bottom", fontsize=_SMALL,
        )  # fmt: skip
        if front.conditioned:
            curve = _means(sorted(front.conditioned, key=lambda point: cast(float, point.weight)))
            ax.plot(*curve.T, "-s", ms=3.2, lw=1.1, mec="white", mew=0.4, color=conditioned_color, zorder=3,
                    label="one policy for all weights")  # fmt: skip
        if front.policies:
            chosen = front.chosen
            points = _means(chosen)
            floored = any(point.floor is not None for point in chosen)
            ax.plot(*points.T, "o", ms=4.5, mec="white", mew=0.5, color=policy_color, zorder=4,
                    label="one policy a weight" + " or floor" * floored)  # fmt: skip
            _bodies_share(ax, [chosen[i] for i in pareto_front(points)], policy_color)
        knee = front.knee
        if knee is not None:
            ax.plot(*knee.mean, "o", ms=11, mfc="none", mec="black", mew=0.9, zorder=5)
            # Above it no policy is, and neither a line down from one nor that of the limit.
            ax.annotate("knee", knee.mean, xytext=(0, 8), textcoords="offset points", ha="center", va="bottom",
                        fontsize=_SMALL)  # fmt: skip
        held_open = next(point for point in front.held if point.kind == "held open")
        ax.plot(*held_open.mean, "D", ms=4, color="0.25", zorder=3)
        ax.annotate("held open", held_open.mean, xytext=(6, 4), textcoords="offset points", fontsize=_SMALL)
        ax.set(xlabel="speed ($z_c / t_c$)", ylabel=_CAPACITIES[front.target])
        ax.legend(loc="lower left", fontsize=_SMALL, handlelength=1.5, borderaxespad=0.3)
    return cast("Figure", ax.get_figure(root=True))


def _bodies_share(ax: Axes, policies: Sequence[Point], color: str) -> None:
    """Below each policy what its memory is with the feedback cut."""
    shares = [(*point.mean, point.body_memories.mean()) for point in policies if point.body_memories is not None]
    if not shares:
        return
    speeds, memories, bodies = np.transpose(shares)
    ax.vlines(speeds, bodies, memories, color=color, lw=0.5, alpha=0.5, zorder=2)
    ax.plot(speeds, bodies, "o", ms=3, mfc="white", mec=color, mew=0.7, zorder=3, label="its body's share of memory")


def _means(points: Sequence[Point]) -> np.ndarray:
    return np.array([point.mean for point in points])


def _staircase(edge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Border of what points by falling speed dominate."""
    speeds, memories = edge.T
    x = np.concatenate([[0.0], np.repeat(speeds[::-1], 2)])
    y = np.concatenate([np.repeat(memories[::-1], 2), [0.0]])
    return x, y


def _equal_reward(ax: Axes, weight: float, right: float, top: float) -> None:
    best = (1 - weight) * right + weight * top
    speeds = np.array([0.0, right])
    for reward in np.linspace(0, best, _ISO_LINES + 2)[1:-1]:
        if weight > 0:
            ax.plot(speeds, (reward - (1 - weight) * speeds) / weight, ":", color="0.75", lw=0.7, zorder=0)
        else:
            ax.axvline(reward, color="0.75", ls=":", lw=0.7, zorder=0)
    ax.plot([], [], ":", color="0.6", lw=0.9, label=f"equal reward, memory weight {weight:g}")
