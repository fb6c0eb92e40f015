"""Side view of the crawler on its ground."""

import math
from itertools import pairwise

import numpy as np

from .canvas import AIR, Canvas, ELASTOMER, GREY, INK, MIST, mixed, PAPER, Pen, Point, SLIDING, WIDTH
from .frame import Frame
from .pose import fitting, PIXELS_PER_LENGTH, Pose, REST_LENGTH
from .sprites import (
    FOOT_SIZE,
    foot_sprite,
    lobe_sprite,
    PAYLOAD_SIZE,
    payload_sprite,
    TOOTH_DEPTH,
    WHEEL_RADIUS,
    wheel_sprite,
)

__all__ = ["draw_body", "draw_foot", "draw_ground", "draw_hose", "draw_payload", "draw_streaks"]

# Layout, in pixels of the finished picture.
GROUND = 258
RULER_HEIGHT = TOOTH_DEPTH
TICK_SIZE = 18
AXIS = GROUND - 72
HOSE_AT = 44, 64  # where it leaves the valve
FOOT_ANKLE = 20  # half the width of the foot where the body is clamped to it
PAYLOAD_FLANK = 34
BODY_RADIUS = 37
# Share of radius gained at full pressure; power of stretch by which it is lost.
SWELLING, THINNING = 0.42, 0.2
LOBES = 8
LONGEST_STREAK = 84


def draw_ground(canvas: Canvas, pose: Pose) -> None:
    """Draw the ground as a ruler: one cell a unit of length, every second one labelled."""
    canvas.fill((0, GROUND + RULER_HEIGHT, WIDTH, 1), MIST)
    first = math.floor(-pose.origin / PIXELS_PER_LENGTH)
    for mark in range(first, first + WIDTH // PIXELS_PER_LENGTH + 2):
        left = round(pose.origin + mark * PIXELS_PER_LENGTH)
        if mark % 2 == 0:
            canvas.fill((left, GROUND, PIXELS_PER_LENGTH, RULER_HEIGHT), MIST)
            canvas.fill((left - 1, GROUND, 2, RULER_HEIGHT + 6), GREY)
            label = f"{mark} z_c".replace("-", "−")
            canvas.text(label, (left, GROUND + RULER_HEIGHT + 11), TICK_SIZE, GREY, centred=True)
    canvas.fill((0, GROUND - 1, WIDTH, 2), INK)


def draw_hose(canvas: Canvas, pose: Pose, frame: Frame) -> None:
    """Draw the hose from the valve to the foot, in the colour of what it carries."""
    left, top = HOSE_AT
    width, height = pose.foot - left, AXIS - top + 4
    start, end = (4.0, 0.0), (width, height - 4.0)
    bends = (start[0], end[1] * 1.1), (0.4 * width, end[1])
    curve = [_bezier(start, *bends, end, step / 20) for step in range(21)]
    pen = Pen(canvas.pg, (width, height), enlargement=2)  # painted anew each frame, hence the coarser grid
    pen.line(curve, GREY, 8)
    pen.line(curve, AIR if frame.valve else PAPER, 4)
    canvas.place(pen.image(), left - 4, top)


def _bezier(start: Point, first: Point, second: Point, end: Point, at: float) -> Point:
    weights = (1 - at) ** 3, 3 * at * (1 - at) ** 2, 3 * at**2 * (1 - at), at**3
    points = start, first, second, end
    across, down = (sum(w * point[axis] for w, point in zip(weights, points, strict=True)) for axis in (0, 1))
    return across, down


def draw_body(canvas: Canvas, pose: Pose) -> None:
    """Draw the bellows: one shaded lobe, tinted and stretched, side by side from foot to payload."""
    rear, front = pose.foot + FOOT_ANKLE, pose.payload - PAYLOAD_FLANK
    stretch = (front - rear) / (REST_LENGTH * PIXELS_PER_LENGTH)
    radius = BODY_RADIUS * (1 + SWELLING * pose.pressure) / fitting(stretch, 0.5, 2.0) ** THINNING
    edges = np.linspace(rear, front, LOBES + 1).round().astype(int)
    lobe = canvas.sprite("lobe", lambda: lobe_sprite(canvas.pg)).copy()
    lobe.fill(mixed(ELASTOMER, AIR, pose.pressure), special_flags=canvas.pg.BLEND_RGB_MULT)
    height = round(2 * radius)
    # Whole pixels leave few widths; neighbours share a column, lest the background shows between them.
    images = {w: canvas.pg.transform.smoothscale(lobe, (w + 1, height)) for w in set(np.diff(edges).tolist())}
    for left, right in pairwise(edges.tolist()):
        canvas.place(images[right - left], left, AXIS - height / 2)


def draw_payload(canvas: Canvas, pose: Pose) -> None:
    """Draw the payload in front of the body, on wheels that roll with it."""
    width, height = PAYLOAD_SIZE
    left, top = pose.payload - width / 2, GROUND - height
    canvas.place(canvas.sprite("payload", lambda: payload_sprite(canvas.pg)), left, top)
    wheel = canvas.sprite("wheel", lambda: wheel_sprite(canvas.pg))
    turned = math.degrees((pose.payload - pose.origin) / WHEEL_RADIUS) % 360
    rolled = canvas.pg.transform.rotozoom(wheel, -turned, 1)
    for centre in (pose.payload - 19, pose.payload + 19):
        canvas.place(rolled, centre - rolled.get_width() / 2, GROUND - WHEEL_RADIUS - rolled.get_height() / 2)


def draw_foot(canvas: Canvas, pose: Pose) -> None:
    """Draw the foot behind the body."""
    width, height = FOOT_SIZE
    image = canvas.sprite(("foot", pose.contact_mode), lambda: foot_sprite(canvas.pg, pose.contact_mode))
    canvas.place(image, pose.foot - width / 2, GROUND + RULER_HEIGHT - height)


def draw_streaks(canvas: Canvas, pose: Pose, frame: Frame) -> None:
    """Draw streaks behind a foot that slid during the hold, longer where it went faster."""
    if not (frame.slid or pose.contact_mode):
        return
    heading = pose.contact_mode or (-1 if frame.speed < 0 else 1)
    length = fitting(30 + 30 * abs(frame.speed), 20, LONGEST_STREAK)
    for row, share in enumerate((0.6, 1.0, 0.75)):
        reach = round(length * share)
        heel = pose.foot - heading * 40
        left = heel - reach if heading > 0 else heel
        canvas.fill((left, GROUND - 34 + 10 * row, reach, 3), SLIDING)
