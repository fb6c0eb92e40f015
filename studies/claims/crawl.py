"""C1: the model crawls forward."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...crawler import Groups, simulate, Trajectory
from .claim import Claim, Number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["claim", "crawl", "plot_crawl"]

WORD, CYCLES, HOLD = (1, 1, 1, 1, 0, 0, 0, 0), 10, 1.0
_SETTLED = 2  # cycles until the gait repeats


def crawl(groups: Groups | None = None) -> Trajectory:
    """Ten cycles of inflation and deflation from rest, finely sampled."""
    return simulate(Groups.of(groups), WORD * CYCLES, HOLD, samples_per_hold=50)


def claim(motion: Trajectory) -> Claim:
    """C1, decided by the way of foot and payload in each cycle."""
    ways = {name: np.diff(getattr(motion, name).reshape(CYCLES, -1)[_SETTLED:, -1]) for name in ("foot", "payload")}
    least = min(float(way.min()) for way in ways.values())
    foot = Number(float(ways["foot"].mean()), float(ways["foot"].min()), float(ways["foot"].max()), "z_c")
    return Claim(
        "C1",
        "reproduced" if least > 0.0 else "not reproduced",
        f"Foot and payload advance by {foot.value:.3f} z_c in every cycle of {len(WORD)} holds, the foot in "
        f"{motion.slips / CYCLES:.1f} slips a cycle.",
        {"way of the foot in a cycle, least and greatest": foot, "slips": Number(float(motion.slips))},
        "stickslip reproduce claims",
    )


def plot_crawl(motion: Trajectory) -> Figure:
    """The paper's Fig. 1: payload, foot, valve and pressure against time."""
    return motion.plot()
