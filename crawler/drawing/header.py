"""What stands above the crawler: valve, gauge and the numbers."""

from collections.abc import Iterator

from .frame import Frame, World
from .layout import HOSE_AT, Pose, written
from .palette import AIR, Colour, GREY, INK, MIST, PAPER, SLIDING, STICKING
from .primitives import Drawing, Line, Polygon, Primitive, rectangle, Text

__all__ = ["VALUE_SIZE", "draw_header"]

VALVE_AXIS, VALVE_BOTTOM = HOSE_AT
GAUGE_AT, GAUGE_SIZE = (178, 36), (150, 13)
COLUMNS = (396, 510, 632, 752, 886)
CAPTION_TOP, VALUE_TOP = 16, 35
CAPTION_SIZE, VALUE_SIZE, TINY_SIZE = 18, 23, 16
FOOT_STATES = {0: "sticks", 1: "slides", -1: "slides back"}


def draw_header(frame: Frame, world: World, pose: Pose) -> Drawing:
    """Draw valve, gauge, the state of the foot and the numbers."""
    return [*_valve(bool(frame.valve)), *_gauge(world, pose), *_numbers(frame, world, pose)]


def _valve(is_open: bool) -> Iterator[Primitive]:
    """The valve on its supply line: open, it is filled with air; closed, it is empty and barred."""
    waist = VALVE_BOTTOM - 21
    yield Line(((VALVE_AXIS, -4), (VALVE_AXIS, 20)), GREY, 8)
    yield Line(((VALVE_AXIS, -4), (VALVE_AXIS, 20)), AIR, 4)  # the supply is always under pressure
    for margin, colour in ((0, INK), (3, AIR if is_open else PAPER)):
        for side in (-1, 1):
            half, end, tip = 16 - 1.7 * margin, waist + side * (21 - margin), waist + side * 1.6 * margin
            yield Polygon(((VALVE_AXIS, tip), (VALVE_AXIS - half, end), (VALVE_AXIS + half, end)), colour)
    if not is_open:
        yield Line(((VALVE_AXIS - 15, waist), (VALVE_AXIS + 15, waist)), INK, 4)
    yield Text("valve", (VALVE_AXIS + 32, CAPTION_TOP), CAPTION_SIZE, GREY)
    yield Text("open" if is_open else "closed", (VALVE_AXIS + 32, VALUE_TOP), VALUE_SIZE, INK)


def _gauge(world: World, pose: Pose) -> Iterator[Primitive]:
    """A gauge of the pressure, as full as the body."""
    (left, top), (width, height) = GAUGE_AT, GAUGE_SIZE
    peak, name = world.units.pressure, world.units.pressure_name
    yield Text(f"pressure, {name}" if name else "pressure", (left, CAPTION_TOP), CAPTION_SIZE, GREY)
    yield rectangle(left, top, width, height, MIST)
    yield rectangle(left, top, pose.pressure * width, height, AIR)
    for mark in (0, 0.5, 1):
        yield rectangle(left + mark * (width - 1), top + height, 1, 4, GREY)
        yield Text(f"{mark * peak:.3g}", (left + mark * width, top + height + 6), TINY_SIZE, GREY, 0.5)


def _numbers(frame: Frame, world: World, pose: Pose) -> Iterator[Primitive]:
    units = world.units
    state: tuple[str, Colour] = (FOOT_STATES[pose.heading], SLIDING if pose.heading else STICKING)
    if world.anchored:
        state = "clamped", INK
    entries = [
        ("foot", *state),
        ("time", f"{written(frame.time * units.time, 1 if units.time > 0.3 else 2)} {units.time_name}", INK),
        ("foot at", f"{written(frame.foot * units.length, 1)} {units.length_name}", INK),
        ("foot's speed", f"{written(frame.foot_velocity * units.length / units.time, 2)} {units.speed_name}", INK),
    ]
    if frame.memory is not None:
        entries.append(("memory", written(frame.memory, 2), INK))
    for (caption, value, colour), left in zip(entries, COLUMNS, strict=False):
        yield Text(caption, (left, CAPTION_TOP), CAPTION_SIZE, GREY)
        yield Text(value, (left, VALUE_TOP), VALUE_SIZE, colour)
