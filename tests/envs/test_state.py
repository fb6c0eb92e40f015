"""A crawler saved in the middle of its episode goes on as if nothing had happened, alone or in a batch."""

import dataclasses
import pickle
import re

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from stickslip.envs import CrawlerState, StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv

NAME = "StickSlipCrawler-v0"
ARGUMENTS = [
    {},
    {"dither": 0.0, "memory_weight": 0.0},
    {"randomize": {"duffing": [0.0, 2.0], "slope": [-0.1, 0.1]}, "delays": 3, "dither": 0.5},
    {"groups": "linear", "hold": 1.0, "virtual_nodes": 2},
    {"groups": {"damping_ratio": 200.0}, "scene": {"ratchet": False}, "valve_history": 64},
    {"target": "parity", "target_order": 4, "delays": 2},
    {"target": "narma", "target_order": 5},
]


def single(**arguments):
    return StickSlipCrawlerEnv(**arguments)


def commands(steps, seed=0):
    return np.random.default_rng(seed).integers(0, 2, steps).tolist()


def life(env, actions):
    return [(observation.tolist(), *rest) for observation, *rest in (env.step(action) for action in actions)]


def life_of_one(envs, i, actions):
    answers = []
    for action in actions:
        observations, rewards, _, _, infos = envs.step(np.full(envs.num_envs, action))
        info = {name: infos[name][i].item() for name in ("speed", "memory", "distance", "innovation", "valve", "slips")}
        groups = {name: values[i] for name, values in infos["groups"].items() if name[0] != "_"}
        answers.append((observations[i].tolist(), rewards[i], False, False, {**info, "groups": groups}))
    return [(*rest, {**info, "slope": infos["slope"][i]}) for *rest, info in answers]


@pytest.mark.parametrize("steps", [0, 1, 30])
@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_an_episode_goes_on_to_the_bit_alone_and_in_a_batch(arguments, steps):
    env, other = single(**arguments), single(**arguments)
    env.reset(seed=3)
    life(env, commands(steps))
    state = pickle.loads(pickle.dumps(env.get_state()))
    expected = life(env, commands(50, 1))
    other.set_state(state)
    assert life(other, commands(50, 1)) == expected
    env.set_state(state)  # and back
    assert life(env, commands(50, 1)) == expected

    batch = StickSlipCrawlerVectorEnv(11, **arguments)
    batch.set_state(state)
    assert life_of_one(batch, 9, commands(50, 1)) == expected
    batch.reset(seed=0)
    batch.set_state([None] * 4 + [state] + [None] * 6)
    saved = batch.get_state()
    assert life_of_one(batch, 4, commands(50, 1)) == expected
    env.set_state(saved[4])
    assert life(env, commands(50, 1)) == expected
    batch.set_state(saved)
    assert life_of_one(batch, 4, commands(50, 1)) == expected


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_a_batch_that_was_never_reset_goes_on_from_states_of_many(arguments):
    batch, other = (StickSlipCrawlerVectorEnv(9, **arguments) for _ in range(2))
    batch.reset(seed=3)
    life_of_one(batch, 0, commands(10))
    other.set_state(pickle.loads(pickle.dumps(batch.get_state())))
    for i in range(9):
        assert life_of_one(batch, i, commands(3, i)) == life_of_one(other, i, commands(3, i))


def test_those_that_are_not_set_go_on():
    batch, twin = (StickSlipCrawlerVectorEnv(10) for _ in range(2))
    for each in (batch, twin):
        each.reset(seed=0)
        for action in commands(20):
            each.step(np.full(10, action))
    state = batch.get_state()[0]
    batch.set_state([state if i in (2, 7) else None for i in range(10)])
    for action in commands(20, 1):
        answer, expected = (each.step(np.full(10, action)) for each in (batch, twin))
        others = [i for i in range(10) if i not in (2, 7)]
        np.testing.assert_array_equal(answer[1][others], expected[1][others])
        np.testing.assert_array_equal(answer[1][[2, 7]], expected[1][0])


def test_a_state_without_its_generator_leaves_the_flips_to_come():
    env, batch = single(), StickSlipCrawlerVectorEnv(3)
    env.reset(seed=3)
    life(env, commands(10))
    state = env.get_state(generator=False)
    assert state.generator is None
    batch.reset(seed=0)
    batch.set_state(state)
    generators = [np.random.default_rng(i) for i in range(3)]
    for _ in range(30):
        flips = [generator.random() < 0.1 for generator in generators]
        assert batch.step(np.zeros(3, int))[4]["valve"].tolist() == flips


def test_flips_come_after_a_state_that_no_reset_came_before():
    env = single(dither=0.5)
    env.reset(seed=3)
    state = env.get_state(generator=False)
    fresh = single(dither=0.5)
    fresh.set_state(state)
    valves = [fresh.step(0)[4]["valve"] for _ in range(100)]
    assert 20 < sum(valves) < 80  # 8 in 10^10 are not
    batch = StickSlipCrawlerVectorEnv(2, dither=0.5)
    batch.set_state(state)
    assert 40 < sum(batch.step([0, 0])[4]["valve"].sum() for _ in range(100)) < 160


def test_a_saved_state_is_nobody_elses():
    env = single()
    env.reset(seed=3)
    life(env, commands(10))
    state = env.get_state()
    before = pickle.dumps(state)
    life(env, commands(10))
    for _ in range(2):
        env.set_state(state)
        life(env, commands(10))
    assert pickle.dumps(state) == before


def test_a_state_is_small():
    env = gym.make(NAME)
    env.reset(seed=0)
    env.step(1)
    # 20 rows of 13 weights, half of a 13 x 13 covariance and 20 past innovations are 3 kB.
    assert len(pickle.dumps(env.unwrapped.get_state(generator=False))) < 5000
    assert len(pickle.dumps(env.unwrapped.get_state())) < 6000


def test_the_step_at_which_an_episode_ends_is_kept():
    for mode in ("NextStep", "SameStep", "Disabled"):
        batch = StickSlipCrawlerVectorEnv(2, max_episode_steps=5, autoreset_mode=mode)
        batch.reset(seed=0)
        states = []
        for _ in range(5):
            states.append(batch.get_state())
            *_, ends, _ = batch.step([1, 1])
        assert ends.all()
        batch.set_state(states[3])
        assert [batch.step([1, 1])[3].tolist() for _ in range(2)] == [[False] * 2, [True] * 2]
    batch = StickSlipCrawlerVectorEnv(2, max_episode_steps=5)
    batch.reset(seed=0)
    for _ in range(5):
        batch.step([1, 1])
    over = batch.get_state()
    assert not batch.step([1, 1])[0].any()  # the first observation of the next
    batch.set_state(over)
    assert not batch.step([1, 1])[0].any()


def test_after_a_state_of_another_crawler_a_sub_environment_is_its_own_again():
    batch = StickSlipCrawlerVectorEnv(9, max_episode_steps=3, groups="linear")
    batch.reset(seed=0, options={"groups": {"duffing": 2.0}})
    state = batch.get_state()[0]
    twin = StickSlipCrawlerVectorEnv(9, max_episode_steps=3, groups="linear")
    twin.reset(seed=0)
    twin.set_state([state] + [None] * 8)
    assert [twin.step(np.ones(9, int))[4]["groups"]["duffing"][0] for _ in range(5)] == [2.0, 2.0, 2.0, 0.0, 0.0]


def test_a_picture_is_that_of_the_state():
    env, other, third = (single(render_mode="rgb_array") for _ in range(3))
    env.reset(seed=0), other.reset(seed=1)
    life(env, [1, 1, 0, 0, 0])
    for each in (other, third):
        each.set_state(env.get_state())
    np.testing.assert_array_equal(other.render(), third.render())
    # Valve, gauge and numbers are the same; what has just happened a state does not tell.
    np.testing.assert_array_equal(env.render()[:70, 70:], other.render()[:70, 70:])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hold": 1.0}, "state must come from an environment of hold = 0.5, got one of 1.0"),
        ({"delays": 3}, "state must come from an environment of delays = 20, got one of 3"),
        ({"target": "narma"}, "state must come from an environment of target = 'memory', got one of 'narma'"),
        ({"valve_history": 3}, "state must come from an environment of valve_history = 1, got one of 3"),
        ({"groups": "linear"}, "state must come from an environment of groups = Groups("),
        ({"scene": {"ratchet": False}}, "state must come from an environment of scene = Scene("),
        ({"randomize": {"duffing": [0, 1]}}, "state must come from an environment of randomize = {}, got one of {'duf"),
    ],
    ids=str,
)
def test_states_of_other_environments_are_refused(change, message):
    env, batch, other = single(), StickSlipCrawlerVectorEnv(2), single(**change)
    env.reset(seed=0), batch.reset(seed=0), other.reset(seed=0)
    for each in (env, batch):
        with pytest.raises(ValueError, match=re.escape(message)):
            each.set_state(other.get_state())


def test_what_is_no_state_of_this_version_is_refused():
    env, batch = single(), StickSlipCrawlerVectorEnv(2)
    env.reset(seed=0)
    old = dataclasses.replace(env.get_state(), version=0)
    for each in (env, batch):
        with pytest.raises(ValueError, match="state must be of version 3, got one of version 0"):
            each.set_state(old)
        with pytest.raises(TypeError, match="state must be a CrawlerState"):
            each.set_state({"body": 1})
    with pytest.raises(TypeError, match=r"state must be a CrawlerState or num_envs = 2 of them, got "):
        batch.set_state([env.get_state()])
    with pytest.raises(ResetNeeded, match="set_state of some needs a call of reset"):
        batch.set_state([env.get_state(), None])
    for each in (single(), StickSlipCrawlerVectorEnv(2)):
        with pytest.raises(ResetNeeded, match="get_state needs a call of reset"):
            each.get_state()


def test_each_sub_environment_can_be_saved_and_set_by_call():
    batch = StickSlipCrawlerVectorEnv(2)
    batch.reset(seed=0)
    batch.step([1, 0])
    states = batch.call("get_state", generator=False)
    assert all(isinstance(state, CrawlerState) for state in states)
    batch.sub_environments[1].set_state(states[0])
    np.testing.assert_array_equal(batch.get_state()[1].body, states[0].body)
