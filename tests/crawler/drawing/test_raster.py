import os
import subprocess
import sys

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled
from pictures import INK, places_of, shown_in, width_of

from stickslip.crawler.drawing.layout import HEIGHT, WIDTH
from stickslip.crawler.drawing.primitives import Disc, Line, Polygon, rectangle, Text
from stickslip.crawler.drawing.raster import Canvas

pytest.importorskip("pygame")
RED = (200, 10, 20)


def painted(*drawing):
    canvas = Canvas()
    canvas.paint(list(drawing))
    return canvas.pixels()


def test_the_picture_is_a_writable_array_of_bytes_of_its_own():
    canvas = Canvas()
    canvas.paint([])
    image = canvas.pixels()
    assert image.shape == (HEIGHT, WIDTH, 3)
    assert image.dtype == np.uint8
    assert image.flags.writeable
    assert image.flags.c_contiguous
    canvas.paint([rectangle(0, 0, 50, 50, RED)])
    assert (image == 255).all()


def test_shapes_are_where_and_as_large_as_they_say_in_red_green_blue():
    image = painted(rectangle(10, 20, 30, 40, RED), Disc((200, 100), 20, RED), Line(((300, 50), (400, 50)), RED, 6))
    assert shown_in(image, RED, 10, 20, 40, 60).all()
    assert shown_in(image, RED, 0, 0, 100, 100).sum() == 30 * 40
    assert shown_in(image, RED, 150, 50, 250, 150).sum() == pytest.approx(np.pi * 400, rel=0.1)
    assert shown_in(image, RED, 290, 40, 410, 60).sum() == pytest.approx(600, rel=0.1)


def test_edges_are_smooth_and_later_shapes_are_on_top():
    image = painted(Polygon(((10, 10), (110, 13), (110, 60), (10, 60)), RED), rectangle(50, 40, 10, 10, INK))
    edge = image[10:14, 11:110, 1]
    assert ((edge > 40) & (edge < 240)).any()
    assert shown_in(image, INK, 50, 40, 60, 50).all()


@pytest.mark.parametrize("side", [0.0, 0.5, 1.0])
def test_words_stand_at_their_place_above_all_shapes(side):
    image = painted(Text("slides", (200, 100), 23, INK, side), rectangle(0, 0, 10, 10, RED))
    ((left, top),) = places_of(image[90:140, 100:300], "slides", 23, INK)
    assert left + 100 == pytest.approx(200 - side * width_of("slides", 23), abs=1)
    assert top + 90 == 100


def test_a_subscript_is_smaller_and_lower():
    image = painted(Text("z_c", (20, 30), 40, INK))
    assert places_of(image[:100, :100], "z", 40, INK) == [(20, 30)]
    assert places_of(image[:100, :100], "c", 30, INK) == [(20 + width_of("z", 40), 42)]


def test_drawing_survives_another_environment_quitting_pygame():
    import pygame

    canvas = Canvas()
    canvas.paint([Text("sticks", (10, 10), 20, INK)])
    before = canvas.pixels()
    pygame.quit()
    canvas.paint([Text("sticks", (10, 10), 20, INK)])
    np.testing.assert_array_equal(canvas.pixels(), before)


def test_pictures_need_no_display_and_importing_leaves_pygame_alone():
    code = (
        "import sys; from stickslip.crawler.drawing.raster import Canvas; assert 'pygame' not in sys.modules;"
        "canvas = Canvas(); canvas.paint([]); import pygame; assert not pygame.display.get_init()"
    )
    hidden = ("SDL_VIDEODRIVER", "DISPLAY", "WAYLAND_DISPLAY")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


def test_missing_pygame_names_the_command_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(DependencyNotInstalled, match=r'pip install "stickslip\[render\]"'):
        Canvas()
