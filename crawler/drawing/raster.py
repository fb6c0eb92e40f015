"""Shapes and words as pixels, by pygame."""

from __future__ import annotations

import math
import re
from functools import lru_cache
from itertools import pairwise
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.extras import optional_import
from .layout import HEIGHT, WIDTH
from .palette import Colour, PAPER
from .primitives import Disc, Drawing, Line, Point, Polygon, Text

if TYPE_CHECKING:
    import pygame

__all__ = ["Canvas", "import_pygame"]

ENLARGEMENT = 2  # painted so much larger, and smoothed down
SUBSCRIPT_SIZE, SUBSCRIPT_DROP = 0.75, 0.3  # relative to the text's


def import_pygame() -> ModuleType:
    """pygame, imported only where something is drawn.

    Raises
    ------
    stickslip.common.extras.MissingExtra
        Where it is missing; a `gymnasium.error.DependencyNotInstalled`.
    """
    with optional_import():
        import pygame
    return pygame


class Canvas:
    """A picture to paint on, again and again; needs no display.

    Raises
    ------
    stickslip.common.extras.MissingExtra
        Where pygame is missing.
    """

    def __init__(self) -> None:
        self._pg = import_pygame()
        self._large = self._pg.Surface((ENLARGEMENT * WIDTH, ENLARGEMENT * HEIGHT), depth=32)
        self.surface: pygame.Surface = self._pg.Surface((WIDTH, HEIGHT), depth=32)

    def paint(self, drawing: Drawing) -> None:
        """Paint all shapes anew, and then the words."""
        self._large.fill(PAPER)
        words = []
        for each in drawing:
            if isinstance(each, Polygon):
                self._polygon(each.points, each.colour)
            elif isinstance(each, Line):
                self._line(each)
            elif isinstance(each, Disc):
                self._disc(each.centre, each.radius, each.colour)
            else:
                words.append(each)
        self._pg.transform.smoothscale(self._large, (WIDTH, HEIGHT), self.surface)
        for text in words:
            self._write(text)

    def pixels(self) -> NDArray[np.uint8]:
        """The picture, shape (HEIGHT, WIDTH, 3)."""
        # Twice as fast as pygame.surfarray; the bytearray makes the array writable.
        data = bytearray(self._pg.image.tobytes(self.surface, "RGB"))
        return np.frombuffer(data, np.uint8).reshape(HEIGHT, WIDTH, 3)

    def _polygon(self, points: tuple[Point, ...], colour: Colour) -> None:
        self._pg.draw.polygon(self._large, colour, [(ENLARGEMENT * x, ENLARGEMENT * y) for x, y in points])

    def _disc(self, centre: Point, radius: float, colour: Colour) -> None:
        at = ENLARGEMENT * centre[0], ENLARGEMENT * centre[1]
        self._pg.draw.circle(self._large, colour, at, ENLARGEMENT * radius)

    def _line(self, line: Line) -> None:
        for start, end in pairwise(line.points):
            along, down = end[0] - start[0], end[1] - start[1]
            scale = line.width / 2 / max(math.hypot(along, down), 1e-9)
            x, y = -down * scale, along * scale
            corners = (start[0] + x, start[1] + y), (end[0] + x, end[1] + y)
            self._polygon((*corners, (end[0] - x, end[1] - y), (start[0] - x, start[1] - y)), line.colour)
        if line.width > 1.0:
            for point in line.points:
                self._disc(point, line.width / 2, line.colour)

    def _write(self, text: Text) -> None:
        # Another environment's close() may have quit pygame, which voids its fonts.
        if not self._pg.font.get_init():
            self._pg.font.init()
            _font.cache_clear()
            _lettering.cache_clear()
        images = _lettering(text.text, text.size, text.colour)
        left = text.at[0] - text.side * sum(image.get_width() for image, _ in images)
        for image, drop in images:
            self.surface.blit(image, (round(left), round(text.at[1] + drop)))
            left += image.get_width()


@lru_cache(512)
def _lettering(text: str, size: int, colour: Colour) -> list[tuple[pygame.Surface, float]]:
    """Images of the parts of a text, and how much deeper each stands."""
    images = []
    for part in re.findall("_.|[^_]+", text):
        subscript = part.startswith("_")
        font = _font(round(size * SUBSCRIPT_SIZE) if subscript else size)
        images.append((font.render(part.removeprefix("_"), True, colour), size * SUBSCRIPT_DROP * subscript))
    return images


@lru_cache(32)
def _font(size: int) -> pygame.font.Font:
    return import_pygame().font.Font(None, size)
