"""What goes in is copied, and what comes out is the caller's: nobody's later writing changes an episode."""

import pickle

import numpy as np
import pytest

from stickslip.envs import StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv

COUNT = 9


def commands(steps, seed=0):
    return np.random.default_rng(seed).integers(0, 2, steps).tolist()


def pair(make):
    for each in (made := (make(), make())):
        each.reset(seed=3)
        for command in commands(25):
            act(each, command)
    return made


def act(env, command):
    return env.step(command if isinstance(env, StickSlipCrawlerEnv) else np.full(COUNT, command))


def assert_go_on_alike(env, twin, steps=15):
    for command in commands(steps, 1):
        answer, expected = act(env, command), act(twin, command)
        np.testing.assert_array_equal(answer[0], expected[0])
        np.testing.assert_array_equal(answer[1], expected[1])
        for name in ("distance", "slips", "valve"):
            np.testing.assert_array_equal(answer[4][name], expected[4][name])


def states_of(env):
    state = env.get_state()
    return state if isinstance(state, tuple) else (state,)


def arrays_of(state):
    return state.body, state.told, state.observation, state.read, *state.readout


MAKERS = [lambda: StickSlipCrawlerEnv(valve_history=3), lambda: StickSlipCrawlerVectorEnv(COUNT, valve_history=3)]


@pytest.mark.parametrize("make", MAKERS, ids=["single", "batch"])
def test_a_saved_state_is_neither_changed_by_the_episode_nor_changes_it(make):
    env, twin = pair(make)
    states = states_of(env)
    before = pickle.dumps(states)
    assert_go_on_alike(env, twin)
    assert pickle.dumps(states) == before
    env, twin = pair(make)
    for state in states_of(env):
        assert len(arrays_of(state)) == 7
        for array in arrays_of(state):
            array[...] = np.nan
        state.generator.random(3)
    assert_go_on_alike(env, twin)


@pytest.mark.parametrize("make", MAKERS, ids=["single", "batch"])
def test_a_state_that_was_set_may_be_written_to_afterwards(make):
    env, twin = pair(make)
    states = pickle.loads(pickle.dumps(states_of(env)))
    for command in commands(5, 2):
        act(env, command)
    env.set_state(states[0] if len(states) == 1 else states)
    for state in states:
        for array in arrays_of(state):
            array[...] = np.nan
        state.generator.random(3)
    assert_go_on_alike(env, twin)


def test_branches_of_one_state_share_nothing():
    env, batch = StickSlipCrawlerEnv(), StickSlipCrawlerVectorEnv(COUNT)
    env.reset(seed=3)
    for command in commands(25):
        env.step(command)
    state = env.get_state()
    batch.set_state(state)
    expected = [env.step(command)[1] for command in commands(20, 1)]
    for command, reward in zip(commands(20, 1), expected, strict=True):
        assert batch.step(np.full(COUNT, command))[1].tolist() == [reward] * COUNT
    assert len({id(generator) for generator in batch.np_random} | {id(state.generator)}) == COUNT + 1


@pytest.mark.parametrize(
    "make", [StickSlipCrawlerEnv, lambda **arguments: StickSlipCrawlerVectorEnv(COUNT, **arguments)]
)
def test_arguments_may_be_changed_once_it_is_made(make):
    def arguments():
        return {
            "groups": {"duffing": 1.0},
            "scene": {"slope": 0.05},
            "randomize": {"deborah": [0.4, 0.6], "slope": np.array([0.0, 0.1])},
        }

    given = arguments()
    env, twin = make(**given), make(**arguments())
    given["groups"]["duffing"], given["scene"]["slope"] = 0.0, -0.1
    given["randomize"]["deborah"][:] = [5.0, 6.0]
    given["randomize"]["slope"][:] = 0.3
    given["randomize"]["duffing"] = [0.0, 0.1]
    env.reset(seed=0), twin.reset(seed=0)
    assert_go_on_alike(env, twin)


def test_options_masks_and_actions_may_be_changed_once_they_are_given():
    env, twin = (StickSlipCrawlerVectorEnv(COUNT, max_episode_steps=4, copy=False) for _ in range(2))
    mask, slopes = np.arange(COUNT) % 2 == 0, np.linspace(0.0, 0.1, COUNT)
    groups, actions = {"duffing": 1.0}, np.ones(COUNT, np.int64)
    env.reset(seed=0), twin.reset(seed=0)
    env.reset(options={"reset_mask": mask, "slope": slopes, "groups": groups})
    twin.reset(options={"reset_mask": mask.copy(), "slope": slopes.copy(), "groups": {**groups}})
    mask[:], slopes[:], groups["duffing"] = True, 1.0, 0.0
    env.step(actions), twin.step(actions.copy())
    actions[:] = 7
    assert_go_on_alike(env, twin)


def test_what_a_batch_without_copies_shows_may_be_written_to():
    """A policy may scale it in place."""
    env, twin = (StickSlipCrawlerVectorEnv(COUNT, valve_history=4, copy=copy) for copy in (False, True))
    env.reset(seed=0)[0][:] = 5.0
    twin.reset(seed=0)
    for command in commands(12):
        answer, expected = act(env, command), act(twin, command)
        np.testing.assert_array_equal(answer[0], expected[0])
        answer[0][:] = 5.0


def test_what_one_sub_environment_answers_is_its_callers():
    env, twin = pair(MAKERS[1])
    for each in (env, twin):
        each.sub_environments[4].reset(seed=9)
    observation, info = env.sub_environments[2].reset(seed=5)
    twin.sub_environments[2].reset(seed=5)
    observation[:], info["slope"] = np.nan, np.nan
    info["groups"].clear()
    env.begun(2)["groups"].clear()
    env.settings_of_each.clear()
    env.sub_environments[3].get_state().body[:] = np.nan
    assert_go_on_alike(env, twin)
    assert env.begun(2) == twin.begun(2)


def test_metadata_of_a_batch_is_its_own():
    first, second = (StickSlipCrawlerVectorEnv(1, autoreset_mode=mode) for mode in ("SameStep", "Disabled"))
    first.metadata["render_fps"] = 1
    assert second.metadata["render_fps"] == StickSlipCrawlerEnv.metadata["render_fps"] == 30
    assert "autoreset_mode" not in StickSlipCrawlerEnv.metadata
