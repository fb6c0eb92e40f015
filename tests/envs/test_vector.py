"""The batch judged by Gymnasium's own: single environments seeded `seed + i`, one after the other."""

import copy
import pickle
import re
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import vector as wrappers
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.crawler import SolverError
from stickslip.envs import StickSlipCrawlerVectorEnv
from stickslip.envs.batch_engine import BatchEngine

NAME = "StickSlipCrawler-v0"
SPEED_ONLY = {"dither": 0.0, "memory_weight": 0.0}
ARGUMENTS = [
    {},
    SPEED_ONLY,
    {"randomize": {"duffing": [0.0, 2.0], "slope": [-0.1, 0.1], "kinetic_friction": [0.0, 0.3]}, "delays": 3},
    {"groups": "linear", "hold": 1.0, "virtual_nodes": 2, "valve_history": 5},
    {"groups": "linear", "scene": {"anchored": True}, **SPEED_ONLY},
    {"groups": "high-damping", "scene": {"ratchet": False}, "tolerance": 1e-9, "dither": 0.5, "memory_weight": 1.0},
    {"target": "parity", "target_order": 3, "dither": 0.3, "delays": 2},
    {"target": "narma", "target_order": 4, "dither": 0.2},
    {"randomize": {"damping_ratio": [0.05, 300.0]}, "virtual_nodes": 1},  # by more than one solver
    {"randomize": {"radial_coupling": [0.0, 0.0]}, "groups": {"duffing": 0.0}},  # in closed form, drawn
]


def make_vec(count, **arguments):
    return gym.make_vec(NAME, count, **arguments)


def one_by_one(count, *, autoreset_mode=AutoresetMode.NEXT_STEP, max_episode_steps=1000, groups=None, **arguments):
    each = groups if isinstance(groups, list) else [groups] * count

    def maker(choice):
        return lambda: gym.make(NAME, max_episode_steps=max_episode_steps, groups=choice, **arguments)

    return SyncVectorEnv([maker(choice) for choice in each], autoreset_mode=autoreset_mode)


def assert_same(one, other, where=""):
    assert type(one) is type(other), where
    if isinstance(one, dict):
        assert one.keys() == other.keys(), where
        for name in one:
            assert_same(one[name], other[name], f"{where}/{name}")
    elif isinstance(one, tuple):
        for i, pair in enumerate(zip(one, other, strict=True)):
            assert_same(*pair, f"{where}[{i}]")
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype, where
        if one.dtype == object:
            assert_same(tuple(one), tuple(other), where)
        else:
            np.testing.assert_array_equal(one, other, err_msg=where)
    else:
        assert one == other, where


def arrays_in(value):
    if isinstance(value, np.ndarray):
        yield from arrays_in(tuple(value)) if value.dtype == object else [value]
    elif isinstance(value, dict | tuple):
        for each in value.values() if isinstance(value, dict) else value:
            yield from arrays_in(each)


def assert_same_life(batch, singles, steps, seed=3, resets=()):
    count = batch.num_envs
    generator = np.random.default_rng(seed)
    assert_same(batch.reset(seed=seed), singles.reset(seed=seed), "reset")
    over = np.zeros(count, bool)
    for k in range(steps):
        mask = over if batch.metadata["autoreset_mode"] is AutoresetMode.DISABLED else np.zeros(count, bool)
        if k in resets:
            mask = mask | (generator.random(count) < 0.5)
        if mask.any():
            answers = [each.reset(options={"reset_mask": mask.copy()}) for each in (batch, singles)]
            assert_same(*answers, f"reset before step {k}")
        actions = generator.integers(0, 2, count)
        answer = batch.step(actions)
        assert_same(answer, singles.step(actions), f"step {k}")
        over = answer[2] | answer[3]


@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_it_is_single_environments_side_by_side(arguments, mode):
    common = {"autoreset_mode": mode, "max_episode_steps": 7, **arguments}
    assert_same_life(make_vec(11, **common), one_by_one(11, **common), 40, resets=(5, 13, 14, 20))


def test_it_is_single_environments_side_by_side_beyond_a_block_of_flips():
    assert_same_life(make_vec(9), one_by_one(9), 600, resets=(100, 300))


def test_each_may_have_groups_of_its_own():
    groups = ["linear", "high-damping", {"duffing": 2.0}, None, {"damping_ratio": 200.0}] * 2
    common = {"groups": groups, "max_episode_steps": 20}
    assert_same_life(make_vec(10, **common), one_by_one(10, **common), 50)


@given(
    count=st.integers(1, 40),
    threads=st.integers(1, 4),
    least=st.sampled_from([1, 8, 128]),
    call=st.sampled_from([4.0, 20_000.0]),
    seed=st.integers(0, 2**31),
    steps=st.integers(1, 12),
)
@settings(max_examples=25, deadline=None)
def test_neither_the_batch_nor_the_threads_nor_the_calls_matter(count, threads, least, call, seed, steps):
    whole, part = make_vec(40, threads=1, max_episode_steps=5), None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stickslip.envs.batch_engine._LEAST_A_THREAD", least)
        patch.setattr("stickslip.envs.batch_engine._TIME_OF_A_CALL", call)
        part = make_vec(count, threads=threads, max_episode_steps=5)
    generator = np.random.default_rng(seed)
    expected, answer = whole.reset(seed=seed), part.reset(seed=seed)
    np.testing.assert_array_equal(answer[0], expected[0][:count])
    for _ in range(steps):
        actions = generator.integers(0, 2, 40)
        expected, answer = whole.step(actions), part.step(actions[:count])
        for one, other in zip(arrays_in(answer[:4]), arrays_in(expected[:4]), strict=True):
            np.testing.assert_array_equal(one, other[:count])
    whole.close(), part.close()


@pytest.mark.parametrize("mode", AutoresetMode)
def test_reset_tells_what_every_step_does(mode):
    def kinds_of(info):
        return {
            name: kinds_of(value) if isinstance(value, dict) else (value.dtype, value.shape)
            for name, value in info.items()
            if not name.startswith(("final_", "_final_"))
        }

    batch = make_vec(3, autoreset_mode=mode, max_episode_steps=4, randomize={"duffing": [0, 1]})
    _, begun = batch.reset(seed=0)
    for _ in range(4):
        *_, info = batch.step(np.ones(3, int))
        assert kinds_of(info) == kinds_of(begun)
        assert all(info[f"_{name}"].all() for name in ("speed", "slips", "groups", "slope"))
    _, some = batch.reset(options={"reset_mask": np.array([True, False, True])})
    assert kinds_of(some) == kinds_of(begun)
    assert some["_groups"].tolist() == some["groups"]["_duffing"].tolist() == [True, False, True]


@pytest.mark.parametrize("mode", [*AutoresetMode, "Disabled"])
def test_the_mode_of_resets_is_an_attribute(mode):
    batch = make_vec(2, autoreset_mode=mode)
    assert batch.autoreset_mode is batch.metadata["autoreset_mode"] is AutoresetMode(mode)


def test_attributes_and_methods_are_reached_as_in_a_sync_vector_env():
    groups = ["linear", {"duffing": 2.0}, None]
    batch, singles = (make(3, groups=groups, scene={"slope": 0.1}) for make in (make_vec, one_by_one))
    for each in (batch, singles):
        each.reset(seed=4)
        each.step([1, 0, 1])
    for name in ("settings", "episode_groups", "episode_scene", "render_mode", "observation_space", "action_space"):
        assert batch.get_attr(name) == singles.get_attr(name), name
    for name in ("np_random_seed", "metadata", "get_keys_to_action"):
        expected = singles.get_attr(name)
        assert batch.get_attr(name) == batch.call(name) == expected, name
    for mine, other in zip(batch.get_attr("np_random"), singles.get_attr("np_random"), strict=True):
        assert mine.bit_generator.state == other.bit_generator.state
    for each in (batch, singles):
        each.set_attr("mine", 12)
        assert each.get_attr("mine") == (12, 12, 12)
        each.set_attr("mine", [1, 2, 3])
        assert each.get_attr("mine") == (1, 2, 3)
        each.set_attr("np_random", [np.random.default_rng(i) for i in range(3)])
        assert each.get_attr("np_random_seed") == (-1, -1, -1)
        with pytest.raises(ValueError, match=r"[Vv]alues must be .* 3"):
            each.set_attr("mine", [1, 2])
        with pytest.raises(AttributeError, match="nothing"):
            each.get_attr("nothing")
    assert_same(batch.step([1, 1, 0]), singles.step([1, 1, 0]))
    answers = [each.call("reset", seed=7, options={"slope": 0.2}) for each in (batch, singles)]
    assert_same(*answers)
    assert_same(batch.step([1, 1, 0]), singles.step([1, 1, 0]))


def test_attributes_of_an_episode_that_has_not_begun_are_none():
    with pytest.raises(AttributeError, match="no episode has begun"):
        make_vec(2).get_attr("episode_groups")
    with pytest.raises(RuntimeError, match="cannot be stepped alone"):
        make_vec(2).call("step", 1)


def test_seeds_can_be_given_one_by_one():
    batch, singles = make_vec(3, randomize={"duffing": [0, 1]}), one_by_one(3, randomize={"duffing": [0, 1]})
    assert_same(batch.reset(seed=[5, 3, 9]), singles.reset(seed=[5, 3, 9]))
    assert_same(batch.reset(seed=[5, 3, 9]), singles.reset(seed=[5, 3, 9]))
    assert batch.np_random_seed == (5, 3, 9)


def test_without_a_seed_every_batch_is_another():
    first, second = (make_vec(2, randomize={"duffing": [0, 1]}).reset()[1]["groups"]["duffing"] for _ in range(2))
    assert len({*first, *second}) == 4


def test_nothing_returned_shares_memory():
    batch = make_vec(5, autoreset_mode="SameStep", max_episode_steps=2)
    returned = [batch.reset(seed=0), *(batch.step(np.ones(5, int)) for _ in range(4))]
    everything = [array for answer in returned for array in arrays_in(answer)]
    for i, one in enumerate(everything):
        assert not any(np.shares_memory(one, other) for other in everything[:i])


def test_without_copies_the_next_step_overwrites_what_was_returned():
    batch, twin = make_vec(5, copy=False), make_vec(5)
    observations, _ = batch.reset(seed=0)
    twin.reset(seed=0)
    for _ in range(3):
        answer = batch.step(np.ones(5, int))
        assert_same(answer, twin.step(np.ones(5, int)))
        assert answer[0] is observations


def test_without_copies_what_the_last_step_of_all_has_told_outlives_the_reset_in_the_same_step():
    arguments = {"max_episode_steps": 2, "autoreset_mode": "SameStep", "randomize": {"duffing": [0, 1]}}
    batch, twin = make_vec(5, copy=False, **arguments), make_vec(5, **arguments)
    assert_same(batch.reset(seed=0), twin.reset(seed=0))
    for _ in range(4):
        assert_same(batch.step(np.ones(5, int)), twin.step(np.ones(5, int)))


def test_what_the_caller_does_to_the_arrays_does_not_matter():
    batch, twin = make_vec(5, max_episode_steps=3), make_vec(5, max_episode_steps=3)
    for each in (batch, twin):
        each.reset(seed=0)
    for k in range(8):
        actions, mask = np.full(5, k % 2), np.array([True, False, False, True, False])
        answer = batch.step(actions)
        assert_same(answer, twin.step(actions.copy()))
        for array in arrays_in(answer):
            array[...] = np.zeros((), array.dtype)
        if k == 5:
            assert_same(*(each.reset(options={"reset_mask": mask.copy()}) for each in (batch, twin)))


def test_without_copies_a_caller_who_adds_up_the_ends_in_place_ends_nothing():
    batch = make_vec(2, copy=False)
    batch.reset(seed=0)
    for _ in range(2):
        terminations = batch.step([1, 1])[2]
        assert not terminations.any()
        terminations |= True


@pytest.mark.parametrize("when", ["called", "awaited"])
def test_nobody_steps_any_more_after_an_interrupt(monkeypatch, when):
    batch = make_vec(300, threads=2)
    batch.reset(seed=0)
    here, called = threading.get_ident(), []

    def submit(pool, *work):
        called.append(submit_one(pool, *work))
        if when == "called":
            raise KeyboardInterrupt
        return called[-1]

    def interrupted(future):
        raise KeyboardInterrupt

    submit_one = ThreadPoolExecutor.submit
    with monkeypatch.context() as patch:
        patch.setattr(ThreadPoolExecutor, "submit", submit)
        patch.setattr(Future, "result", interrupted)
        patch.setattr(BatchEngine, "_step_slice", lambda *_: threading.get_ident() == here or time.sleep(0.2))
        with pytest.raises(KeyboardInterrupt):
            batch.step(np.ones(300, int))
        assert [each.done() for each in called] == [True]
    twin = make_vec(300, threads=1)
    assert_same(batch.reset(seed=0), twin.reset(seed=0))
    assert_same(batch.step(np.ones(300, int)), twin.step(np.ones(300, int)))


@pytest.mark.parametrize("twin_of", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_go_on_alike(twin_of):
    batch = make_vec(300, threads=2)
    batch.reset(seed=0)
    actions = np.random.default_rng(0).integers(0, 2, (20, 300))
    for k in range(10):
        batch.step(actions[k])
    twin = twin_of(batch)
    for k in range(10, 20):
        assert_same(batch.step(actions[k]), twin.step(actions[k]))


def test_an_episode_without_end():
    for never in (None, -1, 2**70):
        batch = make_vec(2, max_episode_steps=never)
        batch.reset(seed=0)
        assert not any(batch.step(np.ones(2, int))[3].any() for _ in range(1500))


@pytest.mark.parametrize(
    "wrap",
    [
        wrappers.RecordEpisodeStatistics,
        wrappers.NormalizeObservation,
        wrappers.NormalizeReward,
        wrappers.ClipReward,
        wrappers.DictInfoToList,
        wrappers.FlattenObservation,
    ],
)
@pytest.mark.filterwarnings("ignore:.*NormalizeReward.*")
def test_the_wrappers_of_gymnasium_work_over_it(wrap):
    arguments = {"autoreset_mode": "NextStep", "max_episode_steps": 5}
    options = {"min_reward": -1.0, "max_reward": 0.1} if wrap is wrappers.ClipReward else {}
    batch, singles = (wrap(make(4, **arguments), **options) for make in (make_vec, one_by_one))
    actions = np.ones(4, int)
    for each in (batch, singles):
        each.reset(seed=0)
    for _ in range(12):
        answer, expected = batch.step(actions), singles.step(actions)
        for i in range(4):
            np.testing.assert_array_equal(np.asarray(answer[i]), np.asarray(expected[i]))


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"num_envs": 0}, ValueError, "num_envs must be a whole number >= 1, got 0"),
        ({"num_envs": 2.0}, TypeError, "num_envs must be a whole number >= 1, got 2.0"),
        ({"num_envs": 3, "groups": ["linear"] * 2}, ValueError, "groups must be one * or num_envs = 3 *, got 2"),
        ({"groups": ["jelly"]}, ValueError, "groups must be one of the presets *, got 'jelly'"),
        ({"hold": -1}, ValueError, "hold must be in (0, 10000], got -1"),
        ({"max_episode_steps": 0}, ValueError, "max_episode_steps must be a whole number >= 1, got 0"),
        ({"autoreset_mode": "never"}, ValueError, "autoreset_mode must be one of *'NextStep'*, got 'never'"),
        ({"copy": 1}, TypeError, "copy must be True or False, got 1"),
        ({"threads": 0}, ValueError, "threads must be a whole number >= 1, got 0"),
        ({"rendered": 0}, TypeError, "rendered must be a sequence of sub-environments, got 0"),
        ({"rendered": []}, ValueError, "rendered must name one sub-environment at least, got []"),
    ],
    ids=str,
)
def test_arguments_that_are_refused(arguments, error, message):
    pattern = ".*".join(re.escape(part) for part in message.split("*"))
    with pytest.raises(error) as caught:
        StickSlipCrawlerVectorEnv(**arguments)
    assert re.fullmatch(pattern, str(caught.value))


@pytest.mark.parametrize(
    ("actions", "error", "message"),
    [
        (np.ones(2, int), ValueError, "actions must have shape (3,), got (2,)"),
        (np.ones((3, 1), int), ValueError, "actions must have shape (3,), got (3, 1)"),
        (1, ValueError, "actions must have shape (3,), got ()"),
        ([[0], [0, 1], 1], ValueError, "actions must have shape (3,), got [[0], [0, 1], 1]"),
        (np.ones(3), TypeError, "actions must be whole numbers, got an array of float64"),
        (["1", "0", "1"], TypeError, "actions must be whole numbers, got an array of <U1"),
        ([0, 1, 2], ValueError, "actions must be 0 or 1, got 2 for sub-environment 2"),
        ([0, -1, 1], ValueError, "actions must be 0 or 1, got -1 for sub-environment 1"),
    ],
    ids=str,
)
def test_actions_that_are_refused_step_nothing(actions, error, message):
    batch, twin = make_vec(3), make_vec(3)
    for each in (batch, twin):
        each.reset(seed=0)
        each.step([0, 1, 1])
    with pytest.raises(error, match=re.escape(message)):
        batch.step(actions)
    assert_same(batch.step([1, 1, 0]), twin.step([1, 1, 0]))


@pytest.mark.parametrize("kind", [bool, np.int8, np.uint64, list], ids=str)
def test_every_kind_of_whole_number_is_an_action(kind):
    batch, twin = make_vec(3), make_vec(3)
    for each in (batch, twin):
        each.reset(seed=0)
    actions = [1, 0, 1] if kind is list else np.array([1, 0, 1], kind)
    assert_same(batch.step(actions), twin.step(np.array([1, 0, 1])))


@pytest.mark.parametrize(
    ("mask", "error", "message"),
    [
        ([True, False, False], TypeError, "reset_mask must be an array of bool, got [True, False, False]"),
        (np.array([1, 0, 0]), TypeError, "reset_mask must be an array of bool, got array([1, 0, 0])"),
        (np.array([True]), ValueError, "reset_mask must have shape (3,), got (1,)"),
        (np.zeros(3, bool), ValueError, "reset_mask must name one sub-environment at least, got none"),
    ],
    ids=str,
)
def test_masks_that_are_refused_reset_nothing(mask, error, message):
    batch, twin = make_vec(3), make_vec(3)
    for each in (batch, twin):
        each.reset(seed=0)
        each.step([0, 1, 1])
    with pytest.raises(error, match=re.escape(message)):
        batch.reset(options={"reset_mask": mask})
    assert_same(batch.step([1, 1, 0]), twin.step([1, 1, 0]))


def test_options_that_are_no_mapping_are_refused():
    with pytest.raises(TypeError, match=re.escape("options must be a dict or None, got [True]")):
        make_vec(1).reset(options=[True])


@pytest.mark.parametrize("seed", [-1, 1.5, [1, 2], [1, 2, -3], True], ids=str)
def test_seeds_that_are_refused_reset_nothing(seed):
    batch, twin = make_vec(3), make_vec(3)
    for each in (batch, twin):
        each.reset(seed=0)
        each.step([0, 1, 1])
    with pytest.raises((ValueError, TypeError), match=r"seed must be .* got"):
        batch.reset(seed=seed)
    assert_same(batch.step([1, 1, 0]), twin.step([1, 1, 0]))


def test_a_step_needs_a_reset():
    with pytest.raises(ResetNeeded, match="reset"):
        make_vec(2).step([0, 1])
    with pytest.raises(ResetNeeded, match="first reset must be of all"):
        make_vec(2).reset(options={"reset_mask": np.array([True, False])})


@pytest.mark.parametrize("arguments", ARGUMENTS)
def test_the_first_reset_may_be_of_one_after_the_other(arguments):
    batch, singles = (make(3, **arguments) for make in (make_vec, one_by_one))
    assert_same(*(each.call("reset", seed=3) for each in (batch, singles)))
    for command in ([0, 1, 1], [1, 1, 0]):
        assert_same(*(each.step(command) for each in (batch, singles)))


def test_one_that_is_reset_alone_waits_for_the_others():
    batch = make_vec(3, groups=[None, {"damping_ratio": 1e3}, "linear"])  # by a solver each
    first = batch.sub_environments[1].reset(seed=1)
    with pytest.raises(ResetNeeded, match="reset"):
        batch.step([1, 1, 1])
    with pytest.raises(AttributeError, match="reset"):
        batch.crawler_of(0)
    assert batch.sub_environments[1].episode_groups.damping_ratio == 1e3
    assert_same(first, make_vec(3, groups={"damping_ratio": 1e3}).sub_environments[1].reset(seed=1))
    for i, seed in ((0, 0), (2, 2)):
        batch.sub_environments[i].reset(seed=seed)
    twin = make_vec(3, groups=[None, {"damping_ratio": 1e3}, "linear"])
    twin.reset(seed=0)
    assert_same(*(each.step([1, 1, 1]) for each in (batch, twin)))


def test_an_episode_that_is_over_is_not_stepped_on():
    batch, twin = (make_vec(3, autoreset_mode="Disabled", max_episode_steps=2) for _ in range(2))
    for each in (batch, twin):
        each.reset(seed=0)
        each.step([1, 1, 1])
        each.reset(options={"reset_mask": np.array([True, False, True])})
        each.step([1, 1, 1])
    with pytest.raises(ResetNeeded, match=re.escape("the episodes of sub-environments [1] are over")):
        batch.step([1, 1, 1])
    for each in (batch, twin):
        each.reset(options={"reset_mask": np.array([False, True, False])})
    assert_same(batch.step([1, 0, 1]), twin.step([1, 0, 1]))


def test_a_closed_environment_is_not_stepped():
    batch = make_vec(200, threads=2, render_mode="rgb_array")
    batch.reset(seed=0)
    batch.step(np.ones(200, int))
    batch.close()
    batch.close()
    for call in (lambda: batch.step(np.ones(200, int)), batch.reset, batch.render):
        with pytest.raises(ClosedEnvironmentError, match="closed"):
            call()


def test_a_diverged_motion_names_its_sub_environment_and_needs_a_reset():
    groups = [None, {"radial_coupling": 3.0, "duffing": 0.0}, None]
    batch, singles = (make(3, groups=groups, **SPEED_ONLY) for make in (make_vec, one_by_one))
    for each in (batch, singles):
        each.reset(seed=0)
    messages = []
    for each in (batch, singles):
        with pytest.raises(SolverError) as caught:  # noqa: PT012
            for _ in range(1000):
                each.step(np.ones(3, int))
        messages.append(str(caught.value))
    assert messages[0] == f"sub-environment 1: {messages[1]}"
    with pytest.raises(ResetNeeded, match="reset"):
        batch.step([1, 1, 1])
    batch.reset()
    assert (batch.step([1, 1, 1])[0][:, 2] > 0).all()


def test_after_a_diverged_motion_the_others_go_on_with_their_random_numbers():
    arguments = {
        "groups": {"radial_coupling": 0.0, "duffing": 0.0},
        "randomize": {"radial_coupling": [0.0, 3.0]},
        "dither": 0.3,
    }
    batch, singles = make_vec(4, **arguments), [gym.make(NAME, **arguments).unwrapped for _ in range(4)]
    batch.reset(seed=0)
    for i, single in enumerate(singles):
        single.reset(seed=i)
    failed, actions = set(), np.ones(4, int)
    while not failed:
        for i, single in enumerate(singles):
            try:
                single.step(1)
            except SolverError:
                failed.add(i)
        if failed:
            with pytest.raises(SolverError, match=f"sub-environment {min(failed)}: "):
                batch.step(actions)
        else:
            batch.step(actions)
    assert len(failed) < 4
    _, infos = batch.reset()
    expected = [single.reset()[1]["groups"]["radial_coupling"] for single in singles]
    assert infos["groups"]["radial_coupling"].tolist() == expected
    for _ in range(5):
        assert batch.step(actions)[4]["valve"].tolist() == [single.step(1)[4]["valve"] for single in singles]


def test_a_calibration_that_diverges_names_the_first_sub_environment_of_its_kind():
    groups = [None, None, None, {"radial_coupling": 3.0, "duffing": 0.0}]
    with pytest.raises(SolverError, match="sub-environment 3: the motion diverged"):
        make_vec(4, groups=groups).reset(seed=0)


def test_where_the_system_tells_no_affinity_all_processors_count(monkeypatch):
    monkeypatch.delattr("os.sched_getaffinity", raising=False)
    monkeypatch.setattr("os.cpu_count", lambda: None)
    batch = make_vec(2, **SPEED_ONLY)
    batch.reset(seed=0)
    assert batch.step([1, 1])[0].shape == (2, 5)
