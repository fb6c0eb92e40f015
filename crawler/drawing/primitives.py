"""What a picture is made of: filled polygons, lines, discs and words, in pixels from the upper left corner."""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple, TypeAlias

from .palette import Colour

__all__ = [
    "Disc",
    "Drawing",
    "Line",
    "Point",
    "Polygon",
    "Primitive",
    "Text",
    "rectangle",
    "rounded",
    "turned",
    "turned_point",
]

Point: TypeAlias = tuple[float, float]

_ARC = tuple((math.sin(k * math.pi / 8), math.cos(k * math.pi / 8)) for k in range(5))  # of a quarter of a circle


class Polygon(NamedTuple):
    """A filled polygon."""

    points: tuple[Point, ...]
    colour: Colour


class Line(NamedTuple):
    """A line of some width through points, with round joints and ends."""

    points: tuple[Point, ...]
    colour: Colour
    width: float


class Disc(NamedTuple):
    """A filled circle."""

    centre: Point
    radius: float
    colour: Colour


class Text(NamedTuple):
    """One line of words, from its top left, or centred on its top or ending at its top right.

    `_` makes the next character a subscript.
    """

    text: str
    at: Point
    size: int
    colour: Colour
    side: float = 0.0  # of `at` in the words' width: 0 their left end, 1/2 their middle, 1 their right end


Primitive: TypeAlias = Polygon | Line | Disc | Text
Drawing: TypeAlias = list[Primitive]
"""In the order of painting; words come last of all wherever they stand."""


def rectangle(left: float, top: float, width: float, height: float, colour: Colour) -> Polygon:
    """A filled box."""
    right, bottom = left + width, top + height
    return Polygon(((left, top), (right, top), (right, bottom), (left, bottom)), colour)


def rounded(left: float, top: float, width: float, height: float, colour: Colour, radius: float) -> Polygon:
    """A filled box with round corners."""
    radius = min(radius, width / 2, height / 2)
    x, y = (left + radius, left + width - radius), (top + radius, top + height - radius)
    points: list[Point] = []
    for centre, turn in (((x[1], y[0]), 0), ((x[1], y[1]), 1), ((x[0], y[1]), 2), ((x[0], y[0]), 3)):
        for sine, cosine in _ARC:
            across, up = sine, cosine
            for _ in range(turn):
                across, up = up, -across
            points.append((centre[0] + radius * across, centre[1] - radius * up))
    return Polygon(tuple(points), colour)


def turned_point(point: Point, angle: float, pivot: Point) -> Point:
    """A point turned about another, counter-clockwise as one sees it."""
    sine, cosine = math.sin(angle), math.cos(angle)
    across, down = point[0] - pivot[0], point[1] - pivot[1]
    return pivot[0] + cosine * across + sine * down, pivot[1] - sine * across + cosine * down


def turned(drawing: Iterable[Primitive], angle: float, pivot: Point) -> Drawing:
    """A drawing turned about a point; its words go along, and stay upright."""
    if angle == 0.0:
        return list(drawing)

    def points(those: Sequence[Point]) -> tuple[Point, ...]:
        return tuple(turned_point(point, angle, pivot) for point in those)

    moved: Drawing = []
    for each in drawing:
        if isinstance(each, Polygon | Line):
            moved.append(each._replace(points=points(each.points)))
        elif isinstance(each, Disc):
            moved.append(each._replace(centre=turned_point(each.centre, angle, pivot)))
        else:
            moved.append(each._replace(at=turned_point(each.at, angle, pivot)))
    return moved
