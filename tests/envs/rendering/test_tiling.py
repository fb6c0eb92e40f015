import re

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import RecordVideo
from pictures import GREY, MIST, places_of, width_of

from stickslip.crawler.drawing.layout import HEIGHT, WIDTH
from stickslip.envs import tile

pygame = pytest.importorskip("pygame")

NAME = "StickSlipCrawler-v0"


def pictures(count):
    return [np.full((HEIGHT, WIDTH, 3), 5 * k, np.uint8) for k in range(count)]


def test_the_pictures_are_those_of_single_environments():
    batch = gym.make_vec(NAME, 6, render_mode="rgb_array", rendered=[4, 1], max_episode_steps=5)
    singles = {i: gym.make(NAME, render_mode="rgb_array", max_episode_steps=5) for i in (4, 1)}
    batch.reset(seed=0)
    for i, single in singles.items():
        single.reset(seed=i)
    for k in range(7):
        drawn = batch.render()
        expected = [single.render() for single in singles.values()]
        assert isinstance(drawn, tuple)
        assert len(drawn) == 2
        for one, other in zip(drawn, expected, strict=True):
            np.testing.assert_array_equal(one, other)
        actions = np.full(6, k % 2)
        batch.step(actions)
        for single in singles.values():
            single.reset() if k == 5 else single.step(k % 2)


@pytest.mark.parametrize("autoreset", ["NextStep", "SameStep"])
def test_lists_are_those_that_gymnasium_makes_of_single_environments(autoreset):
    asked = {"render_mode": "rgb_array_list", "max_episode_steps": 2, "slow_motion": 0.3}
    batch = gym.make_vec(NAME, 2, autoreset_mode=autoreset, **asked)
    peers = SyncVectorEnv([lambda: gym.make(NAME, **asked)] * 2, autoreset_mode=AutoresetMode(autoreset))
    batch.reset(seed=0), peers.reset(seed=0)
    counts = []
    for k in range(6):
        if k != 1:  # they are kept until they are asked for
            drawn, expected = batch.render(), peers.render()
            counts.append(len(drawn[0]))
            assert isinstance(drawn, tuple)
            assert [len(each) for each in drawn] == [len(each) for each in expected]
            np.testing.assert_array_equal(drawn, expected)
        actions = np.array([k % 2, 1])
        batch.step(actions), peers.step(actions)
    assert counts == {"NextStep": [1, 6, 1, 3, 3], "SameStep": [1, 1, 3, 1, 3]}[autoreset]
    assert len(batch.render()[0]) == len(peers.render()[0]) > 0
    assert batch.render() == ([], [])
    batch.step(actions), peers.step(actions)
    assert [len(each) for each in batch.call("render")] == [len(each) for each in peers.call("render")] == [3, 3]
    batch.close(), peers.close()


def test_all_are_drawn_by_default():
    batch = gym.make_vec(NAME, 3, render_mode="rgb_array")
    batch.reset(seed=0)
    assert len(batch.render()) == 3


@pytest.mark.parametrize("count", [1, 2, 3, 7, 16, 40])
def test_a_tile_holds_every_picture_and_fits_a_screen(count):
    whole = tile(pictures(count))
    assert whole.shape[0] <= 1080
    assert whole.shape[1] <= 1920
    assert whole.shape[0] % 2 == whole.shape[1] % 2 == 0
    seen = np.unique(whole[:, :, 0])
    assert all(np.abs(seen.astype(int) - 5 * k).min() <= 2 for k in range(count))  # scaling truncates
    assert whole.flags.c_contiguous
    assert whole.dtype == np.uint8


def test_one_picture_is_left_as_it_is():
    picture = np.random.default_rng(0).integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)
    np.testing.assert_array_equal(tile([picture]), picture)


@pytest.mark.parametrize(("count", "columns"), [(2, 1), (3, 2), (4, 2), (7, 3), (16, 4)])
def test_pictures_are_read_line_by_line_and_as_large_as_they_can_be(count, columns):
    whole, rows = tile([3 * picture for picture in pictures(count)]), -(-count // columns)
    scale = min(1.0, (1924 / columns - 4) / WIDTH, (1084 / rows - 4) / HEIGHT)
    assert whole.shape[1] == pytest.approx(columns * (scale * WIDTH + 4) - 4, abs=columns + 1)
    assert whole.shape[0] == pytest.approx(rows * (scale * HEIGHT + 4) - 4, abs=rows + 1)
    for k in range(count):
        row, column = divmod(k, columns)
        middle = whole[int((row + 0.5) * whole.shape[0] / rows), int((column + 0.5) * whole.shape[1] / columns)]
        assert np.abs(middle - 15.0 * k).max() <= 5
    assert (whole[-20:-10, -20:-10] == MIST).all() == (count < rows * columns)  # what is left over is as the gaps are


def test_each_picture_has_its_own_name_in_its_upper_right_corner():
    names = ["first", "second", 3, "last"]
    whole = tile([np.zeros((HEIGHT, WIDTH, 3), np.uint8)] * 4, names)
    for k, name in enumerate(names):
        row, column = divmod(k, 2)
        corner = row * (HEIGHT + 3) + 60, (column + 1) * (WIDTH + 1) - 200
        ((left, top),) = places_of(
            whole[corner[0] : corner[0] + 80, corner[1] : corner[1] + 200], str(name), 30, GREY, (0, 0, 0)
        )
        assert corner[1] + left + width_of(str(name), 30) == pytest.approx((column + 1) * (WIDTH + 1) - 16, abs=4)
        assert top + 60 == pytest.approx(0.18 * HEIGHT, abs=2)


def test_names_of_small_pictures_can_still_be_read():
    whole = tile([np.zeros((HEIGHT, WIDTH, 3), np.uint8)] * 100, range(100))
    assert len(places_of(whole, "57", 14, GREY, (0, 0, 0))) == 1


def test_a_window_of_several_names_each(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    batch = gym.make_vec(NAME, 9, render_mode="human", rendered=[8, 3])
    batch.reset(seed=0)
    window = pygame.surfarray.array3d(pygame.display.get_surface()).transpose(1, 0, 2)
    batch.close()
    assert window.shape == (2 * HEIGHT + 4, WIDTH, 3)
    corners = [window[top + 60 : top + 120, WIDTH - 60 :] for top in (0, HEIGHT + 4)]
    assert [len(places_of(corner, str(name), 30, GREY)) for corner in corners for name in (8, 3)] == [1, 0, 0, 1]


def test_the_window_shows_one_picture_of_all(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    batch = gym.make_vec(NAME, 9, render_mode="human", rendered=[0, 8])
    batch.reset(seed=0)
    window = pygame.surfarray.array3d(pygame.display.get_surface())
    batch.step(np.ones(9, int))
    after = pygame.surfarray.array3d(pygame.display.get_surface())
    assert window.shape == after.shape
    assert (window != after).any()
    batch.close()
    assert not pygame.display.get_init()


def test_gymnasium_films_it(tmp_path):
    pytest.importorskip("moviepy")
    batch = RecordVideo(gym.make_vec(NAME, 2, render_mode="rgb_array"), str(tmp_path), video_length=3)
    batch.reset(seed=0)
    for _ in range(4):
        batch.step(np.ones(2, int))
    batch.close()
    assert len(list(tmp_path.glob("*.mp4"))) == 1


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: tile([]), ValueError, "pictures must hold one at least, got none"),
        (lambda: tile(pictures(2), ["one"]), ValueError, "names must be 2, one for each picture, got 1"),
        (lambda: gym.make_vec(NAME, 2, rendered=[2]), ValueError, "rendered must be a whole number in [0, 1], got 2"),
        (lambda: gym.make_vec(NAME, 2, render_mode="ansi"), ValueError, "render_mode must be one of"),
        (lambda: gym.make_vec(NAME, 2, render_mode="rgb_array").render(), ResetNeeded, "render needs a call of reset"),
    ],
)
def test_what_is_refused(call, error, message):
    with pytest.raises(error, match=re.escape(message)):
        call()


@pytest.mark.parametrize(
    "wrong",
    [np.zeros((20, 10, 3), np.uint8), np.zeros((10, 10), np.uint8), np.zeros((10, 10, 3))],
    ids=["size", "grey", "float"],
)
def test_what_is_no_picture_like_the_first_is_refused(wrong):
    with pytest.raises(ValueError, match=r"pictures must be \(height, width, 3\) arrays of uint8 of one size, got"):
        tile([np.zeros((10, 10, 3), np.uint8), wrong])
