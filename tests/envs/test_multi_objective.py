"""The vector of objectives, single and batched, judged by the environment with one reward."""

import inspect
import json
import pickle
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from stickslip.envs import StickSlipCrawlerEnv, StickSlipCrawlerMOEnv, StickSlipCrawlerMOVectorEnv

ONE, MANY = "StickSlipCrawler-v0", "StickSlipCrawlerMO-v0"
ARGUMENTS = [
    {},
    {"randomize": {"duffing": [0.0, 2.0], "slope": [-0.1, 0.1]}, "delays": 3, "dither": 0.5, "valve_history": 3},
    {"groups": "linear", "scene": {"ratchet": False}, "virtual_nodes": 2},
]


def weighed(rewards, weight):
    return (1.0 - weight) * rewards[..., 0] + weight * rewards[..., 1]


def commands(steps, seed=0):
    return np.random.default_rng(seed).integers(0, 2, steps)


@pytest.mark.parametrize("weight", [0.0, 0.2, 1.0 / 3.0, 1.0])
@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_under_linear_weights_it_is_the_environment_with_one_reward_to_the_bit(arguments, weight):
    env, twin = gym.make(MANY, **arguments), gym.make(ONE, memory_weight=weight, **arguments)
    np.testing.assert_array_equal(env.reset(seed=3)[0], twin.reset(seed=3)[0])
    for command in commands(40):
        observation, rewards, *rest = env.step(command)
        expected, reward, *others = twin.step(command)
        np.testing.assert_array_equal(observation, expected)
        assert rest == others
        assert (type(rewards), rewards.dtype, rewards.shape) == (np.ndarray, np.float64, (2,))
        assert rewards in env.unwrapped.reward_space
        assert weighed(rewards, weight) == reward
        assert rewards.tolist() == [rest[2]["speed"], rest[2]["memory"]]


@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_so_is_the_batch_whatever_follows_the_end_of_an_episode(arguments, mode):
    common = {"autoreset_mode": mode, "max_episode_steps": 7, **arguments}
    envs, twin = gym.make_vec(MANY, 11, **common), gym.make_vec(ONE, 11, memory_weight=0.2, **common)
    envs.reset(seed=3), twin.reset(seed=3)
    partly = np.arange(11) % 3 == 0
    for k in range(30):
        if k == 4:
            for each in (envs, twin):
                each.reset(options={"reset_mask": partly})
        actions = commands(11, k)
        observations, rewards, _, ended, infos = envs.step(actions)
        expected, reward, _, others, told = twin.step(actions)
        assert (rewards.dtype, rewards.shape) == (np.float64, (11, 2))
        np.testing.assert_array_equal(weighed(rewards, 0.2), reward)
        np.testing.assert_array_equal(observations, expected)
        np.testing.assert_array_equal(ended, others)
        np.testing.assert_array_equal(infos["speed"], told["speed"])
        if mode is AutoresetMode.DISABLED and ended.any():
            for each in (envs, twin):
                each.reset(options={"reset_mask": ended})
    assert envs.reward_space.shape == envs.get_attr("reward_space")[0].shape == (2,)
    assert envs.get_attr("reward_dim") == (2,) * 11


@pytest.mark.parametrize("mode", AutoresetMode)
def test_sub_environment_i_is_the_single_environment_seeded_so(mode):
    envs = gym.make_vec(MANY, 3, autoreset_mode=mode, max_episode_steps=5)
    singles = [gym.make(MANY, max_episode_steps=5) for _ in range(3)]
    envs.reset(seed=8)
    for i, single in enumerate(singles):
        single.reset(seed=8 + i)
    for k in range(5):
        expected = [single.step(1)[1] for single in singles]
        np.testing.assert_array_equal(envs.step([1, 1, 1])[1], expected, err_msg=str(k))
    if mode is AutoresetMode.NEXT_STEP:
        assert not envs.step([1, 1, 1])[1].any()


def test_rewards_are_the_callers():
    envs = StickSlipCrawlerMOVectorEnv(2, copy=False)
    envs.reset(seed=0)
    before = envs.step([1, 1])[1]
    kept = before.copy()
    envs.step([0, 1])
    np.testing.assert_array_equal(before, kept)


@pytest.mark.parametrize(("scene", "least"), [({}, 0.0), ({"ratchet": False}, -np.inf), ({"anchored": True}, 0.0)])
def test_the_reward_space_has_the_bounds_of_the_physics(scene, least):
    for space in (
        StickSlipCrawlerMOEnv(scene=scene).reward_space,
        StickSlipCrawlerMOVectorEnv(2, scene=scene).reward_space,
    ):
        assert space.dtype == np.float64
        np.testing.assert_array_equal(space.low, [least, -np.inf])
        np.testing.assert_array_equal(space.high, [np.inf, np.inf])
    assert StickSlipCrawlerMOEnv().reward_dim == 2


def test_gymnasium_finds_no_fault_but_the_vector():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", EncodingWarning)
        check_env(StickSlipCrawlerMOEnv(), skip_render_check=True)
        messages = [str(each.message) for each in caught]
    assert [message for message in messages if "is -infinity" not in message and "is infinity" not in message] == [
        message for message in messages if "reward returned by `step()` must be" in message
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gym.make(MANY)
        env.reset(seed=0)
        env.step(1)


def test_it_is_saved_copied_and_described_as_the_other():
    env = gym.make(MANY, hold=np.float32(0.25), valve_history=2, max_episode_steps=30)
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert json.loads(env.spec.to_json())["kwargs"] == {"hold": 0.25, "valve_history": 2}
    env.reset(seed=4), again.reset(seed=4)
    for command in commands(10):
        env.step(command)
    state, copy = env.unwrapped.get_state(), pickle.loads(pickle.dumps(env))
    envs = gym.make_vec(MANY, 2, hold=0.25, valve_history=2)
    envs.set_state(state)
    again.unwrapped.set_state(state)
    for command in commands(10, 1):
        expected = env.step(command)[1].tolist()
        assert copy.step(command)[1].tolist() == again.unwrapped.step(command)[1].tolist() == expected
        assert envs.step([command] * 2)[1].tolist() == [expected] * 2


@pytest.mark.parametrize("make", [gym.make, lambda name, **arguments: gym.make_vec(name, 2, **arguments)])
def test_what_makes_no_vector_is_refused(make):
    with pytest.raises(TypeError, match=r"memory_weight is no argument of StickSlipCrawlerMO-v0"):
        make(MANY, memory_weight=0.5)
    with pytest.raises(ValueError, match=r"dither must be in \(0, 0.5\] where memory is an objective, got 0"):
        make(MANY, dither=0)
    with pytest.raises(ValueError, match=r"hold must be in \(0, 10000\], got 0"):
        make(MANY, hold=0)
    with pytest.raises(TypeError, match="wheels"):
        make(MANY, wheels=4)


def test_every_other_argument_is_taken():
    arguments = {
        name: parameter.default
        for name, parameter in inspect.signature(StickSlipCrawlerEnv).parameters.items()
        if name != "memory_weight"
    }
    assert StickSlipCrawlerMOEnv(**arguments).settings == StickSlipCrawlerEnv(memory_weight=0.0).settings
