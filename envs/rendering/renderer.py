"""Frames drawn into arrays, or shown in a window at their pace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...crawler.drawing.composition import composed
from ...crawler.drawing.film import FPS
from ...crawler.drawing.frame import Frame, World
from ...crawler.drawing.raster import Canvas
from .window import Window

__all__ = ["RENDER_MODES", "RenderMode", "Renderer", "known_mode"]

RenderMode = Literal["human", "rgb_array", "rgb_array_list"]
RENDER_MODES = ["human", "rgb_array", "rgb_array_list"]


def known_mode(mode: RenderMode | None, known: Sequence[str]) -> RenderMode | None:
    """How to draw.

    Raises
    ------
    ValueError
        If it is unknown.
    """
    if mode is not None and mode not in known:
        raise ValueError(f"render_mode must be one of {list(known)} or None, got {mode!r}")
    return mode


class Renderer:
    """Draws frames into a window or into arrays.

    pygame is imported at the first frame: until then an environment that holds a renderer needs no pygame and
    can be copied and pickled.

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        At the first frame, where pygame is missing.
    """

    def __init__(self) -> None:
        self._canvas: Canvas | None = None
        self._window = Window(FPS)

    def draw(self, frame: Frame, world: World) -> NDArray[np.uint8]:
        """Draw a frame.

        Parameters
        ----------
        frame : Frame
            The state to draw; any values are fit to draw, non-finite ones included.
        world : World

        Returns
        -------
        ndarray of uint8, shape (HEIGHT, WIDTH, 3)
        """
        return self._painted(frame, world).pixels()

    def show(self, frames: Sequence[Frame], world: World) -> None:
        """Show frames in the window, one after the other at 30 a second."""
        for frame in frames:
            self._window.show(self._painted(frame, world).surface)

    def close(self) -> None:
        """Close the window, if there is one. A closed renderer may draw again."""
        self._window.close()
        self._canvas = None

    def _painted(self, frame: Frame, world: World) -> Canvas:
        if self._canvas is None:
            self._canvas = Canvas()
        self._canvas.paint(composed(frame, world))
        return self._canvas
