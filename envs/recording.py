"""Gymnasium's `RecordVideo` for environments that draw several pictures a step: it films all of them."""

import gc
from pathlib import Path
from typing import Any

import gymnasium as gym
from gymnasium.wrappers import RecordVideo as _RecordVideo
from gymnasium.wrappers.vector import RecordVideo as _RecordVectorVideo

from ..crawler.drawing.film import FPS, write_film

__all__ = ["RecordVectorVideo", "RecordVideo"]


class RecordVideo(_RecordVideo[Any, Any]):
    """`gymnasium.wrappers.RecordVideo` that loses no picture: Gymnasium's own keeps one a step, the last.

    All arguments are Gymnasium's. `video_length` counts pictures, and may be exceeded by those of a step. The film has
    30 pictures a second unless `fps` says otherwise, and its file is written whole or not at all.

    Parameters
    ----------
    env : gymnasium.Env
        A `StickSlipCrawlerEnv`, wrapped or not, of `render_mode` "rgb_array" or "rgb_array_list".
    *arguments, **named
        As of `gymnasium.wrappers.RecordVideo`.
    """

    def __init__(self, env: gym.Env[Any, Any], *arguments: Any, **named: Any) -> None:
        super().__init__(env, *arguments, **named)
        if self.frames_per_sec == env.metadata.get("render_fps"):  # which is that of one picture a step
            self.frames_per_sec = FPS

    def _capture_frame(self) -> None:
        if self.env.render_mode == "rgb_array_list":
            since: Any = self.env.render()
            self.render_history += since
            if self.recorded_frames:
                self.recorded_frames += since
                return
        # What came before the recording does not belong to it.
        self.recorded_frames += self.env.get_wrapper_attr("frames")()

    def stop_recording(self) -> None:
        """Stop the recording and write its film."""
        _stop(self, super().stop_recording)


class RecordVectorVideo(_RecordVectorVideo[Any, Any]):
    """`gymnasium.wrappers.vector.RecordVideo` that loses no picture: Gymnasium's own keeps one a step, the last.

    All arguments are Gymnasium's.

    Parameters
    ----------
    env : gymnasium.vector.VectorEnv
        A `StickSlipCrawlerVectorEnv` of `render_mode` "rgb_array" or "rgb_array_list".
    *arguments, **named
        As of `gymnasium.wrappers.vector.RecordVideo`.
    """

    def __init__(self, env: gym.vector.VectorEnv[Any, Any, Any], *arguments: Any, **named: Any) -> None:
        super().__init__(env, *arguments, **named)
        if self.frames_per_sec == env.metadata.get("render_fps"):  # which is that of one picture a step
            self.frames_per_sec = FPS

    def _capture_frame(self) -> None:
        several: Any = self.unwrapped.frames()  # type: ignore[attr-defined]
        for pictures in several:
            shown = pictures[:1] if self.record_first_only else pictures
            if self.frame_cols == -1:
                height, width, _ = shown[0].shape
                self._get_concat_frame_shape(len(shown), height, width)
            self.recorded_frames.append(self._concat_frames(shown))

    def stop_recording(self) -> None:
        """Stop the recording and write its film."""
        _stop(self, super().stop_recording)


def _stop(recorder: Any, stop: Any) -> None:
    """Write a recorder's film, if there is any: Gymnasium's own writing may round the last picture away."""
    if not recorder.recorded_frames:
        stop()  # it says so
        return
    file = Path(recorder.video_folder) / f"{recorder._video_name}.mp4"
    write_film(file, recorder.recorded_frames, recorder.frames_per_sec)
    recorder.recorded_frames, recorder.recording, recorder._video_name = [], False, None
    if recorder.gc_trigger and recorder.gc_trigger(recorder.episode_id):
        gc.collect()
