"""Pictures within the holds are the solver's own, and drawing them changes nothing."""

import copy
import pickle

import gymnasium as gym
import numpy as np
import pytest

from stickslip.crawler import simulate
from stickslip.crawler.drawing.film import FPS
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.envs.rendering.film import pictures_of_hold

NAME = "StickSlipCrawler-v0"
ARGUMENTS = [
    {},
    {"dither": 0.0, "memory_weight": 0.0},
    {"hold": 1.7, "scene": {"ratchet": False, "slope": 0.05}, "groups": "linear"},
    {"scene": {"anchored": True}, "groups": {"damping_ratio": 80.0}},
    {"target": "parity"},
    {"target": "narma"},
]
COMMANDS = [1, 1, 1, 0, 0, 1, 0, 1, 1, 0, 0, 0]


def seen(arguments, commands=COMMANDS, **more):
    env = StickSlipCrawlerEnv(render_mode="rgb_array_list", **arguments, **more)
    env.reset(seed=2)
    valves, frames = [], env._drawing()[0].unseen()
    for command in commands:
        *_, info = env.step(command)
        valves.append(info["valve"])
        frames += env._film.unseen()
    return env, valves, frames


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_frames_are_the_motion_that_simulate_finds(arguments):
    env, valves, frames = seen(arguments)
    hold, count = env.settings.hold, pictures_of_hold(env.settings.hold, 1.0)
    run = simulate(env.settings.groups, valves, hold, scene=env.settings.scene, samples_per_hold=count)
    assert len(frames) == 1 + count * len(valves)
    assert [each.time for each in frames] == pytest.approx([0.0, *run.time])
    for name, truth in (("pressure", run.pressure), ("foot", run.foot), ("foot_velocity", run.foot_velocity)):
        np.testing.assert_allclose([getattr(each, name) for each in frames[1:]], truth, atol=2e-4)
    np.testing.assert_allclose([each.stretches[0] for each in frames[1:]], run.deformation, atol=2e-4)
    assert [each.valve for each in frames[1:]] == np.repeat(valves, count).tolist()


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_the_last_frame_of_a_hold_is_the_state_itself(arguments):
    env, *_ = seen(arguments)
    frame, (z, _, p, x, w, *_) = env._film.last()[-1], env.get_state().body
    assert (frame.stretches, frame.pressure, frame.foot) == ((z,), p, x)
    assert frame.foot_velocity == w
    assert frame.time == pytest.approx(len(COMMANDS) * env.settings.hold)


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_stepping_does_not_move_by_a_bit(arguments, mode):
    filmed, blind = StickSlipCrawlerEnv(render_mode=mode, **arguments), StickSlipCrawlerEnv(**arguments)
    for env in (filmed, blind):
        env.reset(seed=5)
    for command in COMMANDS:
        (one, *rest), (other, *others) = filmed.step(command), blind.step(command)
        np.testing.assert_array_equal(one, other)
        assert rest == others
        states = filmed.get_state(), blind.get_state()
        np.testing.assert_array_equal(*(each.body for each in states))
        for one_array, other_array in zip(*(each.readout for each in states), strict=True):
            np.testing.assert_array_equal(one_array, other_array)


def test_what_is_recalled_is_what_the_reward_was_paid_for():
    env, _, frames = seen({"memory_weight": 1.0})
    ends = frames[8::8]
    variance = 0.1 * 0.9
    # With the leverages known, the memory term is the sum over the delays; here only its sign of success is checked
    # against the readout's own record of its predictions.
    history = env._memory.arrays[2]
    message = ends[-1].message
    count = len(message.recalled)
    np.testing.assert_allclose(message.recalled, history[1, :count], rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(message.sent, history[0, : len(message.sent)])
    assert np.mean(message.sent**2) < 1.0
    assert variance > 0
    assert message.going == 0
    assert ends[-1].memory == env.get_state().told[1]


def test_within_a_hold_only_what_was_known_before_is_told():
    env, valves, frames = seen({})
    for k in range(2, len(COMMANDS)):
        within, before = frames[8 * k + 4], frames[8 * k]
        assert within.memory == before.memory
        np.testing.assert_array_equal(within.message.recalled, before.message.recalled)
        assert within.message.going == 1
        assert within.message.valves[0] == valves[k]
        flips = [valve != command for valve, command in zip(valves[: k + 1], COMMANDS, strict=False)]
        assert list(within.message.flips) == flips[::-1]
    assert env._film.last()[0].past.time[-1] == env._film.last()[0].time


@pytest.mark.parametrize(
    ("hold", "slow_motion", "count"),
    [(0.5, 1.0, 8), (0.5, 2.0, 15), (2.0, 1.0, 30), (0.01, 1.0, 1), (0.5, 0.1, 1), (1e4, 1.0, 240), (0.5, 1e3, 240)],
)
def test_a_second_shows_two_units_of_time_at_most(hold, slow_motion, count):
    assert pictures_of_hold(hold, slow_motion) == count
    plain = {"hold": hold, "slow_motion": slow_motion, "render_mode": "rgb_array"}
    assert StickSlipCrawlerEnv(**plain).metadata["render_fps"] == pytest.approx(FPS / count)
    assert StickSlipCrawlerEnv(**plain | {"render_mode": "rgb_array_list"}).metadata["render_fps"] == FPS
    if 1 < count < 240:
        assert FPS * hold * slow_motion / count <= 2.0 < FPS * hold * slow_motion / (count - 1)


@pytest.mark.parametrize("value", [0.0, -1.0, 2e3, float("nan"), "slow"])
@pytest.mark.parametrize("make", [gym.make, gym.make_vec])
def test_slow_motion_out_of_range_is_refused(make, value):
    with pytest.raises((ValueError, TypeError), match="slow_motion must be"):
        make(NAME, slow_motion=value)


def test_a_list_holds_all_since_the_last_call_and_an_array_the_newest():
    listed, one = (gym.make(NAME, render_mode=mode) for mode in ("rgb_array_list", "rgb_array"))
    for env in (listed, one):
        env.reset(seed=0)
    first = listed.render()
    assert len(first) == 1
    np.testing.assert_array_equal(first[0], one.render())
    assert listed.render() == []
    for command in (1, 0):
        listed.step(command), one.step(command)
    pictures = listed.render()
    assert len(pictures) == 16
    assert len({each.tobytes() for each in pictures}) == 16
    np.testing.assert_array_equal(pictures[-1], one.render())
    for several in (listed.unwrapped.frames(), one.unwrapped.frames()):
        np.testing.assert_array_equal(several, pictures[8:])


def test_a_reset_begins_a_new_film():
    env, *_ = seen({})
    env.reset(seed=2)
    (picture,) = env.render()
    fresh, *_ = seen({}, commands=[])
    np.testing.assert_array_equal(picture, fresh.frames()[0])


def test_a_film_goes_on_from_a_state_that_is_set():
    env, *_ = seen({})
    state = env.get_state()
    other, *_ = seen({}, commands=[1])
    other.set_state(state)
    (picture,) = other.render()
    assert picture.shape == env.frames()[-1].shape
    frame = other._film.last()[-1]
    assert (frame.time, frame.foot, frame.valve) == (6.0, state.body[3], int(state.told[4]))
    other.step(1), env.step(1)
    for one, same in zip(other._film.last(), env._film.last(), strict=True):
        assert one[:6] == same[:6]


@pytest.mark.parametrize("twin", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_an_environment_that_has_drawn_can_be_copied(twin):
    env, *_ = seen({})
    pictures, other = env.frames(), twin(env)
    np.testing.assert_array_equal(other.frames(), pictures)
    env.step(1), other.step(1)
    np.testing.assert_array_equal(other.frames(), env.frames())


def test_frames_need_a_render_mode_and_an_episode():
    with pytest.raises(ValueError, match="frames needs a render_mode"):
        StickSlipCrawlerEnv().frames()
    with pytest.raises(gym.error.ResetNeeded):
        StickSlipCrawlerEnv(render_mode="rgb_array").frames()
