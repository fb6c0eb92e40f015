"""Where pictures are painted: a canvas with its palette, and a pen that smooths what it draws."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Hashable, Sequence
from functools import cache
from itertools import pairwise
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .window import import_pygame

if TYPE_CHECKING:
    import pygame

__all__ = [
    "AIR",
    "ELASTOMER",
    "GREY",
    "HEIGHT",
    "INK",
    "MIST",
    "PAPER",
    "SLIDING",
    "STICKING",
    "WIDTH",
    "Canvas",
    "Colour",
    "Pen",
    "Point",
    "mixed",
    "shifted",
]

Colour = tuple[int, int, int]
Point = tuple[float, float]

# Both sides are multiples of 16, so video encoders neither pad nor rescale.
WIDTH, HEIGHT = 960, 320

# The palette is Okabe and Ito's (colour-blind safe) on white, with greys for all that carries no state.
PAPER: Colour = (255, 255, 255)
INK: Colour = (45, 52, 60)
GREY: Colour = (125, 132, 140)
MIST: Colour = (224, 228, 232)
ELASTOMER: Colour = (246, 243, 236)
AIR: Colour = (86, 180, 233)
STICKING: Colour = (0, 114, 178)
SLIDING: Colour = (213, 94, 0)

SUBSCRIPT_SIZE, SUBSCRIPT_DROP = 0.75, 0.3  # relative to the text's


class Canvas:
    """The picture being composed, with the sprites painted for it so far."""

    def __init__(self, pg: ModuleType) -> None:
        self.pg = pg
        self.surface = pg.Surface((WIDTH, HEIGHT), depth=32)
        self._sprites: dict[Hashable, pygame.Surface] = {}

    def sprite(self, key: Hashable, paint: Callable[[], pygame.Surface]) -> pygame.Surface:
        """Return the sprite of that key, painted at the first request."""
        if key not in self._sprites:
            self._sprites[key] = paint()
        return self._sprites[key]

    def place(self, image: pygame.Surface, left: float, top: float) -> None:
        """Place an image by its top left corner."""
        self.surface.blit(image, (round(left), round(top)), special_flags=self.pg.BLEND_PREMULTIPLIED)

    def fill(self, box: tuple[float, float, float, float], colour: Colour) -> None:
        """Fill a box, given by its left, top, width and height."""
        self.surface.fill(colour, [round(side) for side in box])

    def text(self, text: str, at: Point, size: int, colour: Colour, *, centred: bool = False) -> None:
        """Write one line from its top left (or top centre); `_` makes the next character a subscript."""
        # Another environment's close() may have quit pygame, which voids its fonts.
        if not self.pg.font.get_init():
            self.pg.font.init()
            _font.cache_clear()
        images = []
        for part in re.findall("_.|[^_]+", text):
            subscript = part.startswith("_")
            font = _font(round(size * SUBSCRIPT_SIZE) if subscript else size)
            images.append((font.render(part.removeprefix("_"), True, colour), size * SUBSCRIPT_DROP * subscript))
        left = at[0] - sum(image.get_width() for image, _ in images) / 2 * centred
        for image, drop in images:
            self.surface.blit(image, (round(left), round(at[1] + drop)))
            left += image.get_width()

    def pixels(self) -> NDArray[np.uint8]:
        """The picture, shape (HEIGHT, WIDTH, 3)."""
        # Twice as fast as pygame.surfarray; the bytearray makes the array writable.
        data = bytearray(self.pg.image.tobytes(self.surface, "RGB"))
        return np.frombuffer(data, np.uint8).reshape(HEIGHT, WIDTH, 3)


@cache
def _font(size: int) -> pygame.font.Font:
    return import_pygame().font.Font(None, size)


class Pen:
    """Paints shapes enlarged, in coordinates of the finished picture, and smooths them down to an image.

    The image has premultiplied alpha: averaging straight alpha would leave dark fringes.
    """

    def __init__(self, pg: ModuleType, size: tuple[int, int], enlargement: int = 4) -> None:
        self._pg = pg
        self._size = size
        self._enlargement = enlargement
        self._surface = pg.Surface(self._enlarged(size), pg.SRCALPHA)

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        """Fill a polygon."""
        self._pg.draw.polygon(self._surface, colour, [self._enlarged(point) for point in points])

    def disc(self, centre: Point, radius: float, colour: Colour) -> None:
        """Fill a circle."""
        self._pg.draw.circle(self._surface, colour, self._enlarged(centre), radius * self._enlargement)

    def line(self, points: Sequence[Point], colour: Colour, width: float) -> None:
        """Draw a line with round joints and ends."""
        for start, end in pairwise(points):
            across = _normal(start, end, width / 2)
            corners = [shifted(start, across, 1), shifted(end, across, 1)]
            self.polygon([*corners, shifted(end, across, -1), shifted(start, across, -1)], colour)
        for point in points:
            self.disc(point, width / 2, colour)

    def box(self, box: tuple[float, float, float, float], colour: Colour, radius: float) -> None:
        """Fill a rounded box, given by its left, top, width and height."""
        bounds = [side * self._enlargement for side in box]
        self._pg.draw.rect(self._surface, colour, bounds, border_radius=round(radius * self._enlargement))

    def image(self) -> pygame.Surface:
        """What was painted, in the size asked for."""
        return self._pg.transform.smoothscale(self._surface, self._size)

    def _enlarged(self, point: Point) -> Point:
        return point[0] * self._enlargement, point[1] * self._enlargement


def _normal(start: Point, end: Point, length: float) -> Point:
    along, down = end[0] - start[0], end[1] - start[1]
    scale = length / max(math.hypot(along, down), 1e-9)
    return -down * scale, along * scale


def shifted(point: Point, step: Point, times: float) -> Point:
    """The point some steps on."""
    return point[0] + times * step[0], point[1] + times * step[1]


def mixed(first: Colour, second: Colour, share: float) -> Colour:
    """Colour between two, `share` of the way from the first."""
    red, green, blue = (round(a + (b - a) * share) for a, b in zip(first, second, strict=True))
    return red, green, blue
