"""What has a fixed shape, painted once and larger than life, and smoothed down to a sprite."""

from __future__ import annotations

import math
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from .canvas import AIR, GREY, INK, MIST, mixed, PAPER, Pen, shifted, SLIDING, STICKING

if TYPE_CHECKING:
    import pygame

__all__ = [
    "FOOT_SIZE",
    "PAYLOAD_SIZE",
    "TOOTH_DEPTH",
    "VALVE_SIZE",
    "WHEEL_RADIUS",
    "foot_sprite",
    "lobe_sprite",
    "payload_sprite",
    "valve_sprite",
    "wheel_sprite",
]

FOOT_SIZE = (64, 128)
TOOTH_DEPTH = 10  # of the sprite's height, below the ground's surface
PAYLOAD_SIZE = (88, 128)
WHEEL_RADIUS = 15
VALVE_SIZE = (40, 64)


def foot_sprite(pg: ModuleType, contact_mode: int) -> pygame.Surface:
    """Paint the foot: solid with teeth dug in where it sticks, hollow with them laid flat where it slides."""
    pen = Pen(pg, FOOT_SIZE)
    middle, ground = FOOT_SIZE[0] / 2, FOOT_SIZE[1] - TOOTH_DEPTH
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


def lobe_sprite(pg: ModuleType) -> pygame.Surface:
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


def payload_sprite(pg: ModuleType) -> pygame.Surface:
    """Paint the payload without its wheels."""
    pen = Pen(pg, PAYLOAD_SIZE)
    pen.box((10, 18, 68, 90), INK, 12)
    pen.box((15, 23, 58, 80), mixed(INK, PAPER, 0.16), 8)
    for row in range(3):
        pen.box((24, 46 + 11 * row, 40, 4), INK, 2)
    return pen.image()


def wheel_sprite(pg: ModuleType) -> pygame.Surface:
    """Paint a wheel whose spokes show that it turns."""
    size, centre = 2 * WHEEL_RADIUS + 2, (WHEEL_RADIUS + 1.0, WHEEL_RADIUS + 1.0)
    pen = Pen(pg, (size, size))
    pen.disc(centre, WHEEL_RADIUS, INK)
    pen.disc(centre, WHEEL_RADIUS - 4, MIST)
    for spoke in range(3):
        angle = spoke * math.pi / 3
        reach = (WHEEL_RADIUS - 4) * math.cos(angle), (WHEEL_RADIUS - 4) * math.sin(angle)
        pen.line([shifted(centre, reach, -1), shifted(centre, reach, 1)], INK, 2)
    pen.disc(centre, 4, INK)
    return pen.image()


def valve_sprite(pg: ModuleType, is_open: bool) -> pygame.Surface:
    """Paint the valve: open, it is filled with air; closed, it is empty and barred."""
    pen = Pen(pg, VALVE_SIZE)
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
