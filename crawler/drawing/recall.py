"""What the body is to remember, and what a readout recalls of it, hold by hold."""

from collections.abc import Iterator

from .frame import fitting, Message
from .layout import HEIGHT, LOWER, WIDTH
from .palette import AIR, Colour, GREY, INK, MESSAGE, PAPER
from .primitives import Drawing, Polygon, Primitive, rectangle, Text

__all__ = ["SHOWN", "draw_message"]

SHOWN = 16  # holds
LEFT, RIGHT = 628, WIDTH - 16
CELL = (RIGHT - LEFT) / SHOWN
BITS_TOP, BITS_HEIGHT = LOWER + 34, 16
ZERO, REACH = HEIGHT - 56, 30
CAPTION_SIZE, TICK_SIZE = 18, 16


def draw_message(message: Message) -> Drawing:
    """Draw the last holds, the newest at the right: the valve's states, and the message beside what is recalled."""
    return [*_bits(message), *_bars(message)]


def _bits(message: Message) -> Iterator[Primitive]:
    yield Text("valve, flips marked", (LEFT, LOWER + 4), CAPTION_SIZE, GREY)
    for age, (valve, flip) in enumerate(zip(message.valves[:SHOWN], message.flips[:SHOWN], strict=True)):
        left = RIGHT - (age + 1) * CELL
        yield rectangle(left + 1, BITS_TOP, CELL - 2, BITS_HEIGHT, GREY)
        yield rectangle(left + 2.5, BITS_TOP + 1.5, CELL - 5, BITS_HEIGHT - 3, AIR if valve else PAPER)
        if flip:
            middle, tip = left + CELL / 2, BITS_TOP - 3
            yield Polygon(((middle - 6, tip - 9), (middle + 6, tip - 9), (middle, tip)), INK)


def _bars(message: Message) -> Iterator[Primitive]:
    """Of each completed hold: hollow what was sent, and filled what is recalled now."""
    yield rectangle(LEFT, ZERO, RIGHT - LEFT, 1, GREY)
    going = message.going  # whose message the body has not yet absorbed
    for age, sent in enumerate(message.sent[: SHOWN - going].tolist()):
        left = RIGHT - (age + going + 1) * CELL
        yield from _bar(left + 1, CELL - 2, sent / message.largest, GREY)
        yield from _bar(left + 2.5, CELL - 5, sent / message.largest, PAPER, 1.5)
        if age < len(message.recalled):
            yield from _bar(left + 5, CELL - 10, float(message.recalled[age]) / message.largest, MESSAGE)
    yield Text("message: sent", (LEFT + 16, HEIGHT - 18), TICK_SIZE, GREY)
    yield rectangle(LEFT, HEIGHT - 17, 11, 11, GREY)
    yield rectangle(LEFT + 1.5, HEIGHT - 15.5, 8, 8, PAPER)
    yield rectangle(LEFT + 114, HEIGHT - 17, 11, 11, MESSAGE)
    yield Text("recalled by the readout", (LEFT + 130, HEIGHT - 18), TICK_SIZE, GREY)


def _bar(left: float, width: float, value: float, colour: Colour, inset: float = 0.0) -> Iterator[Primitive]:
    tall = fitting(value, -1.0, 1.0) * REACH
    top, height = (ZERO - tall, tall) if tall > 0 else (ZERO, -tall)
    if height > 2 * inset:
        yield rectangle(left, top + inset, width, height - 2 * inset, colour)
