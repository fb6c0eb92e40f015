"""A frame as shapes and words."""

from .frame import Frame, World
from .header import draw_header
from .layout import HEIGHT, LOWER, posed, WIDTH
from .palette import MIST, PAPER
from .primitives import Drawing, rectangle
from .recall import draw_message, LEFT
from .side_view import draw_crawler
from .strip import draw_strip

__all__ = ["composed"]


def composed(frame: Frame, world: World) -> Drawing:
    """All that a picture shows, in the order of painting.

    Parameters
    ----------
    frame : Frame
        Any numbers are fit to draw, those that are not finite included.
    world : World
    """
    pose = posed(frame, world)
    panels = [rectangle(0, LOWER, WIDTH, HEIGHT - LOWER, PAPER), rectangle(0, LOWER - 1, WIDTH, 1, MIST)]
    strip = draw_strip(frame, world, WIDTH - 16 if frame.message is None else LEFT - 40)
    message = [] if frame.message is None else draw_message(frame.message)
    return [*draw_crawler(frame, world, pose), *draw_header(frame, world, pose), *panels, *strip, *message]
