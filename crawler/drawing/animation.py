"""A trajectory as a film."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...common.validation import number_within
from ..model.state import ChainState
from .camera import Camera
from .composition import composed
from .film import film_file, FPS, PACE, write_film
from .frame import Frame, Past, static_stretch, World, world_of
from .raster import Canvas

if TYPE_CHECKING:
    from ..trajectory import Trajectory

__all__ = ["animate", "frames_of"]

# A film's body is drawn with a rest length of four of what it usually stretches; at its most it stretches that much
# more than usually.
_MOST = 1.5


def animate(trajectory: Trajectory, file: Path | str, *, slow_motion: float, start: float, stop: float | None) -> Path:
    """Write the film of a trajectory, as `Trajectory.animate` has it."""
    file = film_file(file)
    world, frames = frames_of(trajectory, slow_motion=slow_motion, start=start, stop=stop)
    canvas = Canvas()

    def pictures() -> Iterator[np.ndarray]:
        for frame in frames:
            canvas.paint(composed(frame, world))
            yield canvas.pixels()

    write_film(file, pictures(), FPS)
    return file


def frames_of(
    trajectory: Trajectory, *, slow_motion: float = 1.0, start: float = 0.0, stop: float | None = None
) -> tuple[World, list[Frame]]:
    """World and frames of a trajectory's film: every so many samples, and before them where it starts.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, if the trajectory is a batch, or if its samples are too far apart.
    """
    if trajectory.deformation.ndim != 1:
        raise ValueError(
            f"animate takes the trajectory of one crawler, got a batch of {trajectory.deformation.shape[0]}"
        )
    slow_motion = number_within("slow_motion", slow_motion, "[0.01, 1000]")
    actuator = trajectory.actuator
    length, unit, _, peak = (1.0, 1.0, 1.0, 1.0) if actuator is None else actuator.scales
    last = float(trajectory.time[-1])
    start = number_within("start", start, f"[0, {last!r})")
    stop = last if stop is None else number_within("stop", stop, f"({start!r}, inf)")
    time = trajectory.time / unit
    samples = len(time) // len(trajectory.valve)
    hold = trajectory.hold / unit
    between = PACE / FPS / slow_motion  # pictures, at most
    stride = math.floor(between / (hold / samples) * (1 + 1e-9))
    if stride == 0:
        needed = math.ceil(hold / between * (1 - 1e-9))
        raise ValueError(
            f"trajectory must have at least {needed} samples a hold for slow_motion = {slow_motion!r}, got {samples}: "
            f"simulate with samples_per_hold={needed}"
        )
    # The state at the start is not among the samples.
    first = trajectory.initial
    segments = trajectory.segment_deformation / length
    if isinstance(first, ChainState):
        begin = np.asarray(first.segment_deformation, np.float64) / length
    else:
        begin = np.full(len(segments), first.deformation / length / len(segments))
    stretches = np.column_stack([begin, segments])
    time = np.concatenate([[0.0], time])
    pressure = np.concatenate([[first.pressure], trajectory.pressure]) / peak
    foot = np.concatenate([[first.foot], trajectory.foot]) / length
    velocity = np.concatenate([[first.foot_velocity], trajectory.foot_velocity]) * unit / length
    deformation = stretches.sum(axis=0)
    # A sample at the end of an opening of the valve belongs to it.
    holds = np.minimum((np.arange(len(time)) - 1).clip(0) // samples, len(trajectory.valve) - 1)
    into = time / hold - holds
    valve = (into <= trajectory.valve[holds] * (1 + 1e-9)) & (trajectory.valve[holds] > 0)
    past = Past(time, foot, foot + deformation, velocity, valve.astype(np.float64))
    most = float(np.abs(deformation).max())
    groups = trajectory.groups
    assert not isinstance(groups, tuple)
    usual = most / _MOST if most > 0.0 else static_stretch(groups)
    scene = trajectory.scene
    assert not isinstance(scene, tuple)
    world = world_of(scene, usual, actuator)
    camera = Camera(world.rest_length)
    frames = []
    for k in range(0, len(time), stride):
        if time[k] * unit > stop:
            break
        at = camera.follow(float(foot[k]), float(time[k]))
        if time[k] * unit < start:
            continue
        frames.append(
            Frame(
                time=float(time[k]),
                stretches=tuple(stretches[:, k].tolist()),
                pressure=float(pressure[k]),
                foot=float(foot[k]),
                foot_velocity=float(velocity[k]),
                valve=int(valve[min(k + 1, len(valve) - 1)]),
                camera=at,
                past=Past(*(each[: k + 1] for each in past)),
            )
        )
    if not frames:
        raise ValueError(
            f"start and stop must have a picture between them, of which there is one every "
            f"{stride * trajectory.hold / samples:g}, got {start!r} and {stop!r}"
        )
    return world, frames
