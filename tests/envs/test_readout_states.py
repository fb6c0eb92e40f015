"""What the readout has seen of a hold is told, so that anyone can compute the offline capacity."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from stickslip import memory_capacity, Scene
from stickslip.envs import StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv
from stickslip.train.schedules import performance

NAME = "StickSlipCrawler-v0"


def test_the_capacity_of_the_states_told_is_the_offline_capacity_of_the_run():
    env = StickSlipCrawlerEnv(delays=6)
    env.reset(seed=1)
    command = np.resize([1, 1, 1, 0, 0], 1700)
    states, innovations, valves = [], [], []
    for each in command.tolist():
        *_, info = env.step(each)
        states.append(env.readout_states())
        innovations.append(info["innovation"])
        valves.append(info["valve"])
    expected = performance(command, np.array(valves), dither=0.1, groups=None, hold=0.5, scene=Scene(), delays=6)
    assert memory_capacity(np.array(states), innovations, 6).corrected == expected.memory.corrected


@pytest.mark.parametrize(
    "arguments",
    [{"virtual_nodes": 3}, {"groups": "linear", "virtual_nodes": 1}, {"randomize": {"damping_ratio": [0.05, 300.0]}}],
    ids=str,
)
def test_a_batch_tells_what_each_would_alone(arguments):
    envs, singles = StickSlipCrawlerVectorEnv(9, **arguments), [StickSlipCrawlerEnv(**arguments) for _ in range(9)]
    envs.reset(seed=0)
    for i, single in enumerate(singles):
        single.reset(seed=i)
    for command in (1, 1, 0, 1):
        envs.step(np.full(9, command))
        for single in singles:
            single.step(command)
        told = envs.readout_states()
        assert (told.dtype, told.shape) == (np.float64, (9, 3 * arguments.get("virtual_nodes", 4)))
        np.testing.assert_array_equal(told, [single.readout_states() for single in singles])
    np.testing.assert_array_equal(envs.call("readout_states"), told)


def test_the_last_node_is_the_end_of_the_hold():
    env = StickSlipCrawlerEnv()
    env.reset(seed=0)
    for command in (1, 0, 1):
        observation = env.step(command)[0]
        np.testing.assert_array_equal(np.float32(env.readout_states()[3::4]), observation[:3])


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_a_crawler_at_rest_has_been_at_rest(mode):
    env, envs = StickSlipCrawlerEnv(), StickSlipCrawlerVectorEnv(3, max_episode_steps=2, autoreset_mode=mode)
    for each in (env, envs):
        each.reset(seed=0)
        assert not each.readout_states().any()
    env.step(1)
    env.reset()
    assert not env.readout_states().any()
    envs.step([1, 1, 1])
    envs.reset(options={"reset_mask": np.array([True, False, True])})
    assert envs.readout_states().any(axis=1).tolist() == [False, True, False]
    envs.step([1, 1, 1])
    assert envs.readout_states()[1].any() == (mode != "SameStep")


def test_it_is_the_callers_and_a_part_of_a_state():
    env, envs = StickSlipCrawlerEnv(), StickSlipCrawlerVectorEnv(3)
    env.reset(seed=0), envs.reset(seed=5)
    env.step(1), envs.step([1, 1, 0])
    told = env.readout_states()
    kept = told.copy()
    told[:] = np.nan
    envs.readout_states()[:] = np.nan
    np.testing.assert_array_equal(env.readout_states(), kept)
    other = envs.readout_states()[2]
    envs.set_state([None, env.get_state(), None])
    np.testing.assert_array_equal(envs.readout_states()[1:], [kept, other])
    env.set_state(envs.get_state()[2])
    np.testing.assert_array_equal(env.readout_states(), other)


@pytest.mark.parametrize("make", [gym.make, lambda name, **arguments: gym.make_vec(name, 2, **arguments)])
def test_who_has_none_says_so(make):
    with pytest.raises(ResetNeeded, match="readout_states needs a call of reset first"):
        make(NAME).unwrapped.readout_states()
    quiet = make(NAME, dither=0.0, memory_weight=0.0).unwrapped
    quiet.reset(seed=0)
    with pytest.raises(ValueError, match=r"readout_states needs dither in \(0, 0.5\], got 0.0"):
        quiet.readout_states()
