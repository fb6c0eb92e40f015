"""The figure of a trajectory. Importing this imports matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..common.extras import optional_import
from ..common.figures import house_style, OKABE_ITO

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.figure import Figure

if TYPE_CHECKING:
    from .trajectory import Trajectory

__all__ = ["plot_trajectory"]


def plot_trajectory(trajectory: Trajectory) -> Figure:
    """Foot and payload, deformation, and valve and pressure against time, as in the paper's Figure 1.

    Parameters
    ----------
    trajectory : Trajectory
        Of one crawler; axes are in SI where it is.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the trajectory is a batch.
    """
    if trajectory.deformation.ndim != 1:
        raise ValueError(f"plot takes the trajectory of one crawler, got a batch of {trajectory.deformation.shape[0]}")
    si = trajectory.actuator is not None
    length, time, peak = ("m", "s", "Pa") if si else ("$z_c$", "$t_c$", "$P_{max}$")
    blue, orange, green, purple = OKABE_ITO[:4]
    t = trajectory.time
    with house_style():
        figure, (travel, stretch, drive) = plt.subplots(
            3, sharex=True, figsize=(6.5, 5.0), layout="constrained", height_ratios=(2.2, 1.2, 1.0)
        )
        for index, (start, end) in enumerate(_slides(trajectory)):
            label = "foot slides" if index == 0 else None
            travel.axvspan(start, end, color="0.9", lw=0, label=label)
            stretch.axvspan(start, end, color="0.9", lw=0)
        travel.plot(t, trajectory.payload, color=orange, label="payload")
        travel.plot(t, trajectory.foot, color=blue, label="foot")
        travel.set_ylabel(f"displacement ({length})")
        travel.legend(loc="upper left")
        stretch.plot(t, trajectory.deformation, color=green)
        stretch.axhline(0.0, color="0.6", lw=0.6, zorder=0)
        stretch.set_ylabel(f"stretch $z$ ({length})")
        opened = trajectory.actuator.peak_pressure if trajectory.actuator is not None else 1.0
        # Each hold is a stretch of the open valve, then one of the shut.
        holds = np.arange(len(trajectory.valve))
        turns = np.stack([holds, holds + trajectory.valve], axis=1).ravel() * trajectory.hold
        edges = np.append(turns, len(holds) * trajectory.hold)
        drive.stairs(np.tile([opened, 0.0], len(holds)), edges, fill=True, color="0.85", label="valve open")
        drive.plot(t, trajectory.pressure, color=purple, label="pressure")
        drive.set(xlabel=f"time ({time})", ylabel=f"pressure ({peak})", xlim=(0.0, edges[-1]))
        drive.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.35))
        figure.align_ylabels()
    return figure


def _slides(trajectory: Trajectory) -> Iterator[tuple[float, float]]:
    """Start and end of every spell in which the foot slides."""
    start = 0.0 if trajectory.initial.foot_velocity != 0.0 else None
    for time, mode, _ in trajectory.events.tolist():
        if start is not None:
            yield start, time
        start = time if mode != 0 else None
    if start is not None:
        yield start, float(trajectory.time[-1])
