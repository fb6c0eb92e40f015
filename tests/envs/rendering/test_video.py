import os
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from pictures import film_in

from stickslip.crawler.drawing.layout import HEIGHT, WIDTH
from stickslip.envs import RecordVectorVideo, RecordVideo

pytest.importorskip("pygame")

NAME = "StickSlipCrawler-v0"


def nearest(picture, those):
    """Which of them a picture is most like; coding changes each a little."""
    return int(np.argmin([np.abs(picture[::2, ::2].astype(np.int16) - each[::2, ::2]).mean() for each in those]))


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
def test_a_video_holds_every_picture_within_the_holds(mode, tmp_path):
    env = RecordVideo(gym.make(NAME, render_mode=mode), str(tmp_path))
    twin = gym.make(NAME, render_mode="rgb_array_list")
    for each in (env, twin):
        each.reset(seed=0)
        for command in (1, 1, 0):
            each.step(command)
    env.close()
    (path,) = tmp_path.glob("*.mp4")
    (film, fps), truth = film_in(path), twin.render()
    assert fps == 30
    assert len(film) == len(truth) == 1 + 3 * 8
    for k in range(2, 24):
        assert nearest(film[k], truth[k - 1 : k + 2]) == 1


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
def test_a_video_begins_where_it_is_begun(mode, tmp_path):
    env = RecordVideo(gym.make(NAME, render_mode=mode), str(tmp_path), step_trigger=lambda step: step == 2)
    env.reset(seed=0)
    for _ in range(5):
        env.step(1)
    assert len(env.recorded_frames) == 3 * 8
    if mode == "rgb_array_list":
        assert len(env.render()) == 1 + 5 * 8
    env.close()


def test_gymnasiums_own_keeps_the_pace_with_one_picture_a_step(tmp_path):
    env = gym.wrappers.RecordVideo(gym.make(NAME, render_mode="rgb_array"), str(tmp_path))
    env.reset(seed=0)
    for command in (1, 1, 0):
        env.step(command)
    env.close()
    (path,) = tmp_path.glob("*.mp4")
    film, fps = film_in(path)
    assert (len(film), fps) == (4, pytest.approx(30 / 8))


def test_a_server_without_display_or_sound_makes_videos_of_the_rate_asked_for(tmp_path):
    code = f"""
import gymnasium, stickslip.envs
env = stickslip.envs.RecordVideo(gymnasium.make({NAME!r}, render_mode="rgb_array"), {str(tmp_path)!r}, fps=15)
env.reset(seed=0)
env.step(1)
env.close()
"""
    hidden = "SDL_VIDEODRIVER", "DISPLAY", "WAYLAND_DISPLAY"
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
    (path,) = tmp_path.glob("*.mp4")
    film, fps = film_in(path)
    assert (len(film), fps, film[0].shape) == (9, 15, (HEIGHT, WIDTH, 3))


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
def test_a_batch_is_filmed_within_its_holds(mode, tmp_path):
    batch = RecordVectorVideo(gym.make_vec(NAME, 2, render_mode=mode), str(tmp_path), video_length=16)
    batch.reset(seed=0)
    for _ in range(2):
        batch.step(np.ones(2, int))
    batch.close()
    (path,) = tmp_path.glob("*.mp4")
    film, fps = film_in(path)
    assert (len(film), fps, film[0].shape) == (17, 30, (HEIGHT, 2 * WIDTH, 3))
    first = RecordVectorVideo(gym.make_vec(NAME, 2, render_mode=mode), str(tmp_path / "first"), record_first_only=True)
    first.reset(seed=0), first.step(np.ones(2, int))
    assert [each.shape for each in first.recorded_frames] == [(HEIGHT, WIDTH, 3)] * 9
    first.close()


def test_the_window_plays_the_hold_and_closes(monkeypatch):
    import pygame

    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    paces = []

    class Clock:
        def tick(self, pace):
            paces.append(pace)

    monkeypatch.setattr(pygame.time, "Clock", Clock)
    env = gym.make(NAME, render_mode="human")
    env.reset(seed=0)
    assert pygame.display.get_caption()[0] == "stickslip"
    before = pygame.surfarray.array3d(pygame.display.get_surface())
    assert before.shape == (WIDTH, HEIGHT, 3)
    assert paces == [30]
    env.step(1)
    assert paces == [30] * 9
    assert (pygame.surfarray.array3d(pygame.display.get_surface()) != before).any()
    assert env.render() is None  # once more as it is
    assert paces == [30] * 10
    pygame.quit()  # another environment closes the window: it opens again
    env.step(0)
    assert pygame.display.get_surface().get_size() == (WIDTH, HEIGHT)
    env.close()
    assert not pygame.display.get_init()
    env.close()


@pytest.mark.parametrize("mode", ["human", "rgb_array", "rgb_array_list"])
def test_there_is_nothing_to_draw_before_reset(mode, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    with pytest.raises(ResetNeeded, match="render needs a call of reset first"):
        gym.make(NAME, render_mode=mode).unwrapped.render()


def test_drawing_without_a_mode_warns_how_to_choose_one():
    env = gym.make(NAME).unwrapped
    env.reset()
    with pytest.warns(UserWarning, match=r'render_mode="rgb_array"'):
        assert env.render() is None
