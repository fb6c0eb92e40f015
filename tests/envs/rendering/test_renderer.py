import copy
import math
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled

from stickslip.envs.rendering.canvas import HEIGHT, WIDTH
from stickslip.envs.rendering.frame import Frame
from stickslip.envs.rendering.renderer import Renderer

pytest.importorskip("pygame")

FRAME = Frame(
    time=3.0, deformation=0.4, pressure=0.5, foot=2.0, contact_mode=0, slid=False, valve=0, speed=0.5, memory=0.3
)


def drawn(frame):
    image = Renderer("rgb_array", fps=30).draw(frame)
    assert image is not None
    return image


def test_the_picture_is_a_writable_array_of_bytes():
    image = drawn(FRAME)
    assert image.shape == (HEIGHT, WIDTH, 3)
    assert image.dtype == np.uint8
    assert image.flags.writeable
    assert image.flags.c_contiguous


def test_pictures_do_not_share_memory():
    renderer = Renderer("rgb_array", fps=30)
    first = renderer.draw(FRAME)
    before = first.copy()
    renderer.draw(FRAME._replace(pressure=1.0))
    np.testing.assert_array_equal(first, before)


def test_channels_are_red_green_blue():
    image = drawn(FRAME._replace(pressure=1.0, deformation=1.0, valve=1)).reshape(-1, 3).astype(int)
    assert ((image == (86, 180, 233)).all(axis=1)).sum() > 500  # the pressure gauge


@pytest.mark.parametrize(
    "change",
    [
        {"time": 3.1},
        {"deformation": 0.5},
        {"pressure": 0.6},
        {"foot": 2.1},
        {"contact_mode": 1},
        {"contact_mode": -1},
        {"slid": True},
        {"valve": 1},
        {"speed": 0.6},
        {"memory": 0.4},
        {"memory": None},
    ],
    ids=str,
)
def test_every_quantity_shows(change):
    assert (drawn(FRAME) != drawn(FRAME._replace(**change))).any()


def test_sticking_and_sliding_differ_in_shape_not_in_colour_alone():
    def dark(frame):
        return drawn(frame).min(axis=2)[HEIGHT // 4 :] < 128

    changed = dark(FRAME) != dark(FRAME._replace(contact_mode=1))
    assert changed.sum() > 1000


def test_a_stretched_body_is_longer():
    def rightmost(deformation):
        above_ground = drawn(FRAME._replace(deformation=deformation))[HEIGHT // 2 : HEIGHT // 2 + 60]
        return np.flatnonzero((above_ground < 128).all(axis=2).any(axis=0)).max()

    assert rightmost(-0.5) < rightmost(0.0) < rightmost(1.0) < rightmost(2.0)


def test_a_state_drawn_twice_gives_the_same_picture():
    renderer = Renderer("rgb_array", fps=30)
    renderer.draw(FRAME)
    moved = FRAME._replace(time=3.5, foot=2.6)
    np.testing.assert_array_equal(renderer.draw(moved), renderer.draw(moved))


def test_a_new_episode_forgets_where_the_last_one_ended():
    start = FRAME._replace(time=0.0, foot=0.0)
    renderer = Renderer("rgb_array", fps=30)
    renderer.draw(FRAME._replace(time=500.0, foot=57.3))
    np.testing.assert_array_equal(renderer.draw(start), drawn(start))


def test_the_crawler_stays_in_view_whatever_its_speed():
    renderer = Renderer("rgb_array", fps=30)
    for step in range(30):
        image = renderer.draw(FRAME._replace(time=0.5 * step, foot=3.0 * step, contact_mode=1))
        orange = (image[HEIGHT // 2 :] == (213, 94, 0)).all(axis=2)
        assert orange.sum() > 500


@pytest.mark.parametrize("value", [0.0, -1e3, 1e9, -1e300, 1.7e308, math.inf, -math.inf, math.nan])
def test_no_value_is_too_wild(value):
    renderer = Renderer("rgb_array", fps=30)
    for name in ("time", "deformation", "pressure", "foot", "speed", "memory"):
        renderer.draw(FRAME._replace(**{name: value}, slid=True))
    image = renderer.draw(Frame(value, value, value, value, -1, True, 1, value, value))
    assert image.shape == (HEIGHT, WIDTH, 3)
    renderer.draw(FRAME)


def test_numpy_scalars_are_drawn_like_numbers():
    as_numpy = Frame(*(np.float32(value) for value in FRAME[:4]), np.int64(0), np.False_, np.int8(0), 0.5, 0.3)
    np.testing.assert_array_equal(drawn(as_numpy), drawn(FRAME))


def test_arrays_need_no_display():
    code = (
        "import pygame; from stickslip.envs.rendering.renderer import *; from stickslip.envs.rendering.frame import *;"
        f"image = Renderer('rgb_array', 30).draw(Frame{tuple(FRAME)!r});"
        "assert image.std() > 1 and not pygame.display.get_init()"
    )
    hidden = ("SDL_VIDEODRIVER", "DISPLAY", "WAYLAND_DISPLAY")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


def test_importing_the_module_leaves_pygame_alone():
    code = "import sys, stickslip.envs.rendering.renderer; assert 'pygame' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_missing_pygame_names_the_command_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(DependencyNotInstalled, match=r'pip install "stickslip\[render\]"'):
        Renderer("rgb_array", fps=30).draw(FRAME)


def test_a_renderer_not_yet_used_can_be_copied_and_pickled():
    renderer = Renderer("rgb_array", fps=30)
    for twin in (copy.deepcopy(renderer), pickle.loads(pickle.dumps(renderer))):
        np.testing.assert_array_equal(twin.draw(FRAME), drawn(FRAME))


def test_drawing_survives_another_environment_quitting_pygame():
    import pygame

    renderer = Renderer("rgb_array", fps=30)
    before = renderer.draw(FRAME)
    pygame.quit()
    np.testing.assert_array_equal(renderer.draw(FRAME), before)


@pytest.mark.parametrize("mode", ["human", "rgb_array"])
def test_closing_twice_is_fine_and_drawing_afterwards_too(mode, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    renderer = Renderer(mode, fps=1000)
    renderer.close()
    renderer.draw(FRAME)
    renderer.close()
    renderer.close()
    renderer.draw(FRAME)
    renderer.close()


def test_the_window_shows_the_picture(monkeypatch):
    import pygame

    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    renderer = Renderer("human", fps=1000)
    assert renderer.draw(FRAME) is None
    window = pygame.surfarray.array3d(pygame.display.get_surface()).transpose(1, 0, 2)
    np.testing.assert_array_equal(window, drawn(FRAME))
    pygame.quit()  # another environment closes the window: it opens again
    renderer.draw(FRAME)
    assert pygame.display.get_surface().get_size() == (WIDTH, HEIGHT)
    renderer.close()
    assert not pygame.display.get_init()
