"""The figure of a trajectory. Importing this imports matplotlib."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..common.extras import optional_import
from ..common.figures import BODY, house_style, OKABE_ITO, OPEN, PAGE_WIDTH, SLIDES

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.figure import Figure

if TYPE_CHECKING:
    from .trajectory import Trajectory

__all__ = ["plot_trajectory"]

# The model leaves open how long the body is; it is drawn as long as this many of its largest stretch at least, so that
# the payload stays in front of the foot.
_LENGTHS = 1.25


def plot_trajectory(trajectory: Trajectory) -> Figure:
    """Foot and payload, deformation, and valve and pressure against time, as in the paper's Figure 1.

    Parameters
    ----------
    trajectory : Trajectory
        Of one crawler; axes are in mm, s and kPa where it is in SI.

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
    actuator = trajectory.actuator
    length, time, peak = ("$z_c$", "$t_c$", "$P_{max}$") if actuator is None else ("mm", "s", "kPa")
    meters, pascals = (1.0, 1.0) if actuator is None else (1e3, 1e-3)
    blue, orange, green, purple = OKABE_ITO[:4]
    t, foot, deformation = trajectory.time, meters * trajectory.foot, meters * trajectory.deformation
    ahead = _round_up(_LENGTHS * float(np.abs(deformation).max()))
    with house_style():
        figure, (travel, stretch, drive) = plt.subplots(
            3, sharex=True, figsize=(PAGE_WIDTH, 5.6), layout="constrained", height_ratios=(2.4, 1.2, 1.0)
        )
        for index, (start, end) in enumerate(_slides(trajectory)):
            label = "foot slides" if index == 0 else None
            travel.axvspan(start, end, color=SLIDES, lw=0, label=label, zorder=0)
            stretch.axvspan(start, end, color=SLIDES, lw=0, zorder=0)
        payload = foot + deformation + ahead
        travel.fill_between(t, foot, payload, color=BODY, alpha=0.6, lw=0, zorder=1, label="body")
        travel.plot(t, payload, color=orange, label=f"payload, drawn {ahead:g} {length} ahead")
        travel.plot(t, foot, color=blue, label="foot")
        travel.set_ylabel(f"displacement ({length})")
        travel.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4)
        stretch.plot(t, deformation, color=green)
        stretch.axhline(0.0, color="black", lw=0.6, ls=":", zorder=0)
        stretch.set_ylabel(f"stretch $z$ ({length})")
        opened = pascals * actuator.peak_pressure if actuator is not None else 1.0
        # Each hold is a stretch of the open valve, then one of the shut.
        holds = np.arange(len(trajectory.valve))
        turns = np.stack([holds, holds + trajectory.valve], axis=1).ravel() * trajectory.hold
        edges = np.append(turns, len(holds) * trajectory.hold)
        drive.stairs(np.tile([opened, 0.0], len(holds)), edges, fill=True, color=OPEN, label="valve open")
        drive.plot(t, pascals * trajectory.pressure, color=purple, label="pressure")
        drive.set(xlabel=f"time ({time})", ylabel=f"pressure ({peak})", xlim=(0.0, edges[-1]))
        drive.legend(loc="lower right", ncols=2, bbox_to_anchor=(1.0, 0.97))
        figure.align_ylabels()
    return figure


def _round_up(value: float) -> float:
    """The least of 1, 2 or 5 times a power of ten that is not below a number; 1 of none."""
    if value <= 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(times * power for times in (1.0, 2.0, 5.0, 10.0) if times * power >= value)


def _slides(trajectory: Trajectory) -> Iterator[tuple[float, float]]:
    """Start and end of every spell in which the foot slides."""
    start = 0.0 if trajectory.initial.foot_velocity != 0.0 else None
    for time, mode, _ in trajectory.events.tolist():
        if start is not None:
            yield start, time
        start = time if mode != 0 else None
    if start is not None:
        yield start, float(trajectory.time[-1])
