"""The picture says what is so: its words, and where which colour is."""

import gymnasium as gym
import numpy as np
import pytest
from pictures import AIR, BLUE, box_of, GREY, INK, MIST, ORANGE, places_of, shown_in, width_of

from stickslip.envs.rendering.frame import Frame
from stickslip.envs.rendering.renderer import Renderer

RESTING = Frame(0.0, 0.4, 0.5, 2.0, 0, False, 0, 0.5, 0.3)
SLIDING, BACKWARD = (RESTING._replace(contact_mode=mode) for mode in (1, -1))
SCALE, GROUND, FOOT = 60, 258, 300  # pixels a unit of length; the ground's height; where the camera puts the foot
HEADER = 70  # the words' height


def drawn(frame, **changes):
    return Renderer("rgb_array", fps=30).draw(frame._replace(**changes))


def words(image, text, left, colour=INK, size=23):
    """Tops of this text in the header where its column begins."""
    return [top for found, top in places_of(image[:HEADER, left - 5 : left + 190], text, size, colour) if found == 5]


COLUMNS = {"valve": 76, "pressure": 178, "foot": 396, "time": 520, "distance": 632, "speed": 752, "memory": 876}


def test_every_column_has_its_caption():
    image = drawn(RESTING)
    for caption, left in COLUMNS.items():
        assert words(image, caption, left, GREY, 17) == [18], caption


@pytest.mark.parametrize(
    ("changes", "column", "text"),
    [
        ({}, "time", "0.0 t"),
        ({"time": 12.26}, "time", "12.3 t"),
        ({"time": 1e7}, "time", "1e+07 t"),
        ({}, "distance", "2.0 z"),
        ({"foot": -13.34}, "distance", "−13.3 z"),
        ({}, "speed", "0.50 z"),
        ({"speed": -1.234}, "speed", "−1.23 z"),
        ({}, "memory", "0.30"),
        ({"memory": -0.555}, "memory", "−0.56"),
        ({"memory": 12.0}, "memory", "12.00"),
        ({"memory": None}, "memory", "–"),
        ({"valve": 0}, "valve", "closed"),
        ({"valve": 1}, "valve", "open"),
    ],
    ids=str,
)
def test_the_words_are_the_numbers(changes, column, text):
    assert words(drawn(RESTING, **changes), text, COLUMNS[column]) == [36]


def test_lengths_times_and_speeds_have_their_units():
    header = drawn(RESTING)[:HEADER]
    subscripts = [left for left, _ in places_of(header, "c", round(23 * 0.75), INK)]
    assert [sum(COLUMNS[name] < left < COLUMNS[name] + 110 for left in subscripts) for name in COLUMNS] == [
        *(0, 0, 0),
        *(1, 1, 2),
        0,
    ]
    assert len(places_of(header[:, 752:], "/t", 23, INK)) == 1


@pytest.mark.parametrize(
    ("frame", "text", "colour", "other"),
    [(RESTING, "sticks", BLUE, ORANGE), (SLIDING, "slides", ORANGE, BLUE), (BACKWARD, "slides back", ORANGE, BLUE)],
)
def test_the_foot_is_blue_where_it_sticks_and_orange_where_it_slides(frame, text, colour, other):
    image = drawn(frame)
    assert words(image, text, COLUMNS["foot"], colour) == [36]
    assert bool(words(image, "slides back", COLUMNS["foot"], ORANGE)) == (frame is BACKWARD)
    assert not shown_in(image, other).any()
    foot = shown_in(image, colour, 260, 140, 330)
    left, top, right, bottom = box_of(foot)
    assert (left + 260, right + 260) == pytest.approx((FOOT - 27, FOOT + 27), abs=10)
    assert top + 140 == pytest.approx(150, abs=2)
    # Teeth reach below the ground's surface where it sticks, and stay on it where it slides.
    assert (bottom + 140 > GROUND + 2) == (frame is RESTING)
    # And it is hollow where it slides.
    inside = image[170:220, FOOT - 8 : FOOT + 8].reshape(-1, 3)
    assert (inside == (colour if frame is RESTING else (255, 255, 255))).all()


def test_teeth_trail_behind_a_sliding_foot():
    reach = {}
    for frame in (SLIDING, BACKWARD):
        left, _, right, _ = box_of(shown_in(drawn(frame), ORANGE, FOOT - 40, GROUND - 8, FOOT + 40, GROUND - 2))
        reach[frame] = left - 40, right - 40
    assert reach[SLIDING][0] < -28 < reach[BACKWARD][0]
    assert reach[SLIDING][1] < 28 < reach[BACKWARD][1]


def streaks(frame, **changes):
    """Left and right ends of the streaks, from the foot."""
    image = drawn(frame, **changes)
    mask = shown_in(image, ORANGE, 0, GROUND - 34, 960, GROUND - 10)
    mask[:, FOOT - 35 : FOOT + 35] = False
    if not mask.any():
        return None
    left, _, right, _ = box_of(mask)
    return left - FOOT, right - FOOT


def test_streaks_follow_a_foot_that_slid_in_the_hold_and_are_longer_the_faster_it_was():
    assert streaks(RESTING) is None
    assert streaks(RESTING, slid=True) == streaks(SLIDING) == (-85, -40)
    assert streaks(SLIDING, speed=1.0) == (-100, -40)
    assert streaks(SLIDING, speed=0.0) == (-70, -40)
    assert streaks(SLIDING, speed=9.0) == (-124, -40)
    left, right = streaks(BACKWARD, speed=-1.0, deformation=2.0)  # the body hides one of three
    assert (left, right) == (40, 100)
    assert streaks(RESTING, slid=True, speed=-1.0, deformation=2.0) == (40, 100)


@pytest.mark.parametrize(("valve", "is_open"), [(0, False), (1, True)])
def test_an_open_valve_is_full_of_air_and_so_is_the_hose(valve, is_open):
    image = drawn(RESTING, valve=valve)
    assert shown_in(image, AIR, 24, 22, 64, 64).any() == is_open
    assert shown_in(image, AIR, 24, 0, 64, 18).sum() > 30  # the supply always is
    assert (shown_in(image, AIR, 36, 68, 270, 190).sum() > 500) == is_open
    # A bar shuts it, wider than its waist.
    bar = shown_in(image, INK, 24, 41, 64, 45).any(axis=0).sum()
    assert (bar > 25) != is_open


@pytest.mark.parametrize("pressure", [0.0, 0.25, 0.5, 1.0])
def test_the_gauge_is_as_full_as_the_body(pressure):
    image = drawn(RESTING, pressure=pressure)
    gauge = image[36:49, 178:328]
    filled = shown_in(gauge, AIR).all(axis=0)
    assert filled.sum() == round(150 * pressure)
    assert filled[: round(150 * pressure)].all()
    assert (shown_in(gauge, MIST).all(axis=0) == ~filled).all()
    for mark, left in (("0", 178), ("0.5", 253), ("1", 328)):
        ((found, top),) = places_of(image[52:70, left - 20 : left + 20], mark, 15, GREY)
        assert (found + width_of(mark, 15) / 2, top) == (pytest.approx(20, abs=1), 3)
        assert shown_in(image, GREY, left - 1, 50, left + 1, 52).all(axis=0).sum() == 1


def body_of(image):
    """Top and bottom of the body beside the foot, and how much more red than blue is in its middle."""
    region = image[100:256, FOOT + 32 : FOOT + 140].astype(int)
    _, top, _, bottom = box_of(np.ptp(region, axis=2) > 4)
    red, _, blue = region[80].mean(axis=0)
    return top + 100, bottom + 100, red - blue


def test_the_body_swells_and_turns_blue_with_pressure_and_thins_as_it_stretches():
    bodies = [body_of(drawn(RESTING, pressure=pressure)) for pressure in (0.2, 0.6, 1.0)]
    heights = [bottom - top for top, bottom, _ in bodies]
    assert heights == sorted(heights)
    assert heights[2] / heights[0] == pytest.approx(1.42 / 1.084, abs=0.03)
    warmth = [each for *_, each in bodies]
    assert warmth == sorted(warmth, reverse=True)
    assert warmth[0] - warmth[2] > 50
    short, long = (body_of(drawn(RESTING, deformation=z)) for z in (-1.0, 3.0))
    assert short[1] - short[0] > long[1] - long[0] + 10
    for top, bottom, _ in (short, long):  # about the axis
        assert (top + bottom) / 2 == pytest.approx(GROUND - 72, abs=2)


@pytest.mark.parametrize("deformation", [-2.0, -1.0, 0.0, 0.7, 2.0, 4.0])
def test_the_payload_is_where_the_deformation_puts_it(deformation):
    image = drawn(RESTING, deformation=deformation)
    above = image[150:240, FOOT + 40 :]
    left, _, right, _ = box_of((above.max(axis=2) < 110) & (np.ptp(above.astype(int), axis=2) < 20))
    centre = FOOT + 40 + (left + right) / 2
    assert centre == pytest.approx(FOOT + SCALE * (4.0 + deformation), abs=2)


@pytest.mark.parametrize("foot", [0.0, 2.0, 2.5, -7.25, 1001.0])
def test_the_ruler_says_where_the_foot_is(foot):
    image = drawn(RESTING, foot=foot)
    for mark in (2 * np.floor(foot / 2) + [0, 2, 4]).astype(int).tolist():
        at = FOOT + SCALE * (mark - foot)
        ticks = np.flatnonzero(shown_in(image, GREY, 0, GROUND + 11, 960, GROUND + 15).all(axis=0))
        assert np.abs(ticks - at).min() <= 1, mark
        text = f"{mark} z".replace("-", "−")
        left = [left for left, _ in places_of(image[270:300], text, 18, GREY)]
        # The text is centred on its tick, the subscript included.
        assert min(abs(each + 17 - at) for each in left) < 16, mark
    cells = shown_in(image, MIST, 0, GROUND + 2, 960, GROUND + 9).all(axis=0)
    even = FOOT + SCALE * (2 * np.floor(foot / 2) + 2 - foot)
    assert cells[int(even) + 5 : int(even) + 55].all()
    assert not cells[int(even) + 65 : int(even) + 115].any()


def test_the_ruler_goes_by_as_the_camera_follows():
    renderer = Renderer("rgb_array", fps=30)
    renderer.draw(RESTING._replace(foot=0.0, deformation=0.0))
    image = renderer.draw(RESTING._replace(foot=1.0, deformation=0.0, time=1.5))
    left, _, right, _ = box_of(shown_in(image, BLUE, 0, 150, 960, 225))
    # One time constant after a step of 1 the camera is behind by 1/e.
    assert (left + right) / 2 == pytest.approx(FOOT + SCALE * np.exp(-1), abs=1)
    image = renderer.draw(RESTING._replace(foot=9.0, deformation=0.0, time=1.5))
    left, _, right, _ = box_of(shown_in(image, BLUE, 0, 150, 960, 225))
    assert (left + right) / 2 == pytest.approx(FOOT + SCALE * 1.5, abs=1)  # and never behind by more


def test_wheels_roll_as_the_payload_goes():
    def wheel(foot):
        return drawn(RESTING, foot=foot, deformation=0.0)[228:259, 505:537]

    turn = 2 * np.pi * 15 / SCALE / 6  # a sixth of a turn looks the same
    still = wheel(0.0).astype(int)
    assert np.abs(wheel(turn / 2) - still).mean() > 4 * np.abs(wheel(6 * turn) - still).mean()


# What the environments tell the picture.

ARGUMENTS = [{}, {"dither": 0.0, "memory_weight": 0.0}, {"hold": 1.7, "scene": {"ratchet": False}, "groups": "linear"}]


def frame_of(state, hold, message):
    """What should be drawn of a state."""
    speed, memory, _, _, valve, _ = state.told
    z, _, p, x, _, mode, _ = state.body
    earned = memory if message and state.steps else None
    return Frame(state.steps * hold, z, p, x, int(mode), speed != 0.0, int(valve), speed, earned)


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_environments_draw_the_state_that_they_are_in(arguments):
    env = gym.make("StickSlipCrawler-v0", render_mode="rgb_array", **arguments)
    envs = gym.make_vec("StickSlipCrawler-v0", 3, render_mode="rgb_array", rendered=[2, 0], **arguments)
    env.reset(seed=2), envs.reset(seed=0)
    renderer, modes = Renderer("rgb_array", fps=30), set()
    settings = env.unwrapped.settings
    for command in [None, *[1, 1, 1, 0, 0, 1, 1, 0]]:
        if command is not None:
            env.step(command), envs.step([command] * 3)
        state = env.unwrapped.get_state()
        modes.add(state.body[5])
        expected = renderer.draw(frame_of(state, settings.hold, settings.dither > 0))
        np.testing.assert_array_equal(env.render(), expected)
        np.testing.assert_array_equal(envs.render()[0], expected)
        np.testing.assert_array_equal(envs.call("render")[2], expected)
        assert envs.call("render")[1] is None
    assert len(modes) > 1


def test_windows_keep_the_pace_and_have_a_name(monkeypatch):
    import pygame

    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    paces = []

    class Clock:
        def tick(self, pace):
            paces.append(pace)

    monkeypatch.setattr(pygame.time, "Clock", Clock)
    for make in (gym.make, gym.make_vec):
        env = make("StickSlipCrawler-v0", render_mode="human")
        env.reset(seed=0)
        assert pygame.display.get_caption()[0] == "stickslip"
        env.close()
    assert paces == [30, 30]
