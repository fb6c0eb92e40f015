"""Side view of the crawler on its ground."""

import math
from collections.abc import Iterator
from itertools import pairwise

from .frame import fitting, Frame, World
from .layout import GROUND, HOSE_AT, PIVOT, Pose, REST_PIXELS, WIDTH
from .palette import AIR, Colour, ELASTOMER, GREY, INK, MIST, mixed, PAPER, SLIDING, STICKING
from .primitives import Disc, Drawing, Line, Point, Polygon, Primitive, rectangle, rounded, Text, turned, turned_point

__all__ = ["draw_crawler", "ruler_step"]

RULER = 10  # height
TICK_SIZE = 18
AXIS = GROUND - 70  # height of the body's middle
ANKLE, FLANK = 19, 33  # half the widths of foot and payload where the body is fixed to them
RADIUS = 35
# Share of radius gained at full pressure; power of stretch by which it is lost.
SWELLING, THINNING = 0.42, 0.2
LOBES, MOST_LOBES = 8, 48
WHEEL = 15
PIXELS_A_LABEL = 105  # at least

# Bands of a lobe from its top (-1) to its bottom (1), and how light each is.
_BANDS = ((-1.0, -0.72, 0.93), (-0.72, -0.3, 1.0), (-0.3, 0.25, 0.92), (0.25, 0.66, 0.8), (0.66, 1.0, 0.66))
_PROFILE = tuple((u / 6, 0.78 + 0.22 * math.sqrt(max(0.0, 1.0 - abs(u / 6) ** 2.6))) for u in range(-6, 7))


def draw_crawler(frame: Frame, world: World, pose: Pose) -> Drawing:
    """Draw ground, hose, body, payload and foot, turned by the slope."""
    level = [*_ground(world, pose), *_streaks(world, pose), *_body(pose), *_payload(pose), *_foot(world, pose)]
    inlet = turned_point((pose.foot, AXIS), world.angle, PIVOT)
    return [*_hose(frame, inlet), *turned(level, world.angle, PIVOT), *_incline(world)]


def ruler_step(scale: float) -> float:
    """Length between two labels: 1, 2 or 5 times a power of ten, at least `PIXELS_A_LABEL` of `scale` pixels each."""
    least = PIXELS_A_LABEL / scale
    power = 10.0 ** math.floor(math.log10(least))
    return next(times * power for times in (1.0, 2.0, 5.0, 10.0) if times * power >= least)


def _ground(world: World, pose: Pose) -> Iterator[Primitive]:
    """The ground as a ruler: a cell is half the length between two labels."""
    units = world.units
    scale = pose.scale / units.length
    step = ruler_step(scale)
    cell = step / 2
    decimals = max(0, -math.floor(math.log10(step)))
    beyond = 80
    yield rectangle(-beyond, GROUND + RULER, WIDTH + 2 * beyond, 1, MIST)
    first = math.floor((-beyond - pose.origin) / scale / cell)
    for mark in range(first, first + math.ceil((WIDTH + 2 * beyond) / scale / cell) + 2):
        left = pose.origin + mark * cell * scale
        if mark % 2 == 0:
            yield rectangle(left, GROUND, cell * scale, RULER, MIST)
            yield rectangle(left - 1, GROUND, 2, RULER + 6, GREY)
            label = f"{mark * cell:.{decimals}f} {units.length_name}".replace("-", "−")
            yield Text(label, (left, GROUND + RULER + 11), TICK_SIZE, GREY, 0.5)
    yield rectangle(-beyond, GROUND - 1, WIDTH + 2 * beyond, 2, INK)


def _incline(world: World) -> Iterator[Primitive]:
    """What says that the ground is steep: the horizontal dashed, and the slope in words."""
    if world.angle == 0.0:
        return
    ends = [turned_point((at, GROUND), world.angle, PIVOT) for at in (WIDTH - 150.0, WIDTH)]
    top = min(down for _, down in ends)
    for dash in range(8):
        yield rectangle(WIDTH - 150 + 18 * dash, top, 10, 1.5, GREY)
    yield Text(world.slope, (WIDTH - 16, top - 20), TICK_SIZE, INK, 1.0)


def _hose(frame: Frame, inlet: Point) -> Iterator[Primitive]:
    """The hose from the valve to the foot, in the colour of what it carries."""
    left, top = HOSE_AT
    width, height = inlet[0] - left, inlet[1] - top
    bends = (left, top + 1.1 * height), (left + 0.4 * width, inlet[1])
    curve = tuple(_bezier((left, top), *bends, inlet, step / 24) for step in range(25))
    yield Line(curve, GREY, 8)
    yield Line(curve, AIR if frame.valve else PAPER, 4)


def _bezier(start: Point, first: Point, second: Point, end: Point, at: float) -> Point:
    weights = (1 - at) ** 3, 3 * at * (1 - at) ** 2, 3 * at**2 * (1 - at), at**3
    points = start, first, second, end
    across, down = (sum(w * point[axis] for w, point in zip(weights, points, strict=True)) for axis in (0, 1))
    return across, down


def _body(pose: Pose) -> Iterator[Primitive]:
    """The bellows, segment by segment: lobes tinted by the pressure, thin where they are stretched."""
    rear, front = pose.foot + ANKLE, pose.ends[-1] - FLANK
    squeeze = (front - rear) / (pose.ends[-1] - pose.foot)
    joints = [rear + squeeze * (end - pose.foot) for end in (pose.foot, *pose.ends)]
    count = len(pose.ends)
    stride = math.ceil(count / MOST_LOBES)  # segments that share a lobe
    each = math.ceil(LOBES / count) if count < LOBES else 1  # lobes of a segment
    colour = mixed(ELASTOMER, AIR, pose.pressure)
    joints = [*joints[:-1:stride], joints[-1]]
    for k, (left, right) in enumerate(pairwise(joints)):
        stretch = (right - left) / (stride * REST_PIXELS / count)
        radius = RADIUS * (1 + SWELLING * pose.pressure) / max(stretch, 0.2) ** THINNING
        for lobe in range(each):
            width = (right - left) / each
            yield from _lobe(left + lobe * width, width, radius, colour)
        if count > 1 and each > 1 and k:
            yield Line(((left, AXIS - 0.82 * radius), (left, AXIS + 0.82 * radius)), GREY, 2.5)


def _lobe(left: float, width: float, radius: float, colour: Colour) -> Iterator[Primitive]:
    middle, half = left + width / 2, width / 2 + 0.3  # neighbours overlap, lest the background shows between them
    for top, bottom, light in _BANDS:
        upper = [(middle + u * half, AXIS + top * radius * profile) for u, profile in _PROFILE]
        lower = [(middle + u * half, AXIS + bottom * radius * profile) for u, profile in reversed(_PROFILE)]
        yield Polygon((*upper, *lower), mixed((40, 60, 75), colour, light))
    yield Line(((left, AXIS - 0.78 * radius), (left, AXIS + 0.78 * radius)), mixed((40, 60, 75), colour, 0.72), 1)


def _payload(pose: Pose) -> Iterator[Primitive]:
    """The payload in front of the body, on wheels that roll with it."""
    at, top = pose.ends[-1], GROUND - 110
    yield rounded(at - 34, top, 68, 90, INK, 12)
    yield rounded(at - 29, top + 5, 58, 80, mixed(INK, PAPER, 0.16), 8)
    for row in range(3):
        yield rounded(at - 20, top + 28 + 11 * row, 40, 4, INK, 2)
    turn = (at - pose.origin) / WHEEL
    for centre in (at - 19, at + 19):
        hub = centre, GROUND - WHEEL
        yield Disc(hub, WHEEL, INK)
        yield Disc(hub, WHEEL - 4, MIST)
        for spoke in range(3):
            angle = turn + spoke * math.pi / 3
            across, down = (WHEEL - 4) * math.cos(angle), (WHEEL - 4) * math.sin(angle)
            yield Line(((hub[0] - across, hub[1] - down), (hub[0] + across, hub[1] + down)), INK, 2)
        yield Disc(hub, 4, INK)


def _foot(world: World, pose: Pose) -> Iterator[Primitive]:
    """The foot behind the body: clamped, or solid where it sticks and hollow where it slides.

    A ratchet's teeth dig into the ground where it sticks, and lie flat behind where it slides. Without one the foot is
    a pad. Where it sticks the ground beneath is hatched.
    """
    at = pose.foot
    if world.anchored:
        yield from _clamp(at)
        return
    colour = SLIDING if pose.heading else STICKING
    lift = 5 if pose.heading else 0
    if not pose.heading:
        for stroke in range(9):
            left = at - 44 + 10 * stroke
            yield Line(((left + 9, GROUND + 2), (left, GROUND + 15)), STICKING, 2.5)
    if world.ratchet:
        for tooth in range(5):
            root = at - 18 + 9 * tooth
            if pose.heading:
                yield Line(((root, GROUND - 13), (root - 13 * pose.heading, GROUND - 3)), colour, 2.5)
            else:
                teeth = (root - 4.5, GROUND - 13), (root + 4.5, GROUND - 13), (root - 5, GROUND + 9)
                yield Polygon(teeth, colour)
        yield rounded(at - 27, GROUND - 28, 54, 17, colour, 7)
    else:
        yield rounded(at - 32, GROUND - 22 - lift, 64, 21, colour, 10)
    yield rounded(at - 20, GROUND - 110 - lift, 40, 94, colour, 10)
    if pose.heading:
        yield rounded(at - 14, GROUND - 104 - lift, 28, 82, PAPER, 6)


def _clamp(at: float) -> Iterator[Primitive]:
    """A wall that the body is bolted to."""
    left, top = at - 44, GROUND - 132
    for stroke in range(9):
        down = top + 4 + 16 * stroke
        yield Line(((left - 1, down), (left - 17, min(down + 16, GROUND))), GREY, 2.5)
    yield rectangle(left - 2, top, 10, GROUND - top, INK)
    yield rounded(left + 8, AXIS - 38, 16, 76, GREY, 3)
    for bolt in (-26, 26):
        yield rounded(left + 4, AXIS + bolt - 5, 26, 10, INK, 3)
    yield rounded(left + 24, AXIS - 16, 42, 32, GREY, 4)


def _streaks(world: World, pose: Pose) -> Iterator[Primitive]:
    """Streaks behind a foot that slides and an arrow ahead of it, longer where it is faster."""
    if not pose.heading or world.anchored:
        return
    # Half of what a stretch as large as the rest length's fourth takes of a unit of time.
    length = 26 + 62 * fitting(abs(pose.speed) * pose.scale / 60, 0.0, 1.4)
    for row, share in enumerate((0.6, 1.0, 0.75, 0.5)):
        heel = pose.foot - pose.heading * (34 if row < 3 else 38)
        tail = heel - pose.heading * length * share
        yield Line(((heel, GROUND - 55 + 15 * row), (tail, GROUND - 55 + 15 * row)), SLIDING, 3)
