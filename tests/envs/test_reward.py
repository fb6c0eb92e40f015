import gymnasium as gym
import numpy as np
import pytest

from stickslip import Groups, memory_capacity, simulate
from stickslip.reservoir import target_series

NAME = "StickSlipCrawler-v0"
WORDS = ["0", "1", "10", "110", "100", "1100", "11100", "111000", "11110000", "111111000000", "1110"]


def schedule(word, steps, seed=0):
    if word == "random":
        return np.random.default_rng(seed).integers(0, 2, steps)
    return np.resize([int(letter) for letter in word], steps)


def episode(actions, seed=0, **arguments):
    """Rewards and infos, the latter as arrays by name."""
    env = gym.make(NAME, max_episode_steps=len(actions), **arguments)
    env.reset(seed=seed)
    _, rewards, _, _, infos = zip(*(env.step(int(action)) for action in actions), strict=True)
    return np.array(rewards), {name: np.array([info[name] for info in infos]) for name in infos[0]}


@pytest.mark.parametrize("dither", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("word", ["0", "1", "1100"])
def test_flips_come_at_the_rate_of_the_dither_whatever_the_command(word, dither):
    actions = schedule(word, 8000)
    _, info = episode(actions, dither=dither)
    flipped = info["valve"] != actions
    for action in set(actions.tolist()):
        flips = flipped[actions == action]
        assert abs(flips.sum() - dither * flips.size) < 4 * np.sqrt(flips.size * dither * (1 - dither))
    # Neither does one flip tell of the next: the mean of a product of two has deviation Var / sqrt(steps).
    error = flipped - dither
    assert abs((error[1:] * error[:-1]).mean()) < 4 * dither * (1 - dither) / np.sqrt(8000)


def test_flips_do_not_depend_on_the_commands():
    one, other = (episode(schedule(word, 1000)) for word in ("0", "random"))
    np.testing.assert_array_equal(one[1]["valve"] != 0, other[1]["valve"] != schedule("random", 1000))


@pytest.mark.parametrize("dither", [0.0, 0.1, 0.5])
def test_the_innovation_is_the_valve_less_what_the_command_told(dither):
    actions = schedule("random", 500)
    _, info = episode(actions, dither=dither, memory_weight=0.0)
    expected = (1 - dither) * actions + dither * (1 - actions)
    np.testing.assert_allclose(info["innovation"], info["valve"] - expected, rtol=0, atol=1e-16)


@pytest.mark.parametrize("word", ["0", "1", "11100", "random"])
def test_the_innovation_has_the_mean_and_variance_of_a_flip(word):
    steps, dither = 10_000, 0.1
    innovation = episode(schedule(word, steps), dither=dither)[1]["innovation"]
    variance = dither * (1 - dither)
    fourth = variance * (1 - 3 * variance)
    assert abs(innovation.mean()) < 4 * np.sqrt(variance / steps)
    assert abs((innovation**2).mean() - variance) < 4 * np.sqrt((fourth - variance**2) / steps)


@pytest.mark.parametrize("weight", [0.0, 0.3, 1.0])
def test_the_reward_mixes_speed_and_memory(weight):
    rewards, info = episode(schedule("11100", 300), memory_weight=weight, hold=0.7)
    np.testing.assert_allclose(rewards, (1 - weight) * info["speed"] + weight * info["memory"], rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(np.cumsum(info["speed"]) * 0.7, info["distance"], rtol=0, atol=1e-12)
    assert info["distance"][-1] > 10


def test_without_dither_there_is_neither_message_nor_memory():
    actions = schedule("11100", 200)
    rewards, info = episode(actions, dither=0.0, memory_weight=0.0)
    np.testing.assert_array_equal(info["valve"], actions)
    np.testing.assert_array_equal(info["innovation"], 0.0)
    np.testing.assert_array_equal(info["memory"], 0.0)
    np.testing.assert_array_equal(rewards, info["speed"])


def test_memory_weighs_nothing_when_it_is_only_watched():
    rewards, info = episode(schedule("11100", 200), dither=0.1, memory_weight=0.0)
    np.testing.assert_array_equal(rewards, info["speed"])
    assert np.abs(info["memory"]).max() > 0.1


def test_the_best_gait_known_crawls_at_its_speed():
    """Found by search at hold 0.5 without dither."""
    _, info = episode(schedule("11100", 1000), dither=0.0, memory_weight=0.0)
    assert info["speed"][500:].mean() == pytest.approx(1.0615, abs=1e-4)


def test_an_anchored_crawler_goes_nowhere_and_remembers_more_than_nothing():
    rewards, info = episode(schedule("random", 1000), scene={"anchored": True}, dither=0.5, memory_weight=1.0)
    assert not info["speed"].any()
    assert rewards.mean() > 1


def test_the_mean_memory_reward_tends_to_the_offline_capacity():
    """And ranks schedules rightly."""
    earned, capacity = [], []
    for word in [*WORDS, "random"]:
        _, info = episode(schedule(word, 6000), seed=1)
        earned.append(info["memory"].mean())
        _, info = episode(schedule(word, 24_000), seed=2)
        motion = simulate(
            gym.make(NAME).unwrapped.settings.groups, info["valve"], 0.5, tolerance=1e-6, samples_per_hold=4
        )
        readings = (motion.deformation, motion.velocity, motion.pressure)
        states = np.hstack([reading.reshape(-1, 4) for reading in readings])
        capacity.append(memory_capacity(states, info["innovation"], 20).corrected)
    error = np.subtract(earned, capacity)
    assert np.corrcoef(earned, capacity)[0, 1] > 0.99
    assert abs(error.mean()) < 0.05
    assert (np.abs(error) < 0.3).all()


def capacity_of(groups, command, dither=0.1, delays=20, nodes=4):
    flips = np.random.default_rng(4).random(len(command)) < dither
    valve = command ^ flips
    motion = simulate(groups, valve, 0.5, tolerance=1e-6, samples_per_hold=nodes)
    states = np.hstack([each.reshape(-1, nodes) for each in (motion.deformation, motion.velocity, motion.pressure)])
    return memory_capacity(states, valve - np.abs(command - dither), delays).corrected


@pytest.mark.parametrize(
    ("dither", "delays", "nodes", "least"),
    [(0.1, 20, 4, 0.95), (0.5, 20, 4, 0.95), (0.02, 20, 4, 0.75), (0.1, 60, 4, 0.95), (0.1, 20, 8, 0.9)],
)
def test_episodes_of_a_thousand_steps_are_right_on_average(dither, delays, nodes, least):
    envs = gym.make_vec(NAME, 50, dither=dither, delays=delays, virtual_nodes=nodes)
    capacity, earned = [], []
    for number, word in enumerate(["1", "11100", "random"]):
        capacity.append(capacity_of(Groups(), schedule(word, 10_000), dither, delays, nodes))
        envs.reset(seed=1000 * number)
        earned.append(np.mean([envs.step([command] * 50)[4]["memory"] for command in schedule(word, 1000, 9)]))
    assert least < np.mean(earned) / np.mean(capacity) < 1.06


def test_each_drawn_body_has_a_readout_of_its_own():
    """With one that was fitted to the body between them the mean was two thirds of the capacity."""
    ranges = {"duffing": [0.0, 2.0], "damping_ratio": [0.02, 0.5], "deborah": [0.2, 2.0]}
    bodies = 20
    envs = gym.make_vec(NAME, bodies, randomize=ranges)
    groups = envs.reset(seed=0)[1]["groups"]
    earned = np.mean([envs.step(np.ones(bodies, int))[4]["memory"] for _ in range(1000)])
    drawn = [Groups(**{name: each[i] for name, each in groups.items() if name[0] != "_"}) for i in range(bodies)]
    capacity = np.mean([capacity_of(each, np.ones(6000, int)) for each in drawn])
    assert 0.88 < earned / capacity < 1.05


def test_a_body_that_options_settle_has_a_readout_of_its_own():
    envs, own = gym.make_vec(NAME, 50), gym.make_vec(NAME, 50, groups="high-damping")
    envs.reset(seed=0, options={"groups": "high-damping"}), own.reset(seed=0)
    memory = [[each.step(np.ones(50, int))[4]["memory"] for _ in range(1000)] for each in (envs, own)]
    assert np.mean(memory[0]) == pytest.approx(np.mean(memory[1]), rel=0.02)


AIMS = [{"target": "parity", "delays": 6}, {"target": "narma", "target_order": 3}]


@pytest.mark.parametrize("aim", AIMS, ids=str)
def test_what_another_target_earns_is_its_offline_capacity_of_the_same_run(aim):
    steps, dither = 2500, 0.3
    envs = gym.make_vec(NAME, 9, dither=dither, max_episode_steps=None, **aim).unwrapped
    actions = np.repeat([schedule(word, steps) for word in ("1", "11100", "random")], 3, axis=0).T
    envs.reset(seed=0)
    earned, innovations, states = np.empty((steps, 9)), np.empty((steps, 9)), np.empty((steps, 9, 12))
    for k, action in enumerate(actions):
        info = envs.step(action)[4]
        earned[k], innovations[k], states[k] = info["memory"], info["innovation"], envs.readout_states()
    settings = envs.settings
    capacity = []
    for i in range(9):
        message = target_series(innovations[:, i], settings.target, settings.target_order, dither)
        capacity.append(memory_capacity(states[:, i], message, settings.messages).corrected)
    assert abs(earned.mean() - np.mean(capacity)) < 0.05
    assert np.corrcoef(earned.mean(axis=0), capacity)[0, 1] > 0.9
    assert np.ptp(capacity) > 0.1


def test_a_thousand_steps_already_rank_the_schedules():
    means = [episode(schedule(word, 1000), seed=3)[1]["memory"].mean() for word in ("0", "10", "11100", "random")]
    assert means == sorted(means, reverse=True)
