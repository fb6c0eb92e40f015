"""What happened within the holds, from the solver's own trajectory: the frames of an environment's pictures."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.validation import number_within
from ...crawler import Groups, Scene
from ...crawler.drawing.camera import Camera
from ...crawler.drawing.film import FPS, PACE
from ...crawler.drawing.frame import Frame, Message, NOTHING, Past, static_stretch, World, world_of
from ...crawler.drawing.recall import SHOWN
from ...crawler.drawing.strip import WINDOW
from ..infos import place_of
from ..settings import Settings
from ..single_kernel import Stepper, stepper_for, within_hold
from .renderer import RenderMode

__all__ = ["MOST", "Film", "Recalled", "film_of", "fps_of", "pictures_of_hold", "recalled_of"]

MOST = 240
"""Pictures of a hold."""

_INNOVATION, _MEMORY, _VALVE = place_of("innovation"), place_of("memory"), place_of("valve")

Array = NDArray[np.float64]


def pictures_of_hold(hold: float, slow_motion: float) -> int:
    """Pictures of a hold, so many that at 30 a second no more than 2 t_c pass in one."""
    return min(max(1, math.ceil(hold * slow_motion * FPS / PACE * (1 - 1e-9))), MOST)


class Recalled(NamedTuple):
    """Message of the holds so far and what the readout made of it when it saw the last, newest first."""

    sent: Array
    recalled: Array
    largest: float


def recalled_of(settings: Settings, weights: Array, scaling: Array, read: Array, past: Array, steps: int) -> Recalled:
    """What a readout makes of the message when it sees a hold, before it learns of it.

    Parameters
    ----------
    settings : Settings
    weights : (messages, features + 1) array
        Of the readout before the hold.
    scaling : (2, features) array
        Centre and scale of each feature.
    read : (features,) array
        What it has seen of the hold.
    past : (>= messages,) array
        Messages, newest first, that of the hold among them.
    steps : int
        Of the episode, that hold among them.
    """
    aim = settings.aim
    known, sent = max(min(steps - aim.lead, settings.messages), 0), past[: min(steps, settings.messages, SHOWN)].copy()
    features = np.append((read - scaling[0]) * scaling[1], 1.0)
    largest = 1.0 - settings.dither if aim.kind == 0 else max(np.abs(sent).max(initial=0.0), math.sqrt(aim.variance))
    return Recalled(sent, weights[: min(known, SHOWN)] @ features, float(largest))


def film_of(settings: Settings, mode: RenderMode | None, slow_motion: float) -> Film | None:
    """What follows a crawler for its pictures; none where nothing is drawn."""
    slow_motion = number_within("slow_motion", slow_motion, "[0.01, 1000]")
    return None if mode is None else Film(settings, slow_motion, keep=mode != "rgb_array")


def fps_of(settings: Settings, mode: RenderMode | None, slow_motion: float) -> float:
    """How many of the pictures that `render` returns make up a second."""
    return FPS / pictures_of_hold(settings.hold, slow_motion) if mode == "rgb_array" else FPS


class _Hold(NamedTuple):
    """A hold as it was within."""

    time: Array
    samples: Array  # z, v, p, x, w
    camera: tuple[float, ...]
    valve: int
    flip: bool
    memory: float | None
    message: Recalled | None


class Film:
    """Frames of one crawler, hold by hold, of an episode that it follows.

    Parameters
    ----------
    settings : Settings
    slow_motion : float
    keep : bool
        Whether frames wait until they are asked for; else only those of the last hold are at hand.
    """

    def __init__(self, settings: Settings, slow_motion: float, *, keep: bool) -> None:
        self._settings = settings
        self._count = pictures_of_hold(settings.hold, slow_motion)
        self._keep = keep
        # Holds that the pictures' panels look back on.
        self._recent: deque[_Hold] = deque(maxlen=min(max(SHOWN, math.ceil(WINDOW / settings.hold)) + 1, MOST))
        self._unseen: list[Frame] = []
        self._last: list[Frame] = []
        self._steps = -1
        self._body = np.empty(0)

    def begin(self, groups: Groups, scene: Scene, body: Array, steps: int, told: NDArray[Any] | None = None) -> None:
        """Begin with a state, at the start of an episode or in the middle, of which no more is known than it says."""
        self.world: World = world_of(scene, static_stretch(groups))
        self._stepper: Stepper = stepper_for(self._settings, groups, scene, samples=self._count)
        self._camera = Camera(self.world.rest_length)
        self._recent.clear()
        self._unseen.clear()
        self._steps, self._body = steps, body.copy()
        time, (z, _, p, x, w, *_) = steps * self._settings.hold, body.tolist()
        valve = 0 if told is None else int(told[_VALVE])
        memory = float(told[_MEMORY]) if told is not None and steps and self._settings.dither else None
        frame = Frame(time, (z,), p, x, w, valve, self._camera.follow(x, time), NOTHING, memory)
        self._show([frame])

    def follows(self, body: Array, steps: int) -> bool:
        """Whether the film has come to this state."""
        return steps == self._steps and np.array_equal(body, self._body, equal_nan=True)

    def add(self, body: Array, told: NDArray[Any], message: Recalled | None) -> None:
        """Go through the hold that has ended in a state; the film has come to where it began.

        Parameters
        ----------
        body : (7,) array
        told : array
            What the step has told: `stickslip.envs.infos.TOLD`.
        message : Recalled or None
        """
        valve, count, hold = int(told[_VALVE]), self._count, self._settings.hold
        samples = within_hold(self._stepper, self._body, valve, count, self._settings.valve_history)
        time = (self._steps + np.arange(1, count + 1) / count) * hold
        camera = tuple(map(self._camera.follow, samples[3].tolist(), time.tolist()))
        memory = None if message is None else float(told[_MEMORY])
        flip = abs(float(told[_INNOVATION])) > 0.5
        before = self._recent[-1] if self._recent else None
        self._recent.append(_Hold(time, samples, camera, valve, flip, memory, message))
        self._steps, self._body = self._steps + 1, body.copy()
        self._show(self._frames(before))

    def last(self) -> list[Frame]:
        """Frames of the last hold, or of where the film began."""
        return self._last

    def unseen(self) -> list[Frame]:
        """Frames since this was asked for."""
        frames, self._unseen = self._unseen, []
        return frames

    def _show(self, frames: list[Frame]) -> None:
        self._last = frames
        if self._keep:
            self._unseen.extend(frames)

    def _frames(self, before: _Hold | None) -> list[Frame]:
        """Frames of the newest hold; `before` is the one before it."""
        hold, recent = self._recent[-1], self._recent
        newest = [each.samples for each in recent]
        z, _, _, x, w = np.concatenate(newest, axis=1)
        time = np.concatenate([each.time for each in recent])
        valve = np.repeat([float(each.valve) for each in recent], self._count)
        past = Past(time, x, x + z, w, valve)
        valves = tuple(each.valve for each in reversed(recent))[:SHOWN]
        flips = tuple(each.flip for each in reversed(recent))[:SHOWN]
        earlier = len(time) - self._count
        frames = []
        for k, (z_, _, p, x_, w_) in enumerate(hold.samples.T.tolist()):
            # What the readout says of a hold it says at its end.
            known = hold if k == self._count - 1 else before
            message = None
            if hold.message is not None:
                told = hold.message if known is None or known.message is None else known.message
                seen = 0 if known is None else None  # nothing before the first hold has ended
                sent, recalled = told.sent[:seen], told.recalled[:seen]
                message = Message(valves, flips, int(known is not hold), sent, recalled, told.largest)
            frames.append(
                Frame(
                    time=float(hold.time[k]),
                    stretches=(z_,),
                    pressure=p,
                    foot=x_,
                    foot_velocity=w_,
                    valve=hold.valve,
                    camera=hold.camera[k],
                    past=Past(*(each[: earlier + k + 1] for each in past)),
                    memory=None if known is None else known.memory,
                    message=message,
                )
            )
        return frames
