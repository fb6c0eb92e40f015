"""Side view of the crawler, drawn with pygame into a window or an array.

Everything with a fixed shape is painted once, larger than life, and smoothed down to a sprite; a frame then
only places sprites, stretches the body's lobe and sets the text. That keeps an antialiased frame cheap.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Hashable, Sequence
from functools import cache
from itertools import pairwise
from types import ModuleType
from typing import Literal, NamedTuple, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .frame import Frame
from .window import import_pygame, Window

if TYPE_CHECKING:
    import pygame

Colour = tuple[int, int, int]
Point = tuple[float, float]

# Both sides are multiples of 16, so video encoders neither pad nor rescale.
WIDTH, HEIGHT = 960, 320
REST_LENGTH = 4.0  # foot to payload at zero deformation, in z_c: the model leaves it free, the picture cannot

# The palette is Okabe and Ito's (colour-blind safe) on white, with greys for all that carries no state.
PAPER: Colour = (255, 255, 255)
INK: Colour = (45, 52, 60)
GREY: Colour = (125, 132, 140)
MIST: Colour = (224, 228, 232)
ELASTOMER: Colour = (246, 243, 236)
AIR: Colour = (86, 180, 233)
STICKING: Colour = (0, 114, 178)
SLIDING: Colour = (213, 94, 0)

# Layout, in pixels of the finished picture.
PIXELS_PER_LENGTH = 60
GROUND = 258
RULER_HEIGHT = 10
AXIS = GROUND - 72
FOOT_AT = 300  # where the camera puts a resting foot
FOOT_SIZE = (64, 128)
FOOT_ANKLE = 20  # half the width of the foot where the body is clamped to it
PAYLOAD_SIZE = (88, 128)
PAYLOAD_FLANK = 34
WHEEL_RADIUS = 15
BODY_RADIUS = 37
SWELLING, THINNING = (
    0.42,
    0.2,
)  # share of radius gained at full pressure; power of stretch by which it is lost
LOBES = 8
VALVE_AXIS, VALVE_BOTTOM, VALVE_SIZE = 44, 64, (40, 64)
GAUGE_AT, GAUGE_SIZE = (178, 36), (150, 13)
READOUT_COLUMNS = (396, 520, 632, 752, 876)
FOOT_STATES = {0: "sticks", 1: "slides", -1: "slides back"}
CAPTION_TOP, VALUE_TOP = 18, 36
CAPTION_SIZE, VALUE_SIZE, TICK_SIZE, TINY_SIZE = 17, 23, 18, 15
SUBSCRIPT_SIZE, SUBSCRIPT_DROP = 0.75, 0.3  # relative to the text's

# The drawing stays within these whatever the numbers; the readout always shows the numbers themselves.
DEFORMATION_LIMITS = (-2.2, 4.5)
FARTHEST = 1e6
LATEST = 1e12
LONGEST_STREAK = 84

CAMERA_TIME = 1.5  # the camera closes its distance to the crawler with this time constant, in t_c
CAMERA_LAG = 1.5  # and is never farther behind than this, in z_c


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
        self._camera = _Camera()
        self._canvas: _Canvas | None = None
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
            self._canvas = _Canvas(import_pygame())
        _compose(self._canvas, frame, self._camera)
        if self.mode == "rgb_array":
            return self._canvas.pixels()
        self._window.show(self._canvas.surface)
        return None

    def close(self) -> None:
        """Close the window, if there is one. A closed renderer may draw again."""
        self._window.close()
        self._canvas = None


class _Camera:
    """Follows the foot smoothly, in the frames' own time: a state drawn twice looks the same twice."""

    def __init__(self) -> None:
        self._position = 0.0
        self._time = math.inf

    def follow(self, position: float, time: float) -> float:
        elapsed = time - self._time
        if elapsed < 0:  # the first frame, or a new episode
            self._position = position
        else:
            self._position += (position - self._position) * (1 - math.exp(-elapsed / CAMERA_TIME))
        self._position = min(max(self._position, position - CAMERA_LAG), position + CAMERA_LAG)
        self._time = time
        return self._position


class _Pen:
    """Paints shapes enlarged, in coordinates of the finished picture, and smooths them down to an image.

    The image has premultiplied alpha: averaging straight alpha would leave dark fringes.
    """

    def __init__(self, pg: ModuleType, size: tuple[int, int], enlargement: int = 4) -> None:
        self._pg = pg
        self._size = size
        self._enlargement = enlargement
        self._surface = pg.Surface(self._enlarged(size), pg.SRCALPHA)

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        self._pg.draw.polygon(self._surface, colour, [self._enlarged(point) for point in points])

    def disc(self, centre: Point, radius: float, colour: Colour) -> None:
        self._pg.draw.circle(self._surface, colour, self._enlarged(centre), radius * self._enlargement)

    def line(self, points: Sequence[Point], colour: Colour, width: float) -> None:
        """Draw a line with round joints and ends."""
        for start, end in pairwise(points):
            across = _normal(start, end, width / 2)
            corners = [_shifted(start, across, 1), _shifted(end, across, 1)]
            self.polygon([*corners, _shifted(end, across, -1), _shifted(start, across, -1)], colour)
        for point in points:
            self.disc(point, width / 2, colour)

    def box(self, box: tuple[float, float, float, float], colour: Colour, radius: float) -> None:
        """Fill a rounded box, given by its left, top, width and height."""
        bounds = [side * self._enlargement for side in box]
        self._pg.draw.rect(self._surface, colour, bounds, border_radius=round(radius * self._enlargement))

    def image(self) -> pygame.Surface:
        return self._pg.transform.smoothscale(self._surface, self._size)

    def _enlarged(self, point: Point) -> Point:
        return point[0] * self._enlargement, point[1] * self._enlargement


def _normal(start: Point, end: Point, length: float) -> Point:
    along, down = end[0] - start[0], end[1] - start[1]
    scale = length / max(math.hypot(along, down), 1e-9)
    return -down * scale, along * scale


def _shifted(point: Point, step: Point, times: float) -> Point:
    return point[0] + times * step[0], point[1] + times * step[1]


class _Canvas:
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
        self.surface.blit(image, (round(left), round(top)), special_flags=self.pg.BLEND_PREMULTIPLIED)

    def fill(self, box: tuple[float, float, float, float], colour: Colour) -> None:
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
        # Twice as fast as pygame.surfarray; the bytearray makes the array writable.
        data = bytearray(self.pg.image.tobytes(self.surface, "RGB"))
        return np.frombuffer(data, np.uint8).reshape(HEIGHT, WIDTH, 3)


@cache
def _font(size: int) -> pygame.font.Font:
    return import_pygame().font.Font(None, size)


def _mixed(first: Colour, second: Colour, share: float) -> Colour:
    red, green, blue = (round(a + (b - a) * share) for a, b in zip(first, second, strict=True))
    return red, green, blue


def _fitting(value: float, low: float, high: float) -> float:
    """Clip a number into an interval; what is not a number is drawn as zero."""
    return 0.0 if math.isnan(value) else min(max(value, low), high)


class _Pose(NamedTuple):
    """A frame in pixels, fit to draw: where things stand and how the body looks."""

    origin: float  # of the ground's coordinate
    foot: int
    payload: int
    pressure: float
    contact_mode: int


def _compose(canvas: _Canvas, frame: Frame, camera: _Camera) -> None:
    pose = _posed(frame, camera)
    canvas.surface.fill(PAPER)
    _draw_ground(canvas, pose)
    _draw_hose(canvas, pose, frame)
    _draw_streaks(canvas, pose, frame)
    _draw_body(canvas, pose)
    _draw_payload(canvas, pose)
    _draw_foot(canvas, pose)
    _draw_valve(canvas, frame)
    _draw_gauge(canvas, pose)
    _draw_readout(canvas, frame)


def _posed(frame: Frame, camera: _Camera) -> _Pose:
    foot = _fitting(frame.foot, -FARTHEST, FARTHEST)
    length = REST_LENGTH + _fitting(frame.deformation, *DEFORMATION_LIMITS)
    origin = FOOT_AT - camera.follow(foot, _fitting(frame.time, -LATEST, LATEST)) * PIXELS_PER_LENGTH
    return _Pose(
        origin=origin,
        foot=round(origin + foot * PIXELS_PER_LENGTH),
        payload=round(origin + (foot + length) * PIXELS_PER_LENGTH),
        pressure=_fitting(frame.pressure, 0.0, 1.0),
        contact_mode=frame.contact_mode,
    )


def _draw_ground(canvas: _Canvas, pose: _Pose) -> None:
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


def _draw_hose(canvas: _Canvas, pose: _Pose, frame: Frame) -> None:
    """Draw the hose from the valve to the foot, in the colour of what it carries."""
    width, height = pose.foot - VALVE_AXIS, AXIS - VALVE_BOTTOM + 4
    start, end = (4.0, 0.0), (width, height - 4.0)
    bends = (start[0], end[1] * 1.1), (0.4 * width, end[1])
    curve = [_bezier(start, *bends, end, step / 20) for step in range(21)]
    pen = _Pen(canvas.pg, (width, height), enlargement=2)  # painted anew each frame, hence the coarser grid
    pen.line(curve, GREY, 8)
    pen.line(curve, AIR if frame.valve else PAPER, 4)
    canvas.place(pen.image(), VALVE_AXIS - 4, VALVE_BOTTOM)


def _bezier(start: Point, first: Point, second: Point, end: Point, at: float) -> Point:
    weights = (1 - at) ** 3, 3 * at * (1 - at) ** 2, 3 * at**2 * (1 - at), at**3
    points = start, first, second, end
    across, down = (sum(w * point[axis] for w, point in zip(weights, points, strict=True)) for axis in (0, 1))
    return across, down


def _draw_body(canvas: _Canvas, pose: _Pose) -> None:
    """Draw the bellows: one shaded lobe, tinted and stretched, side by side from foot to payload."""
    rear, front = pose.foot + FOOT_ANKLE, pose.payload - PAYLOAD_FLANK
    stretch = (front - rear) / (REST_LENGTH * PIXELS_PER_LENGTH)
    radius = BODY_RADIUS * (1 + SWELLING * pose.pressure) / _fitting(stretch, 0.5, 2.0) ** THINNING
    edges = np.linspace(rear, front, LOBES + 1).round().astype(int)
    lobe = canvas.sprite("lobe", lambda: _lobe(canvas.pg)).copy()
    lobe.fill(_mixed(ELASTOMER, AIR, pose.pressure), special_flags=canvas.pg.BLEND_RGB_MULT)
    height = round(2 * radius)
    # Whole pixels leave few widths; neighbours share a column, lest the background shows between them.
    images = {w: canvas.pg.transform.smoothscale(lobe, (w + 1, height)) for w in set(np.diff(edges).tolist())}
    for left, right in pairwise(edges.tolist()):
        canvas.place(images[right - left], left, AXIS - height / 2)


def _lobe(pg: ModuleType) -> pygame.Surface:
    """Shade one lobe of the bellows as a solid of revolution lit from above, in greys to be tinted."""
    width, height = 96, 256
    across = np.linspace(-1, 1, width)[:, None]
    down = np.linspace(-1, 1, height)[None, :]
    profile = 0.80 + 0.20 * np.sqrt(1 - np.abs(across) ** 2.6)
    cover = np.clip((profile - np.abs(down)) * height / 4, 0, 1)
    tilt = np.clip(down / profile, -1, 1)
    facing = np.sqrt(1 - tilt**2)
    light = 0.62 + 0.38 * np.clip(0.8 * facing - 0.6 * tilt, 0, 1)
    light = light * (1 - 0.2 * np.abs(across) ** 3)
    image = pg.Surface((width, height), pg.SRCALPHA)
    grey = np.round(255 * light * cover).astype(np.uint8)
    pg.surfarray.blit_array(image, np.repeat(grey[:, :, None], 3, axis=2))
    pg.surfarray.pixels_alpha(image)[:] = np.round(255 * cover).astype(np.uint8)
    return image


def _draw_payload(canvas: _Canvas, pose: _Pose) -> None:
    width, height = PAYLOAD_SIZE
    left, top = pose.payload - width / 2, GROUND - height
    canvas.place(canvas.sprite("payload", lambda: _payload(canvas.pg)), left, top)
    wheel = canvas.sprite("wheel", lambda: _wheel(canvas.pg))
    turned = math.degrees((pose.payload - pose.origin) / WHEEL_RADIUS) % 360
    rolled = canvas.pg.transform.rotozoom(wheel, -turned, 1)
    for centre in (pose.payload - 19, pose.payload + 19):
        canvas.place(rolled, centre - rolled.get_width() / 2, GROUND - WHEEL_RADIUS - rolled.get_height() / 2)


def _payload(pg: ModuleType) -> pygame.Surface:
    pen = _Pen(pg, PAYLOAD_SIZE)
    pen.box((10, 18, 68, 90), INK, 12)
    pen.box((15, 23, 58, 80), _mixed(INK, PAPER, 0.16), 8)
    for row in range(3):
        pen.box((24, 46 + 11 * row, 40, 4), INK, 2)
    return pen.image()


def _wheel(pg: ModuleType) -> pygame.Surface:
    size, centre = 2 * WHEEL_RADIUS + 2, (WHEEL_RADIUS + 1.0, WHEEL_RADIUS + 1.0)
    pen = _Pen(pg, (size, size))
    pen.disc(centre, WHEEL_RADIUS, INK)
    pen.disc(centre, WHEEL_RADIUS - 4, MIST)
    for spoke in range(3):
        angle = spoke * math.pi / 3
        reach = (WHEEL_RADIUS - 4) * math.cos(angle), (WHEEL_RADIUS - 4) * math.sin(angle)
        pen.line([_shifted(centre, reach, -1), _shifted(centre, reach, 1)], INK, 2)
    pen.disc(centre, 4, INK)
    return pen.image()


def _draw_foot(canvas: _Canvas, pose: _Pose) -> None:
    width, height = FOOT_SIZE
    image = canvas.sprite(("foot", pose.contact_mode), lambda: _foot(canvas.pg, pose.contact_mode))
    canvas.place(image, pose.foot - width / 2, GROUND + RULER_HEIGHT - height)


def _foot(pg: ModuleType, contact_mode: int) -> pygame.Surface:
    """Paint the foot: solid with teeth dug in where it sticks, hollow with them laid flat where it slides."""
    pen = _Pen(pg, FOOT_SIZE)
    middle, ground = FOOT_SIZE[0] / 2, FOOT_SIZE[1] - RULER_HEIGHT
    colour = SLIDING if contact_mode else STICKING
    for tooth in range(5):
        root = middle - 18 + 9 * tooth
        if contact_mode:
            pen.line([(root, ground - 12), (root - 13 * contact_mode, ground - 2)], colour, 2.5)
        else:
            pen.polygon([(root - 4.5, ground - 14), (root + 4.5, ground - 14), (root - 5, ground + 9)], colour)
    pen.box((middle - 27, ground - 28, 54, 17), colour, 7)
    pen.box((middle - 20, ground - 108, 40, 92), colour, 10)
    if contact_mode:
        pen.box((middle - 15, ground - 103, 30, 82), PAPER, 6)
    return pen.image()


def _draw_streaks(canvas: _Canvas, pose: _Pose, frame: Frame) -> None:
    """Draw streaks behind a foot that slid during the hold, longer where it went faster."""
    if not (frame.slid or pose.contact_mode):
        return
    heading = pose.contact_mode or (-1 if frame.speed < 0 else 1)
    length = _fitting(30 + 30 * abs(frame.speed), 20, LONGEST_STREAK)
    for row, share in enumerate((0.6, 1.0, 0.75)):
        reach = round(length * share)
        heel = pose.foot - heading * 40
        left = heel - reach if heading > 0 else heel
        canvas.fill((left, GROUND - 34 + 10 * row, reach, 3), SLIDING)


def _draw_valve(canvas: _Canvas, frame: Frame) -> None:
    """Draw the valve on its supply line: open, it is filled with air; closed, it is empty and barred."""
    is_open = bool(frame.valve)
    image = canvas.sprite(("valve", is_open), lambda: _valve(canvas.pg, is_open))
    canvas.place(image, VALVE_AXIS - VALVE_SIZE[0] / 2, VALVE_BOTTOM - VALVE_SIZE[1])
    canvas.text("valve", (VALVE_AXIS + 32, CAPTION_TOP), CAPTION_SIZE, GREY)
    canvas.text("open" if is_open else "closed", (VALVE_AXIS + 32, VALUE_TOP), VALUE_SIZE, INK)


def _valve(pg: ModuleType, is_open: bool) -> pygame.Surface:
    pen = _Pen(pg, VALVE_SIZE)
    middle, bottom = VALVE_SIZE[0] / 2, VALVE_SIZE[1]
    pen.line([(middle, -4), (middle, 20)], GREY, 8)
    pen.line([(middle, -4), (middle, 20)], AIR, 4)  # the supply is always under pressure
    waist = bottom - 21
    for margin, colour in ((0, INK), (3, AIR if is_open else PAPER)):
        for side in (-1, 1):
            half, end, tip = 16 - 1.7 * margin, waist + side * (21 - margin), waist + side * 1.6 * margin
            pen.polygon([(middle, tip), (middle - half, end), (middle + half, end)], colour)
    if not is_open:
        pen.line([(middle - 15, waist), (middle + 15, waist)], INK, 4)
    return pen.image()


def _draw_gauge(canvas: _Canvas, pose: _Pose) -> None:
    (left, top), (width, height) = GAUGE_AT, GAUGE_SIZE
    canvas.text("pressure", (left, CAPTION_TOP), CAPTION_SIZE, GREY)
    canvas.fill((left, top, width, height), MIST)
    canvas.fill((left, top, pose.pressure * width, height), AIR)
    for mark in (0, 0.5, 1):
        canvas.fill((left + mark * (width - 1), top + height, 1, 4), GREY)
        canvas.text(f"{mark:g}", (left + mark * width, top + height + 6), TINY_SIZE, GREY, centred=True)


def _draw_readout(canvas: _Canvas, frame: Frame) -> None:
    entries = (
        ("foot", FOOT_STATES[frame.contact_mode], SLIDING if frame.contact_mode else STICKING),
        ("time", f"{_written(frame.time, 1)} t_c", INK),
        ("distance", f"{_written(frame.foot, 1)} z_c", INK),
        ("speed", f"{_written(frame.speed, 2)} z_c/t_c", INK),
        ("memory", "–" if frame.memory is None else _written(frame.memory, 2), INK),
    )
    for (caption, value, colour), left in zip(entries, READOUT_COLUMNS, strict=True):
        canvas.text(caption, (left, CAPTION_TOP), CAPTION_SIZE, GREY)
        canvas.text(value, (left, VALUE_TOP), VALUE_SIZE, colour)


def _written(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}" if abs(value) < FARTHEST else f"{value:.0e}"
    return text.replace("-", "−")
