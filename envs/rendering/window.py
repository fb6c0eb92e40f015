"""A window that shows pictures at a steady pace."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...crawler.drawing.raster import import_pygame

if TYPE_CHECKING:
    import pygame

__all__ = ["Window"]


class Window:
    """A window of the pictures' size, opened at the first of them.

    Parameters
    ----------
    fps : int
        Pictures per second.
    """

    def __init__(self, fps: int) -> None:
        self._fps = fps
        self._clock: pygame.time.Clock | None = None

    def show(self, picture: pygame.Surface) -> None:
        """Show a picture once its time has come."""
        pg = import_pygame()
        if self._clock is None:
            self._clock = pg.time.Clock()
        pg.display.init()
        # pygame has one window: another environment may have closed or resized it since the last picture.
        window = pg.display.get_surface()
        if window is None or window.get_size() != picture.get_size():
            window = pg.display.set_mode(picture.get_size())
            pg.display.set_caption("stickslip")
        window.blit(picture, (0, 0))
        pg.event.pump()
        self._clock.tick(self._fps)
        pg.display.flip()

    def close(self) -> None:
        """Close the window, if there is one; the next picture opens it again."""
        if self._clock is not None:
            import_pygame().display.quit()
        self._clock = None
