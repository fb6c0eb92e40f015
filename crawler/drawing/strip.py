"""What has just happened: foot, payload and valve of the last moments, against time."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from .frame import Frame, Past, World
from .layout import HEIGHT, LOWER, written
from .palette import AIR, GREY, INK, MIST, PAPER, SLIDING, STICKING
from .primitives import Drawing, Line, Point, Primitive, rectangle, Text

__all__ = ["WINDOW", "draw_strip"]

WINDOW = 10.0  # t_c that are shown
LEFT, TOP, BOTTOM = 76, LOWER + 24, HEIGHT - 40
VALVE_TOP, VALVE_HEIGHT = HEIGHT - 34, 10
CAPTION_SIZE, TICK_SIZE = 18, 16
# Of the rest length: the least that the height stands for, and how far the payload is put from the foot.
_LEAST_SPAN, _APART = 0.25, 0.4


def draw_strip(frame: Frame, world: World, right: int) -> Drawing:
    """Draw the last moments up to the edge at `right`; now is at the edge."""
    past = _shown(frame)
    return [rectangle(LEFT, TOP, right - LEFT, BOTTOM - TOP, (248, 249, 250)), *_lines(frame, world, past, right)]


def _shown(frame: Frame) -> Past:
    """What of the past is in the window, and finite."""
    since = int(np.searchsorted(frame.past.time, frame.time - WINDOW, "right"))
    recent = Past(*(each[since:] for each in frame.past))
    finite = np.isfinite(recent.foot) & np.isfinite(recent.payload) & np.isfinite(recent.time)
    return Past(*(each[finite] for each in recent))


def _lines(frame: Frame, world: World, past: Past, right: int) -> Iterator[Primitive]:
    units = world.units
    yield Text("the last moments", (LEFT, LOWER + 4), CAPTION_SIZE, GREY)
    yield from _legend(world, right)
    yield rectangle(LEFT, VALVE_TOP, right - LEFT, VALVE_HEIGHT, MIST)
    yield Text("valve", (LEFT - 8, VALVE_TOP - 1), TICK_SIZE, GREY, 1.0)
    across = (right - LEFT) / WINDOW
    yield Text(
        f"−{written(WINDOW * units.time, 2 if units.time < 0.3 else 0)} {units.time_name}",
        (LEFT, HEIGHT - 18),
        TICK_SIZE,
        GREY,
    )
    yield Text("now", (right, HEIGHT - 18), TICK_SIZE, GREY, 1.0)
    if len(past.time) < 2:
        return
    apart = past._replace(payload=past.payload + _APART * world.rest_length)
    low, high = float(past.foot.min()), float(apart.payload.max())
    least = _LEAST_SPAN * world.rest_length
    middle, span = (low + high) / 2, max(1.12 * (high - low), least)
    up = (BOTTOM - TOP) / span
    for value in sorted({float(past.foot.min()), float(past.foot.max())}):
        top = BOTTOM - (value - middle + span / 2) * up
        yield rectangle(LEFT - 4, top, 4, 1, GREY)
        yield Text(f"{written(value * units.length, 1)} {units.length_name}", (LEFT - 8, top - 6), TICK_SIZE, GREY, 1.0)
    x = (right - (frame.time - past.time) * across).tolist()
    payload, foot = ((BOTTOM - (each - middle + span / 2) * up).tolist() for each in (apart.payload, past.foot))
    yield Line(tuple(zip(x, payload, strict=True)), INK, 1.5)
    slides, opened = (past.foot_velocity != 0.0).tolist(), (past.valve > 0.0).tolist()
    places: list[Point] = list(zip(x, foot, strict=True))
    for begin, end in _spells(slides):
        line = tuple(places[max(begin - 1, 0) : end])
        colour = INK if world.anchored else SLIDING if slides[begin] else STICKING
        if len(line) > 1:
            yield Line(line, colour, 5)
            if slides[begin]:  # hollow, as the foot is
                yield Line(line, PAPER, 1.6)
    for begin, end in _spells(opened):
        if opened[begin]:
            left = x[max(begin - 1, 0)]
            yield rectangle(left, VALVE_TOP, x[end - 1] - left, VALVE_HEIGHT, AIR)


def _legend(world: World, right: int) -> Iterator[Primitive]:
    entries = [("payload", INK, 1.5, 62)]
    if world.anchored:
        entries = [("foot, clamped", INK, 5, 104), *entries]
    else:
        entries = [("foot sticks", STICKING, 5, 88), ("foot slides", SLIDING, 5, 88), *entries]
    left = right - sum(width + 34 for *_, width in entries) + 8
    for name, colour, thickness, width in entries:
        line = ((left, LOWER + 10), (left + 20, LOWER + 10))
        yield Line(line, colour, thickness)
        if colour == SLIDING:
            yield Line(line, PAPER, 1.6)
        yield Text(name, (left + 27, LOWER + 4), CAPTION_SIZE, GREY)
        left += width + 34


def _spells(states: list[bool]) -> Iterator[tuple[int, int]]:
    """Begin and end of every run of equal states."""
    turns = [0, *(k + 1 for k, (one, next_) in enumerate(pairwise(states)) if one != next_), len(states)]
    yield from pairwise(turns)
