"""A training that begins with a policy: it acts as that does, less certainly, and only where it can."""

import numpy as np
import pytest
import torch

import stickslip
from stickslip.train.algorithms import algorithm_class
from stickslip.train.begun import begin_from
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.run import Configuration
from stickslip.train.training import load_policy, train
from stickslip.train.vec_env import StickSlipVecEnv

KNEE = stickslip.pretrained("knee")
SEEN = np.random.default_rng(2).normal(scale=0.7, size=(200, 8)).astype(np.float32)


def model_of(algorithm, widths):
    environments = StickSlipVecEnv(2, dither=0.1, valve_history=4)
    return algorithm_class(algorithm)("MlpPolicy", environments, device="cpu", policy_kwargs={"net_arch": widths})


def logits(layers):
    values = SEEN.astype(float)
    for layer in layers[:-1]:
        values = np.tanh(values @ layer.weight.T + layer.bias)
    return values @ layers[-1].weight.T + layers[-1].bias


def test_it_commands_as_the_policy_does_with_less_of_a_difference():
    model = model_of("ppo", KNEE.description["network"]["sizes"][1:-1])
    begin_from(model, KNEE)
    with torch.no_grad():
        chances = model.policy.get_distribution(torch.from_numpy(SEEN)).distribution.probs.numpy()
    off, on = logits(KNEE.layers).T
    np.testing.assert_allclose(chances[:, 1], 1 / (1 + np.exp(-0.3 * (on - off))), atol=1e-5)
    np.testing.assert_array_equal(chances.argmax(axis=1), KNEE.predict(SEEN))


@pytest.mark.parametrize(("algorithm", "widths"), [("ppo", [5, 5]), ("dqn", [32, 32])])
def test_another_network_is_refused(algorithm, widths):
    with pytest.raises(ValueError, match="policy to begin from must have layers of the shapes"):
        begin_from(model_of(algorithm, widths), KNEE)


def test_a_training_begins_with_a_policy_where_it_is_said_and_there_alone(tmp_path):
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0")
    widths = KNEE.description["network"]["sizes"][1:-1]
    entry |= {"n_envs": 2, "n_steps": 4, "batch_size": 8, "n_timesteps": 8, "learning_rate": 1e-12}
    asked = {"env_kwargs": {"dither": 0.1}, "hyperparameters": {**entry, "policy_kwargs": {"net_arch": widths}}}
    run = train(Configuration(**asked, start="policy", floor=0.3), tmp_path / "run", begin=KNEE)
    assert load_policy(run, trust=True).predict(SEEN, deterministic=True)[0].tolist() == KNEE.predict(SEEN).tolist()
    for start, begin in (("policy", None), ("even", KNEE)):
        with pytest.raises(ValueError, match="begin must be a policy where start is 'policy', and there alone"):
            train(Configuration(**asked, start=start), tmp_path / start, begin=begin)
        assert not (tmp_path / start).exists()
