"""C1: the model crawls forward."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...crawler import Groups, simulate, Trajectory
from .asked import Asked
from .claim import Claim, Number
from .real_body import BODY, in_millimetres, in_seconds

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["claim", "crawl", "measure", "plot_crawl"]

WORD, CYCLES, HOLD = (1, 1, 1, 1, 0, 0, 0, 0), 10, 1.0
_SETTLED = 2  # cycles until the gait repeats


def crawl(groups: Groups | None = None) -> Trajectory:
    """Ten cycles of inflation and deflation from rest, finely sampled."""
    return simulate(Groups.of(groups), WORD * CYCLES, HOLD, samples_per_hold=50)


def measure(_: Asked) -> tuple[Trajectory, Trajectory]:
    """The default crawler's and the real body's motion."""
    return crawl(), crawl(BODY.groups)


def claim(motion: Trajectory, body: Trajectory | None = None) -> Claim:
    """C1, decided by the way of foot and payload in each cycle."""
    ways = _ways(motion)
    least = min(float(way.min()) for way in ways.values())
    foot = Number(float(ways["foot"].mean()), float(ways["foot"].min()), float(ways["foot"].max()), "z_c")
    return Claim(
        "C1",
        "reproduced" if least > 0.0 else "not reproduced",
        f"Foot and payload advance by {foot.value:.3f} z_c in every cycle of {len(WORD)} holds, the foot in "
        f"{motion.slips / CYCLES:.1f} slips a cycle.",
        {"way of the foot in a cycle, least and greatest": foot, "slips": Number(float(motion.slips))},
        "stickslip reproduce fig1",
        {} if body is None else _of_body(body),
    )


def _ways(motion: Trajectory) -> dict[str, NDArray[np.float64]]:
    """What foot and payload advance in each cycle, once the gait repeats."""
    return {name: np.diff(getattr(motion, name).reshape(CYCLES, -1)[_SETTLED:, -1]) for name in ("foot", "payload")}


def _of_body(motion: Trajectory) -> dict[str, Number]:
    way = _ways(motion)["foot"]
    return {
        "way of the foot in a cycle, least and greatest": in_millimetres(
            float(way.mean()), float(way.min()), float(way.max())
        ),
        "length of a cycle": in_seconds(len(WORD) * HOLD),
        "slips a cycle": Number(motion.slips / CYCLES),
        "peak pressure": Number(BODY.peak_pressure / 1e3, unit="kPa"),
    }


def plot_crawl(motion: Trajectory) -> Figure:
    """The paper's Fig. 1: payload, foot, valve and pressure against time."""
    return motion.plot()
