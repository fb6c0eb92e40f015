"""What stands above the crawler: valve, gauge and the numbers."""

from .canvas import AIR, Canvas, GREY, INK, MIST, SLIDING, STICKING
from .crawler_view import HOSE_AT
from .frame import Frame
from .pose import FARTHEST, Pose
from .sprites import VALVE_SIZE, valve_sprite

__all__ = ["VALUE_SIZE", "draw_gauge", "draw_readout", "draw_valve"]

# Layout, in pixels of the finished picture.
VALVE_AXIS, VALVE_BOTTOM = HOSE_AT
GAUGE_AT, GAUGE_SIZE = (178, 36), (150, 13)
READOUT_COLUMNS = (396, 520, 632, 752, 876)
CAPTION_TOP, VALUE_TOP = 18, 36
CAPTION_SIZE, VALUE_SIZE, TINY_SIZE = 17, 23, 15
FOOT_STATES = {0: "sticks", 1: "slides", -1: "slides back"}


def draw_valve(canvas: Canvas, frame: Frame) -> None:
    """Draw the valve on its supply line: open, it is filled with air; closed, it is empty and barred."""
    is_open = bool(frame.valve)
    image = canvas.sprite(("valve", is_open), lambda: valve_sprite(canvas.pg, is_open))
    canvas.place(image, VALVE_AXIS - VALVE_SIZE[0] / 2, VALVE_BOTTOM - VALVE_SIZE[1])
    canvas.text("valve", (VALVE_AXIS + 32, CAPTION_TOP), CAPTION_SIZE, GREY)
    canvas.text("open" if is_open else "closed", (VALVE_AXIS + 32, VALUE_TOP), VALUE_SIZE, INK)


def draw_gauge(canvas: Canvas, pose: Pose) -> None:
    """Draw a gauge of the pressure, as full as the body."""
    (left, top), (width, height) = GAUGE_AT, GAUGE_SIZE
    canvas.text("pressure", (left, CAPTION_TOP), CAPTION_SIZE, GREY)
    canvas.fill((left, top, width, height), MIST)
    canvas.fill((left, top, pose.pressure * width, height), AIR)
    for mark in (0, 0.5, 1):
        canvas.fill((left + mark * (width - 1), top + height, 1, 4), GREY)
        canvas.text(f"{mark:g}", (left + mark * width, top + height + 6), TINY_SIZE, GREY, centred=True)


def draw_readout(canvas: Canvas, frame: Frame) -> None:
    """Write the state of the foot and the numbers."""
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
