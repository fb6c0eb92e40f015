"""Several crawlers in one picture."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...crawler.drawing.film import FPS
from ...crawler.drawing.frame import Frame
from ...crawler.drawing.header import VALUE_SIZE
from ...crawler.drawing.palette import GREY, MIST
from ...crawler.drawing.raster import import_pygame
from .film import Film
from .renderer import Renderer
from .window import Window

if TYPE_CHECKING:
    import pygame

__all__ = ["Tiles", "tile"]

Picture = NDArray[np.uint8]

# Of the whole picture: it has to fit a screen.
_WIDEST, _HIGHEST = 1920, 1080
_GAP = 4
_LEAST_TEXT = 14
_MARGIN = 16
_BELOW_READOUT = 0.18  # share of a picture's height where nothing else is drawn


class Tiles:
    """Draws some crawlers of a batch, each as `Renderer` does.

    Parameters
    ----------
    names : sequence of int
        Of the crawlers.
    """

    def __init__(self, names: Sequence[int]) -> None:
        self._names = names
        self._renderer = Renderer()
        self._window = Window(FPS)

    def draw(self, films: Sequence[Film]) -> tuple[Picture, ...]:
        """Draw the newest frame of each crawler; (HEIGHT, WIDTH, 3) arrays of uint8."""
        return tuple(self._renderer.draw(film.last()[-1], film.world) for film in films)

    def unseen(self, films: Sequence[Film]) -> tuple[list[Picture], ...]:
        """Draw the frames of each crawler since this was asked for."""
        return tuple([self._renderer.draw(frame, film.world) for frame in film.unseen()] for film in films)

    def together(self, films: Sequence[Film], frames: Sequence[Sequence[Frame]]) -> Iterator[tuple[Picture, ...]]:
        """Draw frames of each crawler side by side in time; who has fewer of them stands still at the last."""
        for k in range(max(map(len, frames))):
            shown = zip(frames, films, strict=True)
            yield tuple(self._renderer.draw(each[min(k, len(each) - 1)], film.world) for each, film in shown)

    def show(self, films: Sequence[Film]) -> None:
        """Show what was not yet shown in a window, all crawlers in one picture."""
        for pictures in self.together(films, [film.unseen() or film.last()[-1:] for film in films]):
            self._window.show(_tiled(pictures, self._names))

    def close(self) -> None:
        """Close the window, if there is one."""
        self._renderer.close()
        self._window.close()


def tile(pictures: Sequence[NDArray[np.uint8]], names: Sequence[object] = ()) -> NDArray[np.uint8]:
    """One picture of several, side by side and below each other, small enough for a screen.

    Parameters
    ----------
    pictures : sequence of (height, width, 3) arrays of uint8
        All of one size, as a batched environment's `render` returns them.
    names : sequence, optional
        Written into the corners.

    Returns
    -------
    (height, width, 3) array of uint8
        At most 1920 wide and 1080 high; both even, as video encoders like it.

    Raises
    ------
    ValueError
        If there is no picture, if they are not such arrays of one size, or if there is not a name for each.
    """
    if len(pictures) == 0:
        raise ValueError("pictures must hold one at least, got none")
    shape = np.shape(pictures[0])
    for picture in map(np.asarray, pictures):
        if picture.dtype != np.uint8 or picture.shape != (*shape[:2], 3):
            raise ValueError(
                "pictures must be (height, width, 3) arrays of uint8 of one size, "
                f"got {picture.shape} of {picture.dtype} where the first is {shape}"
            )
    if len(names) not in (0, len(pictures)):
        raise ValueError(f"names must be {len(pictures)}, one for each picture, got {len(names)}")
    whole = import_pygame().surfarray.array3d(_tiled(pictures, names))
    return np.ascontiguousarray(whole.transpose(1, 0, 2))


def _tiled(pictures: Sequence[NDArray[np.uint8]], names: Sequence[object]) -> pygame.Surface:
    pg = import_pygame()
    pg.font.init()
    height, width = pictures[0].shape[:2]
    columns, scale = _layout(len(pictures), width, height)
    rows = math.ceil(len(pictures) / columns)
    wide, high = math.floor(width * scale), math.floor(height * scale)
    size = columns * (wide + _GAP) - _GAP, rows * (high + _GAP) - _GAP
    whole = pg.Surface([side + side % 2 for side in size])
    whole.fill(MIST)
    font = pg.font.Font(None, max(_LEAST_TEXT, round(1.3 * VALUE_SIZE * scale)))
    for k, picture in enumerate(pictures):
        left, top = k % columns * (wide + _GAP), k // columns * (high + _GAP)
        surface = pg.image.frombuffer(np.ascontiguousarray(picture).tobytes(), (width, height), "RGB")
        whole.blit(pg.transform.smoothscale(surface, (wide, high)), (left, top))
        if len(names) > 0:
            label = font.render(str(names[k]), True, GREY)
            whole.blit(label, (left + wide - label.get_width() - _MARGIN, top + round(_BELOW_READOUT * high)))
    return whole


def _layout(count: int, width: int, height: int) -> tuple[int, float]:
    """Columns that leave the pictures largest, and the scale they then have."""

    def scale(columns: int) -> float:
        rows = math.ceil(count / columns)
        across = (_WIDEST - (columns - 1) * _GAP) / (columns * width)
        down = (_HIGHEST - (rows - 1) * _GAP) / (rows * height)
        return min(1.0, across, down)

    # Of equally large ones the fewest columns: reading goes down as well as across.
    columns = max(range(1, count + 1), key=lambda number: (scale(number), -number))
    return columns, scale(columns)
