"""One policy for every weight: what it sees, what it earns, which weights are drawn."""

import gymnasium as gym
import numpy as np
import pytest

from stickslip.train.conditioned import drawn_weights, ENVIRONMENT, train_conditioned, unit_of_reward, WeightedVecEnv
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.run import Configuration

TRADE = {"dither": 0.1, "valve_history": 2}


def test_what_is_seen_and_earned_is_the_single_environment_s_with_the_weight():
    batch = WeightedVecEnv(3, max_episode_steps=5, **TRADE)
    batch.seed(7)
    seen = batch.reset()
    singles = [gym.make("StickSlipCrawler-v0", memory_weight=0.0, max_episode_steps=5, **TRADE) for _ in range(3)]
    for i, single in enumerate(singles):
        single.reset(seed=7 + i)
    generator, weights = np.random.default_rng(0), batch.weights.copy()
    for step in range(1, 11):
        actions = generator.integers(0, 2, 3)
        np.testing.assert_array_equal(seen[:, -1], weights.astype(np.float32))
        seen, rewards, dones, infos = batch.step(actions)
        for i, single in enumerate(singles):
            observation, _, _, truncated, info = single.step(actions[i])
            earned = (1 - weights[i]) * info["speed"] + weights[i] * info["memory"]
            assert rewards[i] == pytest.approx(earned / max(0.84 * (1 - weights[i]), 4 * weights[i]), rel=1e-6)
            assert dones[i] == infos[i]["TimeLimit.truncated"] == truncated == (step % 5 == 0)
            if truncated:
                np.testing.assert_array_equal(infos[i]["terminal_observation"][:-1], observation)
                assert infos[i]["terminal_observation"][-1] == np.float32(weights[i])
                observation, _ = single.reset()
            np.testing.assert_array_equal(seen[i, :-1], observation)
        if step == 5:
            assert not np.array_equal(batch.weights, weights)
            weights = batch.weights.copy()
    batch.seed(7)
    np.testing.assert_array_equal(batch.reset(), np.column_stack([np.zeros((3, 6)), batch.weights]).astype(np.float32))
    batch.close()


def test_weights_are_spread_and_half_of_them_lie_where_the_front_bends():
    generator = np.random.default_rng(0)
    weights, others = (np.sort(drawn_weights(1000, generator)) for _ in range(2))
    # One in each of as many strata of its square root, which is uniform.
    assert np.array_equal(np.floor(1000 * np.sqrt(weights)), np.arange(1000))
    assert not np.array_equal(weights, others)


def test_no_weight_drowns_another():
    # The fastest policy, at 0, and the valve held open, at 1, earn one unit; and no reward is divided by nothing.
    np.testing.assert_allclose(unit_of_reward(np.array([0.0, 1.0])), [0.84, 4.0])
    assert unit_of_reward(np.linspace(0, 1, 101)).min() > 0.6


def test_a_conditioned_policy_takes_the_weight_and_answers_to_it():
    entry = read_hyperparameters("ppo", ENVIRONMENT)
    entry |= {"n_envs": 4, "n_steps": 16, "batch_size": 64, "n_timesteps": 192, "learning_rate": 0.03}
    asked = Configuration(env_kwargs=TRADE, hyperparameters=entry, seed=3)
    steps = []
    policy = train_conditioned(asked, on_progress=steps.append)
    assert steps == list(range(4, 193, 4))
    assert policy.conditioned
    assert policy.env_kwargs == TRADE
    seen = np.random.default_rng(1).normal(size=(400, 6)).astype(np.float32)
    at = [policy.predict(seen, weight) for weight in (0.0, 1.0)]
    assert not np.array_equal(*at)
    np.testing.assert_array_equal(train_conditioned(asked).predict(seen, 0.5), policy.predict(seen, 0.5))


def test_a_weight_is_no_argument_of_its_environment():
    with pytest.raises(TypeError, match="memory_weight is no argument"):
        WeightedVecEnv(2, memory_weight=0.5)
