"""A training that begins with a policy: it acts as that does, less certainly, and only where it can."""

import numpy as np
import pytest
import torch

from stickslip.envs import StickSlipCrawlerEnv
from stickslip.train import begun
from stickslip.train.algorithms import algorithm_class
from stickslip.train.begun import begin_from
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.run import Configuration
from stickslip.train.training import load_policy, train
from stickslip.train.vec_env import StickSlipVecEnv

ENVIRONMENT = {"dither": 0.1, "valve_history": 4}


def turned_back(observations):
    """The opposite of what the valve was three holds ago."""
    return 1 - observations[:, 6].astype(np.int64)


def model_of(algorithm, widths=(32, 32)):
    environments = StickSlipVecEnv(2, **ENVIRONMENT)
    return algorithm_class(algorithm)(
        "MlpPolicy", environments, device="cpu", seed=1, policy_kwargs={"net_arch": list(widths)}
    )


def seen_by(policy):
    """What a policy sees on its own way."""
    environment = StickSlipCrawlerEnv(**ENVIRONMENT)
    seen = [environment.reset(seed=5)[0]]
    for _ in range(400):
        seen.append(environment.step(int(policy(seen[-1])))[0])
    return np.array(seen[4:])


def test_it_commands_as_the_teacher_does_but_for_one_in_twenty():
    model = model_of("ppo")
    critic = [each.detach().clone() for each in model.policy.mlp_extractor.value_net.parameters()]
    begin_from(model, turned_back, ENVIRONMENT, seed=3)
    seen = seen_by(lambda observation: model.predict(observation, deterministic=True)[0])
    with torch.no_grad():
        chances = model.policy.get_distribution(torch.from_numpy(seen)).distribution.probs.numpy()
    wanted = turned_back(seen)
    assert (chances.argmax(axis=1) == wanted).all()
    assert np.median(chances[np.arange(len(seen)), wanted]) == pytest.approx(0.95, abs=0.01)
    assert all(map(torch.equal, critic, model.policy.mlp_extractor.value_net.parameters()))


def test_seeds_decide_what_is_shown(monkeypatch):
    monkeypatch.setattr(begun, "_UPDATES", 10)
    weights = []
    for seed in (3, 3, 4):
        model = model_of("ppo", (4,))
        begin_from(model, turned_back, ENVIRONMENT, seed=seed)
        weights.append(model.policy.action_net.weight.detach().numpy().copy())
    np.testing.assert_array_equal(weights[0], weights[1])
    assert not np.array_equal(weights[0], weights[2])


def test_who_has_no_chances_of_actions_is_refused():
    with pytest.raises(ValueError, match="must be of an actor and a critic, got DQNPolicy"):
        begin_from(model_of("dqn"), turned_back, ENVIRONMENT)


def test_a_training_begins_with_a_policy_where_it_is_said_and_there_alone(tmp_path):
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0")
    entry |= {"n_envs": 2, "n_steps": 4, "batch_size": 8, "n_timesteps": 8, "learning_rate": 1e-12}
    asked = {"env_kwargs": {"dither": 0.1}, "hyperparameters": entry}
    run = train(Configuration(**asked, start="policy", floor=0.3), tmp_path / "run", begin=turned_back)
    seen = seen_by(lambda observation: turned_back(observation[np.newaxis])[0])
    assert load_policy(run, trust=True).predict(seen, deterministic=True)[0].tolist() == turned_back(seen).tolist()
    for start, begin in (("policy", None), ("even", turned_back)):
        with pytest.raises(ValueError, match="begin must be a policy where start is 'policy', and there alone"):
            train(Configuration(**asked, start=start), tmp_path / start, begin=begin)
        assert not (tmp_path / start).exists()
