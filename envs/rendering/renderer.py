"""Frames drawn with pygame into a window or an array.

A frame only places sprites, stretches the body's lobe and sets the text: that keeps an antialiased picture cheap.
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .canvas import Canvas, PAPER
from .crawler_view import draw_body, draw_foot, draw_ground, draw_hose, draw_payload, draw_streaks
from .frame import Frame
from .panel import draw_gauge, draw_readout, draw_valve
from .pose import Camera, posed
from .window import import_pygame, Window

__all__ = ["Renderer"]


class Renderer:
    """Draws frames into a window or into arrays.

    pygame is imported at the first frame: until then an environment that holds a renderer needs no pygame and
    can be copied and pickled.

    Parameters
    ----------
    mode : {"human", "rgb_array"}
        Show each frame in a window at the pace of `fps`, or return it as an array, which needs no display.
    fps : int
        Frames per second of the window.

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        At the first frame, where pygame is missing.
    """

    def __init__(self, mode: Literal["human", "rgb_array"], fps: int) -> None:
        self.mode = mode
        self._camera = Camera()
        self._canvas: Canvas | None = None
        self._window = Window(fps)

    def draw(self, frame: Frame) -> NDArray[np.uint8] | None:
        """Draw one frame.

        Parameters
        ----------
        frame : Frame
            The state to draw; any values are fit to draw, non-finite ones included.

        Returns
        -------
        ndarray of uint8, shape (HEIGHT, WIDTH, 3), or None
            The picture, or None in mode "human".
        """
        if self._canvas is None:
            self._canvas = Canvas(import_pygame())
        _compose(self._canvas, frame, self._camera)
        if self.mode == "rgb_array":
            return self._canvas.pixels()
        self._window.show(self._canvas.surface)
        return None

    def close(self) -> None:
        """Close the window, if there is one. A closed renderer may draw again."""
        self._window.close()
        self._canvas = None


def _compose(canvas: Canvas, frame: Frame, camera: Camera) -> None:
    pose = posed(frame, camera)
    canvas.surface.fill(PAPER)
    draw_ground(canvas, pose)
    draw_hose(canvas, pose, frame)
    draw_streaks(canvas, pose, frame)
    draw_body(canvas, pose)
    draw_payload(canvas, pose)
    draw_foot(canvas, pose)
    draw_valve(canvas, frame)
    draw_gauge(canvas, pose)
    draw_readout(canvas, frame)
