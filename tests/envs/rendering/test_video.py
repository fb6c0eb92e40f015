import os
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from stickslip.envs.rendering.canvas import HEIGHT, WIDTH

pytest.importorskip("pygame")

NAME = "StickSlipCrawler-v0"


def test_every_step_makes_a_new_picture():
    env = gym.make(NAME, render_mode="rgb_array")
    env.reset(seed=0)
    pictures = [env.render()]
    for action in (1, 1, 0):
        env.step(action)
        pictures.append(env.render())
        np.testing.assert_array_equal(env.render(), pictures[-1])
    assert all(picture.shape == (HEIGHT, WIDTH, 3) for picture in pictures)
    assert len({picture.tobytes() for picture in pictures}) == 4
    env.close()


def test_drawing_changes_nothing_of_the_episode():
    drawn, blind = gym.make(NAME, render_mode="rgb_array"), gym.make(NAME)
    for env in (drawn, blind):
        env.reset(seed=0)
    for action in (1, 1, 1, 0, 0) * 4:
        observation, *rest = drawn.step(action)
        drawn.render()
        expected, *others = blind.step(action)
        np.testing.assert_array_equal(observation, expected)
        assert rest == others


def test_a_video_holds_the_first_picture_and_one_a_step(tmp_path):
    moviepy = pytest.importorskip("moviepy")
    # A plain process without display or sound, as on a server.
    code = f"""
import gymnasium, stickslip
env = gymnasium.wrappers.RecordVideo(gymnasium.make({NAME!r}, render_mode="rgb_array"), {str(tmp_path)!r})
env.reset(seed=0)
for k in range(20):
    env.step(k % 2)
env.close()
"""
    hidden = "SDL_VIDEODRIVER", "DISPLAY", "WAYLAND_DISPLAY"
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
    (path,) = tmp_path.glob("*.mp4")
    assert path.stat().st_size > 1000
    with moviepy.VideoFileClip(str(path)) as clip:
        assert tuple(clip.size) == (WIDTH, HEIGHT)
        assert clip.fps == 30
        pictures = list(clip.iter_frames())
    assert len(pictures) == 21
    assert np.abs(pictures[0].astype(int) - pictures[-1]).max() > 50


def test_the_window_opens_follows_and_closes(monkeypatch):
    import pygame

    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setitem(gym.make(NAME).unwrapped.metadata, "render_fps", 1000)
    env = gym.make(NAME, render_mode="human")
    env.reset(seed=0)
    before = pygame.surfarray.array3d(pygame.display.get_surface())
    assert env.render() is None
    env.step(1)
    assert (pygame.surfarray.array3d(pygame.display.get_surface()) != before).any()
    env.close()
    assert not pygame.display.get_init()
    env.close()


@pytest.mark.parametrize("mode", ["human", "rgb_array"])
def test_there_is_nothing_to_draw_before_reset(mode, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    with pytest.raises(ResetNeeded, match="render needs a call of reset first"):
        gym.make(NAME, render_mode=mode).unwrapped.render()


def test_drawing_without_a_mode_warns_how_to_choose_one():
    env = gym.make(NAME).unwrapped
    env.reset()
    with pytest.warns(UserWarning, match=r'render_mode="rgb_array"'):
        assert env.render() is None


def test_an_environment_that_has_drawn_can_be_copied():
    import copy

    env = gym.make(NAME, render_mode="rgb_array")
    env.reset(seed=0)
    env.step(1)
    picture = env.render()
    np.testing.assert_array_equal(copy.deepcopy(env).render(), picture)
