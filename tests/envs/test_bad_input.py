import re

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from stickslip.envs import StickSlipCrawlerEnv

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"groups": "jelly"}, ValueError, "groups must be one of the presets ['aggressive-forcing', *], got 'jelly'"),
        ({"groups": 3}, TypeError, "groups must be *, got 3"),
        ({"groups": {"stiffness": 1.0}}, ValueError, "groups has no 'stiffness'; allowed are ['duffing', *]"),
        ({"groups": {"duffing": NAN}}, ValueError, "duffing must be in [0, inf), got nan"),
        ({"groups": {"deborah": 0}}, ValueError, "deborah must be in (0, inf), got 0"),
        ({"groups": {"damping_ratio": -0.1}}, ValueError, "damping_ratio must be in [0, inf), got -0.1"),
        ({"groups": {"radial_coupling": INF}}, ValueError, "radial_coupling must be in [0, inf), got inf"),
        ({"groups": {"foot_mass_fraction": 1}}, ValueError, "foot_mass_fraction must be in (0, 1), got 1"),
        ({"groups": {"kinetic_friction": 0.4}}, ValueError, "kinetic_friction must be in [0, * = 0.3], got 0.4"),
        ({"groups": {"duffing": "1"}}, TypeError, "duffing must be a number in [0, inf), got '1'"),
        ({"scene": {"wind": 1}}, ValueError, "scene has no 'wind'; allowed are ['anchored', *]"),
        ({"scene": {"anchored": 1}}, TypeError, "scene anchored must be True or False, got 1"),
        ({"scene": {"segments": 3}}, ValueError, "scene * must have segments = 1 *, got segments = 3 *: use simulate"),
        ({"scene": {"tube_mass": 0.5}}, ValueError, "scene * must have * tube_mass = 0, got * = 0.5: use simulate"),
        ({"scene": "moon"}, TypeError, "scene must be *, got 'moon'"),
        ({"hold": 0}, ValueError, "hold must be in (0, 10000], got 0"),
        ({"hold": INF}, ValueError, "hold must be in (0, 10000], got inf"),
        (
            {"hold": "0.5"},
            TypeError,
            "hold must be a number in (0, 10000], or a text of one and its unit (s, ms, us, µs, t_c), got '0.5'",
        ),
        ({"tolerance": 0.0}, ValueError, "tolerance must be in [1e-15, 1e-2], got 0.0"),
        ({"tolerance": 0.1}, ValueError, "tolerance must be in [1e-15, 1e-2], got 0.1"),
        ({"dither": 0.51}, ValueError, "dither must be in [0, 0.5], got 0.51"),
        ({"dither": -0.1}, ValueError, "dither must be in [0, 0.5], got -0.1"),
        ({"dither": NAN}, ValueError, "dither must be in [0, 0.5], got nan"),
        ({"dither": 0}, ValueError, "dither must be in (0, 0.5] where memory_weight = 0.2 > 0, got 0*"),
        ({"memory_weight": 1.1}, ValueError, "memory_weight must be in [0, 1], got 1.1"),
        ({"memory_weight": -0.1}, ValueError, "memory_weight must be in [0, 1], got -0.1"),
        ({"delays": 0}, ValueError, "delays must be a whole number in [1, 1000], got 0"),
        ({"delays": 1.5}, TypeError, "delays must be a whole number in [1, 1000], got 1.5"),
        ({"delays": True}, TypeError, "delays must be a whole number in [1, 1000], got True"),
        ({"target": "echo"}, ValueError, "target must be one of ['memory', 'parity', 'narma'], got 'echo'"),
        ({"target": None}, ValueError, "target must be one of ['memory', 'parity', 'narma'], got None"),
        ({"target_order": 1}, ValueError, "target_order must be a whole number in [2, 5], got 1"),
        ({"target_order": 6}, ValueError, "target_order must be a whole number in [2, 5], got 6"),
        ({"virtual_nodes": 0}, ValueError, "virtual_nodes must be a whole number in [1, 1000], got 0"),
        ({"virtual_nodes": 4.0}, TypeError, "virtual_nodes must be a whole number in [1, 1000], got 4.0"),
        ({"valve_history": 0}, ValueError, "valve_history must be a whole number in [1, 64], got 0"),
        ({"valve_history": 65}, ValueError, "valve_history must be a whole number in [1, 64], got 65"),
        ({"valve_history": 1.0}, TypeError, "valve_history must be a whole number in [1, 64], got 1.0"),
        ({"render_mode": "ansi"}, ValueError, "render_mode must be one of ['human', 'rgb_array'* or None, got 'ansi'"),
        ({"slow_motion": 0.0}, ValueError, "slow_motion must be in [0.01, 1000], got 0.0"),
        ({"randomize": {"colour": [0, 1]}}, ValueError, "randomize has no 'colour'; allowed are ['duffing', *]"),
        ({"randomize": {"duffing": [2, 1]}}, ValueError, "randomize duffing must be * low <= high, got [2, 1]"),
        ({"randomize": {"duffing": 1.0}}, ValueError, "randomize duffing must be a pair *, got 1.0"),
        ({"randomize": {"duffing": [0, 1, 2]}}, ValueError, "randomize duffing must be a pair *, got [0, 1, 2]"),
        ({"randomize": {"duffing": [NAN, 1]}}, ValueError, "randomize duffing must be in [0, inf), got nan"),
        ({"randomize": {"duffing": [-1, 1]}}, ValueError, "randomize duffing must be in [0, inf), got -1"),
        ({"randomize": {"duffing": [0, INF]}}, ValueError, "randomize duffing must be in [0, inf), got inf"),
        ({"randomize": {"foot_mass_fraction": [0.1, 1]}}, ValueError, "*foot_mass_fraction must be in (0, 1), got 1*"),
        (
            {"randomize": {"kinetic_friction": [0, 0.5]}},
            ValueError,
            "*kinetic_friction must be in [0, * = 0.3], got 0.5",
        ),
        ({"randomize": {"static_friction": [0.1, 0.5]}}, ValueError, "*kinetic_friction must be in * 0.1], got 0.2"),
    ],
    ids=str,
)
def test_arguments_that_are_refused(arguments, error, message):
    pattern = ".*".join(re.escape(part) for part in message.split("*"))
    with pytest.raises(error) as caught:
        StickSlipCrawlerEnv(**arguments)
    assert re.fullmatch(pattern, str(caught.value))


@pytest.mark.parametrize(
    "randomize", [["duffing"], 3, {"duffing": [None, 1]}, {"duffing": ["0", "1"]}, {"duffing": [False, True]}], ids=str
)
def test_ranges_of_the_wrong_type_are_refused(randomize):
    with pytest.raises((TypeError, ValueError), match=r"randomize .* got "):
        StickSlipCrawlerEnv(randomize=randomize)


def test_ranges_may_be_tuples_as_well_as_lists():
    env = StickSlipCrawlerEnv(randomize={"duffing": (0.5, 1)})
    assert 0.5 <= env.reset(seed=0)[1]["groups"]["duffing"] <= 1


def test_more_delays_than_the_calibration_is_long_either_work_or_are_refused_by_name():
    try:
        env = StickSlipCrawlerEnv(delays=5000)
    except ValueError as error:
        assert re.match(r"delays must .* got 5000", str(error))  # noqa: PT017
    else:
        env.reset(seed=0)
        env.step(1)


@pytest.mark.parametrize(
    "action",
    [
        2,
        -1,
        0.5,
        1.0,
        None,
        "1",
        [0],
        np.array([0, 1]),
        np.array([1]),
        np.float32(1),
        np.array(1.0),
        10**30,
        np.array([True]),
        np.str_(1),
    ],
    ids=repr,
)
def test_an_action_that_is_refused_steps_nothing(action):
    env, twin = StickSlipCrawlerEnv(), StickSlipCrawlerEnv()
    for each in (env, twin):
        each.reset(seed=0)
        for _ in range(5):
            each.step(1)
    with pytest.raises(ValueError, match=re.escape(f"action must be 0 or 1, got {action!r}")):
        env.step(action)
    for command in (1, 0, 0, 1):
        observation, *rest = env.step(command)
        expected, *others = twin.step(command)
        np.testing.assert_array_equal(observation, expected)
        assert rest == others


@pytest.mark.parametrize("kind", [int, np.int8, np.int64, np.uint8, np.array, bool, np.bool_], ids=repr)
def test_every_kind_of_integer_is_an_action(kind):
    env, twin = StickSlipCrawlerEnv(), StickSlipCrawlerEnv()
    env.reset(seed=0), twin.reset(seed=0)
    for command in (1, 0, 1, 1, 0):
        observation, reward, _, _, info = env.step(kind(command))
        expected, *others = twin.step(command)
        np.testing.assert_array_equal(observation, expected)
        assert [reward, False, False, info] == others
        assert type(info["valve"]) is int
        assert isinstance(reward, float)


@pytest.mark.parametrize("make", [StickSlipCrawlerEnv, lambda: gym.make("StickSlipCrawler-v0")], ids=["plain", "made"])
def test_a_step_needs_a_reset(make):
    with pytest.raises(ResetNeeded, match=r"reset"):
        make().step(1)
