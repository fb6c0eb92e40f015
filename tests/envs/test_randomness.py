"""Every flip comes from the generator that the environment has at that step."""

import copy
import pickle

import gymnasium as gym
import numpy as np
import pytest

from stickslip.envs import StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv
from stickslip.train import StickSlipVecEnv

NAME = "StickSlipCrawler-v0"
DITHER = 0.5
STEPS = 40


def single(**arguments):
    return gym.make(NAME, dither=DITHER, **arguments)


def batch(count, **arguments):
    return gym.make_vec(NAME, count, dither=DITHER, **arguments)


def flips_of(generator, steps=STEPS):
    return [generator.random() < DITHER for _ in range(steps)]


def flips(env, steps=STEPS):
    return [bool(env.step(0)[4]["valve"]) for _ in range(steps)]


def flips_of_each(envs, steps=STEPS):
    count = envs.num_envs
    return np.array([envs.step(np.zeros(count, int))[4]["valve"] for _ in range(steps)], bool).T.tolist()


GENERATORS = [np.random.PCG64, np.random.MT19937, np.random.SFC64, np.random.Philox, np.random.PCG64DXSM]


@pytest.mark.parametrize("bits", GENERATORS)
def test_a_step_draws_one_number_when_it_is_taken(bits):
    env, envs = single(), batch(3)
    env.reset(seed=0), envs.reset(seed=0)
    env.unwrapped.np_random = np.random.Generator(bits(7))
    envs.np_random = [np.random.Generator(bits(7 + i)) for i in range(3)]
    assert env.unwrapped.np_random_seed == -1
    assert envs.np_random_seed == (-1,) * 3
    mine = [np.random.Generator(bits(7 + i)) for i in range(3)]
    for _ in range(3):
        assert flips(env) == flips_of(copy.deepcopy(mine[0]))
        assert flips_of_each(envs) == [flips_of(each) for each in mine]
        # Others may draw between two steps.
        for each, own in zip(mine, envs.np_random, strict=True):
            assert each.random() == own.random()
        env.unwrapped.np_random.random()


@pytest.mark.parametrize("steps_before", [0, 1, 5, 255, 256, 257])
def test_the_next_flip_follows_a_generator_that_was_set(steps_before):
    env, envs = single(), batch(2)
    env.reset(seed=1), envs.reset(seed=1)
    flips(env, steps_before), flips_of_each(envs, steps_before)
    env.np_random = np.random.default_rng(3)
    envs.np_random = tuple(np.random.default_rng(3 + i) for i in range(2))
    expected = [flips_of(np.random.default_rng(3 + i)) for i in range(2)]
    assert flips(env) == expected[0]
    assert flips_of_each(envs) == expected


@pytest.mark.parametrize(
    "twin_of", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))], ids=["copy", "pickle"]
)
def test_the_next_flip_of_a_copy_follows_its_own_generator(twin_of):
    env, envs = single(), batch(2)
    env.reset(seed=1), envs.reset(seed=1)
    flips(env, 5), flips_of_each(envs, 5)
    twin, ensemble = twin_of(env), twin_of(envs)
    before = copy.deepcopy(env.unwrapped.np_random)
    twin.unwrapped.np_random = np.random.default_rng(3)
    ensemble.np_random[1].bit_generator.state = np.random.default_rng(4).bit_generator.state
    assert flips(twin) == flips_of(np.random.default_rng(3))
    assert flips_of_each(ensemble)[1] == flips_of(np.random.default_rng(4))
    # And the original's are its own.
    assert flips(env) == flips_of(copy.deepcopy(before))
    assert flips_of_each(envs)[0] == flips_of(before)


def test_the_state_of_a_generator_may_be_set_in_place():
    env, envs = single(), batch(2)
    env.reset(seed=1), envs.reset(seed=1)
    flips(env, 5), flips_of_each(envs, 5)
    state = np.random.default_rng(8).bit_generator.state
    for generator in (env.unwrapped.np_random, envs.np_random[0]):
        generator.bit_generator.state = state
    assert flips(env) == flips_of_each(envs)[0] == flips_of(np.random.default_rng(8))


def test_what_is_drawn_at_a_reset_and_the_flips_are_one_series():
    ranges = {"duffing": [0.0, 1.0], "slope": [-0.1, 0.1]}
    env, envs = single(randomize=ranges), batch(2, randomize=ranges)
    env.reset(seed=5), envs.reset(seed=5)
    generator = np.random.default_rng(5)
    for episode in range(3):
        info, infos = (env.reset()[1], envs.reset()[1]) if episode else (env.reset(seed=5)[1], envs.reset(seed=5)[1])
        drawn = [generator.uniform(*ranges[name]) for name in ("duffing", "slope")]
        assert [info["groups"]["duffing"], info["slope"]] == drawn
        assert [infos["groups"]["duffing"][0], infos["slope"][0]] == drawn
        expected = flips_of(generator)
        assert flips(env) == flips_of_each(envs)[0] == expected


def test_without_dither_no_step_draws():
    arguments = {"dither": 0.0, "memory_weight": 0.0}
    env, envs = gym.make(NAME, **arguments), gym.make_vec(NAME, 1, **arguments)
    env.reset(seed=0), envs.reset(seed=0)
    flips(env), flips_of_each(envs)
    untouched = np.random.default_rng(0).random()
    assert env.unwrapped.np_random.random() == envs.np_random[0].random() == untouched


def test_one_generator_spawns_those_of_a_batch():
    envs = batch(3)
    envs.reset(seed=0)
    envs.np_random = np.random.default_rng(11)
    assert flips_of_each(envs) == [flips_of(each) for each in np.random.default_rng(11).spawn(3)]


def test_generators_are_there_before_the_first_reset():
    env, envs = single(), batch(2)
    env.unwrapped.np_random = np.random.default_rng(2)
    envs.np_random = [np.random.default_rng(2 + i) for i in range(2)]
    env.reset(), envs.reset()
    expected = [flips_of(np.random.default_rng(2 + i)) for i in range(2)]
    assert flips(env) == expected[0]
    assert flips_of_each(envs) == expected
    assert all(isinstance(generator, np.random.Generator) for generator in batch(2).np_random)
    assert len(set(batch(2).np_random_seed)) == 2


def test_threads_draw_in_order():
    count = 300
    envs = batch(count, threads=2)
    envs.reset(seed=9)
    assert flips_of_each(envs) == [flips_of(np.random.default_rng(9 + i)) for i in range(count)]


def test_sub_environments_of_sb3_can_be_given_a_generator():
    native = StickSlipVecEnv(2, dither=DITHER)
    native.seed(0)
    native.reset()
    native.set_attr("np_random", np.random.default_rng(6), indices=[1])
    answers = [native.step(np.zeros(2, int))[3][1]["valve"] for _ in range(STEPS)]
    assert [bool(valve) for valve in answers] == flips_of(np.random.default_rng(6))


@pytest.mark.parametrize(
    "value",
    [None, 3, [1, 2], [np.random.default_rng(0)], [np.random.default_rng(0)] * 2],
    ids=["none", "number", "numbers", "too few", "one twice"],
)
def test_generators_that_are_refused_set_nothing(value):
    envs = StickSlipCrawlerVectorEnv(2, dither=DITHER)
    envs.reset(seed=0)
    with pytest.raises((TypeError, ValueError), match=r"np_random must be .*2.* got"):
        envs.np_random = value
    assert flips_of_each(envs) == [flips_of(np.random.default_rng(i)) for i in range(2)]


@pytest.mark.parametrize(
    "value", [None, 3, np.random.RandomState(0), [np.random.default_rng(0)]], ids=["none", "number", "old", "list"]
)
def test_what_is_no_generator_is_refused_and_the_flips_go_on(value):
    env = StickSlipCrawlerEnv(dither=DITHER)
    env.reset(seed=0)
    with pytest.raises(TypeError, match=r"np_random must be a numpy\.random\.Generator, got"):
        env.np_random = value
    assert flips(env) == flips_of(np.random.default_rng(0))
