"""The native adapter judged by SB3's own DummyVecEnv of single environments, under its wrappers and PPO."""

import copy
import json
import re
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import (
    DummyVecEnv,
    sync_envs_normalization,
    unwrap_vec_normalize,
    VecCheckNan,
    VecFrameStack,
    VecMonitor,
    VecNormalize,
    VecVideoRecorder,
)

from stickslip.train import StickSlipVecEnv

NAME = "StickSlipCrawler-v0"
SPEED_ONLY = {"dither": 0.0, "memory_weight": 0.0}
DRAWN = {"randomize": {"duffing": [0.0, 2.0], "slope": [-0.1, 0.1]}, "delays": 3}


def dummy(count, *, groups=None, **arguments):
    each = groups if isinstance(groups, list) else [groups] * count
    return DummyVecEnv([lambda choice=choice: gym.make(NAME, groups=choice, **arguments) for choice in each])


def assert_same(one, other, where=""):
    assert type(one) is type(other), where
    if isinstance(one, dict):
        assert list(one) == list(other), where
        for name in one:
            assert_same(one[name], other[name], f"{where}/{name}")
    elif isinstance(one, list | tuple):
        for i, pair in enumerate(zip(one, other, strict=True)):
            assert_same(*pair, f"{where}[{i}]")
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype, where
        np.testing.assert_array_equal(one, other, err_msg=where)
    else:
        assert one == other, where


def assert_same_life(native, singles, steps, seed=3):
    """Both are seeded in the middle too, and reset without a seed."""
    generator = np.random.default_rng(seed)
    for begin in (seed, None, seed + 1, None):
        if begin is not None:
            assert_same(native.seed(begin), singles.seed(begin), "seed")
        assert_same(native.reset(), singles.reset(), "reset")
        assert_same(native.reset_infos, singles.reset_infos, "reset infos")
        for k in range(steps):
            actions = generator.integers(0, 2, native.num_envs)
            assert_same(native.step(actions), singles.step(actions), f"step {k}")
            assert_same(native.reset_infos, singles.reset_infos, f"reset infos of step {k}")


@pytest.mark.parametrize(
    "arguments", [{"valve_history": 3}, SPEED_ONLY, DRAWN, {"groups": ["linear", None, "high-damping"]}], ids=str
)
def test_it_is_a_dummy_of_single_environments(arguments):
    common = {"max_episode_steps": 7, **arguments}
    assert_same_life(StickSlipVecEnv(3, **common), dummy(3, **common), 20)


def test_it_is_a_dummy_of_single_environments_beyond_a_block_of_flips():
    assert_same_life(StickSlipVecEnv(9), dummy(9), 300)


def test_episodes_that_end_apart():
    native, singles = StickSlipVecEnv(4, max_episode_steps=6), dummy(4, max_episode_steps=6)
    for each in (native, singles):
        each.seed(0)
        each.reset()
        each.step(np.ones(4, int))
        each.step(np.ones(4, int))
    answers = [each.env_method("reset", seed=11, indices=[1, 3]) for each in (native, singles)]
    assert_same(*answers)
    dones = []
    for k in range(15):
        answer = native.step(np.full(4, k % 2))
        assert_same(answer, singles.step(np.full(4, k % 2)), f"step {k}")
        dones.append(answer[2].tolist())
    assert [False, True, False, True] in dones
    assert [True, False, True, False] in dones


def test_the_last_observation_of_an_episode_is_told():
    native = StickSlipVecEnv(3, max_episode_steps=2, **SPEED_ONLY)
    native.seed(0)
    native.reset()
    before, _, dones, infos = native.step(np.ones(3, int))
    assert not dones.any()
    assert all(info["TimeLimit.truncated"] is False and "terminal_observation" not in info for info in infos)
    first, _, dones, infos = native.step(np.ones(3, int))
    assert dones.all()
    np.testing.assert_array_equal(first, 0.0)
    for i, info in enumerate(infos):
        assert info["TimeLimit.truncated"] is True
        assert info["terminal_observation"][2] > before[i, 2] > 0.0  # the pressure goes on to rise
    assert len({id(info["terminal_observation"]) for info in infos}) == 3


def test_sparse_infos_are_whole_at_the_end_of_an_episode_only():
    whole, sparse = (StickSlipVecEnv(5, max_episode_steps=4, sparse_infos=choice) for choice in (False, True))
    for each in (whole, sparse):
        each.seed(1)
        each.reset()
    for k in range(10):
        expected, answer = (each.step(np.full(5, k % 2)) for each in (whole, sparse))
        assert_same(answer[:3], expected[:3])
        if k % 4 == 3:
            assert_same(answer[3], expected[3])
        else:
            assert answer[3] == [{"TimeLimit.truncated": False}] * 5


def test_nothing_returned_is_overwritten():
    native = StickSlipVecEnv(4, max_episode_steps=3)
    native.seed(0)
    returned = [native.reset(), *(native.step(np.ones(4, int)) for _ in range(5))]
    kept = copy.deepcopy(returned)
    for _ in range(5):
        native.step(np.zeros(4, int))
    assert_same(returned, kept)


def test_what_is_done_to_what_was_returned_changes_nothing_that_follows():
    touched, left = (StickSlipVecEnv(3, max_episode_steps=4, **DRAWN) for _ in range(2))
    for each in (touched, left):
        each.seed(0)
    assert_same(touched.reset(), left.reset())
    for k in range(10):
        actions = np.full(3, k % 2)
        answer, expected = touched.step(actions), left.step(actions.copy())
        assert_same(answer, expected, f"step {k}")
        actions[:] = 7
        for array in answer[:3]:
            array[:] = 0
        for info in answer[3]:
            info["groups"]["duffing"] = -1.0
            if "terminal_observation" in info:
                info["terminal_observation"][:] = -1.0
            info.clear()
        assert_same(touched.reset_infos, left.reset_infos)
        for info in touched.reset_infos:
            info["groups"]["damping_ratio"] = -1.0
        assert touched.get_attr("episode_groups") == left.get_attr("episode_groups")
        touched.reset_infos[:] = copy.deepcopy(left.reset_infos)


def test_actions_are_those_that_were_given():
    early, late = StickSlipVecEnv(2), StickSlipVecEnv(2)
    for each in (early, late):
        each.seed(0)
        each.reset()
    early.step_async(np.array([1, 0]))
    assert_same(early.step_wait(), late.step(np.array([1, 0])))


def test_seeds_are_used_once_and_differ_where_none_is_given():
    native = StickSlipVecEnv(3, **DRAWN)
    assert native.seed(5) == [5, 6, 7]
    native.reset()
    assert native.get_attr("np_random_seed") == [5, 6, 7]
    first = copy.deepcopy(native.reset_infos)
    native.reset()
    assert native.reset_infos != first
    native.seed(5)
    native.reset()
    assert native.reset_infos == first
    native.seed()
    native.reset()
    drawn = [info["groups"]["duffing"] for info in native.reset_infos]
    assert len(set(drawn)) == 3


def test_options_are_taken_and_used_once():
    native, singles = StickSlipVecEnv(2), dummy(2)
    for options in ({"slope": 0.1}, [{}, {"groups": {"duffing": 2.0}}]):
        for each in (native, singles):
            each.seed(0)
            each.set_options(options)
        assert_same(native.reset(), singles.reset())
        assert native._options == singles._options == [{}, {}]
        assert native.reset_infos == singles.reset_infos
        assert_same(native.step(np.ones(2, int)), singles.step(np.ones(2, int)))
        assert native.get_attr("episode_groups") == singles.get_attr("episode_groups")
    native.set_options({"wind": 1.0})
    with pytest.raises(ValueError, match=re.escape("options has no 'wind'; allowed are")):
        native.reset()
    native.set_options()
    native.reset(), singles.reset()
    assert_same(native.step(np.ones(2, int)), singles.step(np.ones(2, int)))


@pytest.mark.parametrize("wrap", [None, VecNormalize, lambda env: VecFrameStack(env, 2), VecMonitor, VecCheckNan])
def test_attributes_and_methods_are_reached_as_in_a_dummy(wrap):
    native, singles = StickSlipVecEnv(3, **DRAWN), dummy(3, **DRAWN)
    if wrap is not None:
        native, singles = wrap(native), wrap(singles)
    for each in (native, singles):
        each.seed(2)
        each.reset()
        each.step(np.ones(3, int))
    for name in ("settings", "episode_groups", "episode_scene", "render_mode", "observation_space", "action_space"):
        assert native.get_attr(name) == singles.get_attr(name), name
    for name in ("np_random_seed", "metadata"):
        assert native.get_attr(name) == [getattr(env, name) for env in singles.get_attr("unwrapped")], name
    assert [spec.id for spec in native.get_attr("spec")] == [NAME] * 3
    assert native.get_attr("np_random", indices=1)[0].random() == singles.get_attr("np_random", indices=1)[0].random()

    assert not native.has_attr("mine")
    native.set_attr("mine", 12)
    native.set_attr("mine", 13, indices=[0, -1])
    assert native.get_attr("mine") == [13, 12, 13]
    assert native.get_attr("mine", indices=1) == [12]
    assert native.env_method("set_wrapper_attr", "mine", 14, indices=[1]) == [True]
    assert native.env_method("get_wrapper_attr", "mine", indices=range(1, 3)) == [14, 13]
    assert native.env_is_wrapped(Monitor) == [False] * 3
    assert native.env_is_wrapped(Monitor, indices=0) == [False]
    with pytest.raises(AttributeError, match="episode_groups"):
        native.set_attr("episode_groups", None)
    with pytest.raises(AttributeError, match="nothing"):
        native.get_attr("nothing")
    with pytest.raises(RuntimeError, match="sub-environment 1 cannot be stepped alone"):
        native.env_method("step", 1, indices=1)


def test_groups_of_its_own_are_told_for_each():
    groups = ["linear", {"duffing": 2.0}]
    native, singles = StickSlipVecEnv(2, groups=groups), dummy(2, groups=groups)
    assert native.get_attr("settings") == singles.get_attr("settings")


def test_the_monitor_counts_returns_and_lengths(tmp_path):
    env = VecMonitor(
        StickSlipVecEnv(2, max_episode_steps=5, sparse_infos=True), str(tmp_path / "log"), info_keywords=("distance",)
    )
    env.reset()
    total, episodes = np.zeros(2, np.float32), []
    for _ in range(11):
        _, rewards, dones, infos = env.step(np.ones(2, int))
        total += rewards
        if dones.any():
            for i, info in enumerate(infos):
                assert info["episode"]["r"] == total[i]
                assert info["episode"]["l"] == 5
                assert info["episode"]["distance"] == info["distance"]
                episodes.append(info["episode"])
            total[:] = 0.0
    env.close()
    header, columns, *rows = (tmp_path / "log.monitor.csv").read_text(encoding="utf-8").splitlines()
    assert json.loads(header[1:])["env_id"] == NAME
    assert columns == "r,l,t,distance"
    assert len(rows) == len(episodes) == 4


def test_normalisation_is_that_over_a_dummy_and_can_be_saved(tmp_path):
    native, singles = (
        VecNormalize(env, gamma=0.9) for env in (StickSlipVecEnv(4, max_episode_steps=5), dummy(4, max_episode_steps=5))
    )
    for each in (native, singles):
        each.seed(0)
    assert_same(native.reset(), singles.reset())
    generator = np.random.default_rng(0)
    for _ in range(20):
        actions = generator.integers(0, 2, 4)
        assert_same(native.step(actions), singles.step(actions))
        assert_same(native.get_original_obs(), singles.get_original_obs())
        assert_same(native.get_original_reward(), singles.get_original_reward())
    np.testing.assert_array_equal(native.obs_rms.mean, singles.obs_rms.mean)

    native.save(tmp_path / "normalisation.pkl")
    other = VecNormalize.load(tmp_path / "normalisation.pkl", StickSlipVecEnv(2))
    np.testing.assert_array_equal(other.obs_rms.var, native.obs_rms.var)
    fresh = VecNormalize(StickSlipVecEnv(4))
    sync_envs_normalization(native, fresh)
    np.testing.assert_array_equal(fresh.ret_rms.var, native.ret_rms.var)
    assert unwrap_vec_normalize(VecCheckNan(native)) is native


@pytest.mark.parametrize("wrap", [lambda env: VecFrameStack(env, 3), VecCheckNan, VecMonitor])
def test_other_wrappers_do_over_it_what_they_do_over_a_dummy(wrap):
    native, singles = (wrap(env) for env in (StickSlipVecEnv(3, max_episode_steps=4), dummy(3, max_episode_steps=4)))
    for each in (native, singles):
        each.seed(0)
    assert_same(native.reset(), singles.reset())
    for k in range(9):
        answer, expected = (each.step(np.full(3, k % 2)) for each in (native, singles))
        for info in answer[3] + expected[3]:
            info.get("episode", {}).pop("t", None)
        assert_same(answer, expected)


def test_a_checker_of_nan_sees_through_it():
    env = VecCheckNan(StickSlipVecEnv(2), raise_exception=True)
    env.reset()
    with pytest.raises(ValueError, match="nan"):
        env.step(np.array([np.nan, 1.0]))


def test_the_pictures_are_those_of_single_environments():
    native, singles = StickSlipVecEnv(3, render_mode="rgb_array"), dummy(3, render_mode="rgb_array")
    for each in (native, singles):
        each.seed(0)
        each.reset()
        each.step(np.ones(3, int))
    assert_same(list(native.get_images()), list(singles.get_images()))
    assert_same(native.render(), singles.render())
    assert_same(native.render("rgb_array"), singles.render())
    assert_same(native.env_method("render", indices=2), [native.get_images()[2]])
    with pytest.warns(UserWarning, match="render mode"):
        assert native.render("something else") is None


def test_only_the_rendered_are_drawn():
    native = StickSlipVecEnv(50, render_mode="rgb_array", rendered=[7, 3])
    native.reset()
    native.step(np.ones(50, int))
    seven, three = native.get_images()
    assert_same(native.env_method("render", indices=[3, 7]), [three, seven])
    assert native.env_method("render", indices=0) == [None]


def test_without_a_render_mode_nothing_is_drawn():
    native = StickSlipVecEnv(2)
    native.reset()
    with pytest.warns(UserWarning, match="render_mode"):
        assert native.get_images() == [None, None]
    with pytest.warns(UserWarning, match="no `render_mode`"):
        assert native.render() is None


def test_a_window_shows_all(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    native = StickSlipVecEnv(2, render_mode="human")
    native.reset()
    native.step(np.ones(2, int))
    assert native.render() is None
    with pytest.warns(UserWarning, match="render mode"):
        assert native.render("rgb_array") is None
    native.close()


def test_a_video_is_recorded(tmp_path):
    env = VecVideoRecorder(
        StickSlipVecEnv(2, render_mode="rgb_array"),
        str(tmp_path),
        record_video_trigger=lambda k: k == 0,
        video_length=3,
    )
    assert env.frames_per_sec == 30
    env.reset()
    for _ in range(5):
        env.step(np.ones(2, int))
    env.close()
    assert [path.stat().st_size > 0 for path in tmp_path.glob("*.mp4")] == [True]


@pytest.mark.parametrize("wrap", [VecMonitor, lambda env: VecMonitor(VecNormalize(env))])
def test_what_is_learned_is_what_is_learned_over_a_dummy(wrap):
    weights, rewards = [], []
    for make in (StickSlipVecEnv, dummy):
        env = wrap(make(6, max_episode_steps=20))
        model = PPO("MlpPolicy", env, n_steps=32, batch_size=48, n_epochs=2, seed=4, device="cpu")
        model.learn(600)
        weights.append(torch.cat([value.flatten() for value in model.policy.state_dict().values()]))
        rewards.append(evaluate_policy(model, env, n_eval_episodes=6, return_episode_rewards=True))
    assert torch.equal(*weights)
    assert rewards[0] == rewards[1]


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"num_envs": 0}, ValueError, "num_envs must be a whole number >= 1, got 0"),
        ({"autoreset_mode": "NextStep"}, ValueError, "autoreset_mode must not be set"),
        ({"copy": False}, ValueError, "copy must not be set"),
        ({"vectorization_mode": "sync"}, ValueError, "vectorization_mode must not be set"),
        ({"sparse_infos": 1}, TypeError, "sparse_infos must be True or False, got 1"),
        ({"hold": -1}, ValueError, r"hold must be in \(0, 10000\], got -1"),
        ({"wheels": 4}, TypeError, "wheels"),
    ],
    ids=str,
)
def test_arguments_that_are_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        StickSlipVecEnv(**arguments)


def test_actions_that_are_refused_step_nothing():
    native, twin = StickSlipVecEnv(3), StickSlipVecEnv(3)
    for each in (native, twin):
        each.seed(0)
        each.reset()
    for wrong in ([0, 1], [0, 1, 2], [0.0, 1.0, 0.0], 1):
        with pytest.raises((ValueError, TypeError), match="actions must"):
            native.step(wrong)
    with pytest.raises(RuntimeError, match="step_wait needs a call of step_async first"):
        native.step_wait()
    assert_same(native.step([1, 0, 1]), twin.step(np.array([1, 0, 1])))


def test_the_order_of_calls_matters():
    native = StickSlipVecEnv(2)
    with pytest.raises(ResetNeeded, match="reset"):
        native.step([0, 1])
    native.reset()
    native.close()
    native.close()
    with pytest.raises(ClosedEnvironmentError, match="closed"):
        native.step([0, 1])


def test_a_step_that_was_begun_is_dropped_by_a_reset():
    native = StickSlipVecEnv(2)
    native.reset()
    native.step_async([0, 1])
    native.reset()
    with pytest.raises(RuntimeError, match="step_async"):
        native.step_wait()


def test_importing_the_package_does_not_import_torch():
    code = "import sys, stickslip, stickslip.train, stickslip.train.schedules; print('torch' in sys.modules)"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, encoding="utf-8").stdout
        == "False\n"
    )


def test_groups_of_an_episode_that_has_not_begun_are_no_attribute():
    native = StickSlipVecEnv(2)
    for name in ("episode_groups", "episode_scene"):
        assert not native.has_attr(name)
        with pytest.raises(AttributeError, match="reset"):
            native.get_attr(name)
    native.reset()
    assert native.has_attr("episode_groups")
    assert native.has_attr("episode_scene")


@pytest.mark.parametrize(("arguments", "steps"), [({}, 1000), ({"max_episode_steps": 7}, 7)], ids=str)
def test_the_time_limit_is_told_by_the_spec(arguments, steps):
    native = StickSlipVecEnv(2, **arguments)
    assert native.spec.max_episode_steps == steps
    assert [spec.max_episode_steps for spec in native.get_attr("spec")] == [steps, steps]
