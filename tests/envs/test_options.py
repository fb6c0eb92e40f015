"""The crawler of one episode, settled by the options of its reset."""

import re

import gymnasium as gym
import numpy as np
import pytest

from stickslip import Actuator, Groups
from stickslip.crawler import PRESETS
from stickslip.envs import StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv
from stickslip.envs.settings import Settings

NAME = "StickSlipCrawler-v0"
RANGES = {"duffing": [0.5, 1.0], "slope": [-0.1, 0.1]}


def told(env, options, seed=None):
    info = env.reset(seed=seed, options=options)[1]
    assert info["groups"] == env.step(1)[4]["groups"] == env.unwrapped.episode_groups.to_dict()
    assert info["slope"] == env.unwrapped.episode_scene.slope
    return info["groups"], info["slope"]


def test_settings_are_those_of_an_environment_that_is_told_nothing():
    assert Settings.of() == StickSlipCrawlerEnv().settings
    assert (
        Settings.of(memory_weight=0.0, dither=0.0, hold=2.0)
        == gym.make(NAME, memory_weight=0.0, dither=0.0, hold=2.0).unwrapped.settings
    )


def test_options_settle_one_episode():
    env = gym.make(NAME, groups="high-damping", scene={"slope": 0.05})
    own = PRESETS["high-damping"].to_dict()
    assert told(env, {"groups": {"duffing": 2}}) == ({**own, "duffing": 2.0}, 0.05)
    assert told(env, None) == (own, 0.05)
    assert told(env, {"groups": "linear", "slope": -0.1}) == (PRESETS["linear"].to_dict(), -0.1)
    assert told(env, {"groups": Groups(deborah=2.0)}) == (Groups(deborah=2.0).to_dict(), 0.05)
    assert told(env, {"groups": Actuator.ecoflex()}) == (Actuator.ecoflex().groups.to_dict(), 0.05)
    assert told(env, {"slope": np.float32(0.25)}) == (own, 0.25)
    assert told(env, {"groups": None, "slope": None}) == told(env, {}) == (own, 0.05)


def test_what_options_do_not_name_is_drawn_as_ever():
    env, twin = (gym.make(NAME, randomize=RANGES) for _ in range(2))
    for seed in (3, None, None):
        groups, slope = told(twin, None, seed)
        assert told(env, {"groups": {"deborah": 1.0}}, seed) == ({**groups, "deborah": 1.0}, slope)
    groups, slope = told(twin, None)
    assert told(env, {"groups": {"duffing": 3.0}, "slope": 0.0}) == ({**groups, "duffing": 3.0}, 0.0)
    assert told(twin, None) == told(env, None)


def test_the_crawler_that_was_settled_is_the_one_that_moves():
    env, other = gym.make(NAME, dither=0.0, memory_weight=0.0), None
    env.reset(options={"groups": "linear", "slope": 0.1})
    other = gym.make(NAME, dither=0.0, memory_weight=0.0, groups="linear", scene={"slope": 0.1})
    other.reset()
    for action in [1, 1, 0, 0, 0] * 10:
        np.testing.assert_array_equal(env.step(action)[0], other.step(action)[0])


@pytest.mark.parametrize(
    "options",
    [
        {"groups": "linear"},
        {"groups": {"damping_ratio": 300.0}},
        {"slope": 0.1},
        {"groups": [None, "linear", {"duffing": 1.0}, Groups(), "high-damping"], "slope": [0.1, None, 0.0, 0.05, None]},
        {"slope": np.linspace(0.0, 0.1, 5)},
    ],
    ids=str,
)
@pytest.mark.parametrize("arguments", [{}, {"groups": "linear"}, {"randomize": RANGES}], ids=str)
def test_a_batch_does_as_single_environments_that_are_told_the_same(arguments, options):
    batch = StickSlipCrawlerVectorEnv(5, max_episode_steps=10, **arguments)
    singles = [StickSlipCrawlerEnv(**arguments) for _ in range(5)]
    batch.reset(seed=0)
    for i, single in enumerate(singles):
        single.reset(seed=i)
    mask = np.array([True, False, False, True, True])
    for chosen in (mask, ~mask, mask):
        _, infos = batch.reset(options={"reset_mask": chosen, **options})
        for i in np.flatnonzero(chosen).tolist():
            own = {name: each[i] if isinstance(each, list | np.ndarray) else each for name, each in options.items()}
            info = singles[i].reset(options=own)[1]
            assert [infos["groups"][name][i] for name in info["groups"]] == list(info["groups"].values())
            assert infos["slope"][i] == info["slope"]
        for _ in range(3):
            observations, rewards, *_ = batch.step(np.ones(5, int))
            for i, single in enumerate(singles):
                observation, reward, *_ = single.step(1)
                np.testing.assert_array_equal(observations[i], observation)
                assert rewards[i] == reward
    for _ in range(11):  # the episodes that follow by autoreset are each one's own again
        *_, infos = batch.step(np.ones(5, int))
    own = Groups.of(arguments.get("groups"))
    for name in own.to_dict():
        low, high = arguments.get("randomize", {}).get(name, [getattr(own, name)] * 2)
        assert ((low <= infos["groups"][name]) & (infos["groups"][name] <= high)).all()
    assert (abs(infos["slope"]) <= (0.1 if "randomize" in arguments else 0.0)).all()


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"gravity": 1.0}, ValueError, "options has no 'gravity'; allowed are ['groups', 'slope']"),
        ({"reset_mask": None}, ValueError, "options has no 'reset_mask'; allowed are ['groups', 'slope']"),
        ([1], TypeError, "options must be a dict or None, got [1]"),
        ({"groups": "jelly"}, ValueError, "groups must be one of the presets"),
        ({"groups": {"stiffness": 1.0}}, ValueError, "groups has no 'stiffness'"),
        ({"groups": {"duffing": -1.0}}, ValueError, "duffing must be in [0, inf), got -1.0"),
        ({"groups": {"static_friction": 0.1}}, ValueError, "kinetic_friction must be in [0, static_friction = 0.1]"),
        ({"groups": 3}, TypeError, "groups must be"),
        ({"slope": float("nan")}, ValueError, "slope must be in (-inf, inf), got nan"),
        ({"slope": "steep"}, TypeError, "slope must be a number in (-inf, inf), got 'steep'"),
    ],
    ids=str,
)
def test_options_that_are_refused_reset_nothing(options, error, message):
    env, twin = StickSlipCrawlerEnv(), StickSlipCrawlerEnv()
    for each in (env, twin):
        each.reset(seed=0)
        each.step(1)
    with pytest.raises(error, match=re.escape(message)):
        env.reset(seed=5, options=options)
    np.testing.assert_array_equal(env.step(1)[0], twin.step(1)[0])
    if isinstance(options, dict) and "reset_mask" in options:
        return
    batch, others = StickSlipCrawlerVectorEnv(2), StickSlipCrawlerVectorEnv(2)
    for each in (batch, others):
        each.reset(seed=0)
    with pytest.raises(error, match=re.escape(message.replace("['groups'", "['reset_mask', 'groups'"))):
        batch.reset(seed=5, options=options)
    np.testing.assert_array_equal(batch.step([1, 0])[1], others.step([1, 0])[1])


def test_a_draw_that_would_not_fit_what_was_settled_is_refused_at_once():
    env = StickSlipCrawlerEnv(randomize={"kinetic_friction": [0.0, 0.25]})
    with pytest.raises(ValueError, match=re.escape("kinetic_friction must be in [0, static_friction = 0.1], got 0.25")):
        env.reset(options={"groups": {"static_friction": 0.1}})


@pytest.mark.parametrize("options", [{"groups": ["linear"]}, {"slope": [0.1] * 3}, {"slope": np.zeros(4)}], ids=str)
def test_as_many_options_as_sub_environments(options):
    with pytest.raises(ValueError, match=r"(groups|slope) must be one choice or num_envs = 2 of them, got \d"):
        StickSlipCrawlerVectorEnv(2).reset(options=options)
