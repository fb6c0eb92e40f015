"""Policies in NumPy alone: they act as Stable-Baselines3's do, and say where they come from."""

import pickle
import subprocess
import sys
from copy import deepcopy

import numpy as np
import pytest
import torch
from sb3_contrib import QRDQN, RecurrentPPO
from stable_baselines3 import A2C, DQN, PPO
from torch import nn

from stickslip.train import StickSlipVecEnv
from stickslip.train.policies import Policy, policy_of
from stickslip.train.run import Configuration

KINDS = {"ppo": PPO, "a2c": A2C, "dqn": DQN, "qrdqn": QRDQN}
HARD = {"hold": 0.25, "dither": 0.2, "memory_weight": 0.3, "groups": {"duffing": 2.0}}


def model_of(algorithm, *, batch=None, spread=1.0, seed=0, **policy_kwargs):
    """An untrained model whose weights are so large that its actions differ from place to place."""
    batch = StickSlipVecEnv(1, **HARD) if batch is None else batch
    name = "MlpLstmPolicy" if algorithm is RecurrentPPO else "MlpPolicy"
    model = algorithm(name, batch, seed=seed, device="cpu", policy_kwargs=policy_kwargs or None)
    generator = torch.Generator().manual_seed(seed)
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter += spread * torch.randn(parameter.shape, generator=generator)
    return model


def described(name="ppo"):
    return Configuration(algorithm=name, env_kwargs=HARD, hyperparameters={"n_steps": 8}, seed=3)


def observations(count, inputs, scale=1.0):
    return (scale * np.random.default_rng(1).standard_normal((count, inputs))).astype(np.float32)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("net_arch", [[], [7], [32, 32]], ids=str)
def test_actions_are_those_of_stable_baselines(name, net_arch):
    model = model_of(KINDS[name], net_arch=net_arch)
    policy = policy_of(model, described(name))
    inputs = policy.description["observation_space"]["shape"][0]
    for scale in (1e-3, 1.0, 1e3):
        seen = observations(1000, inputs, scale)
        expected, _ = model.predict(seen, deterministic=True)
        # Where the outputs are level to its rounding errors, single precision decides by those.
        outputs = policy.outputs(seen)
        clear = np.abs(outputs[:, 1] - outputs[:, 0]) > 1e-5 * np.abs(outputs).max()
        actions = policy.predict(seen)
        assert actions.dtype == np.int64
        np.testing.assert_array_equal(actions[clear], expected[clear])
        assert clear.mean() > 0.99
    assert set(policy.predict(observations(1000, inputs))) == {0, 1}
    # One by one as in a batch.
    assert [int(policy.predict(each)) for each in seen[:50]] == actions[:50].tolist()
    assert policy.predict(seen[0]) == model.predict(seen[0], deterministic=True)[0]


@pytest.mark.parametrize("name", KINDS)
def test_level_outputs_shut_the_valve_as_stable_baselines_does(name):
    model = model_of(KINDS[name])
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter.zero_()
    seen = observations(20, 5)
    assert (
        policy_of(model, described(name)).predict(seen).tolist() == model.predict(seen, deterministic=True)[0].tolist()
    )
    assert policy_of(model, described(name)).predict(seen).tolist() == [0] * 20


def test_activations_other_than_the_usual_are_kept_or_refused():
    model = model_of(PPO, activation_fn=nn.ReLU)
    policy = policy_of(model, described())
    seen = observations(1000, 5)
    np.testing.assert_array_equal(policy.predict(seen), model.predict(seen, deterministic=True)[0])
    assert policy.description["network"]["activation"] == "relu"
    with pytest.raises(ValueError, match=r"all Tanh or all ReLU between them, got \['Linear', 'ELU'"):
        policy_of(model_of(PPO, activation_fn=nn.ELU), described())


def test_a_recurrent_policy_is_refused():
    with pytest.raises(ValueError, match="must have a policy without memory, got RecurrentActorCriticPolicy"):
        policy_of(model_of(RecurrentPPO), described("recurrent_ppo"))


def test_actions_are_drawn_as_often_as_their_logits_say():
    model = model_of(PPO)
    policy = policy_of(model, described())
    (seen,) = observations(1, 5)
    logits = policy.outputs(seen)
    share = 1.0 / (1.0 + np.exp(logits[0] - logits[1]))
    drawn = policy.predict(np.tile(seen, (40_000, 1)), deterministic=False, rng=np.random.default_rng(0))
    assert abs(drawn.mean() - share) < 4 * np.sqrt(share * (1 - share) / 40_000)
    with torch.no_grad():
        expected = model.policy.get_distribution(torch.as_tensor(seen[None])).distribution.probs[0, 1]
    assert share == pytest.approx(float(expected), rel=1e-5)
    assert policy.predict(seen, deterministic=False) in (0, 1)
    with pytest.raises(ValueError, match="deterministic must be True for a policy of action values"):
        policy_of(model_of(DQN), described("dqn")).predict(seen, deterministic=False)


def test_a_policy_says_where_it_comes_from_and_nothing_changes_it():
    model = model_of(PPO, net_arch=[4])
    policy = policy_of(model, described(), {"speed": {"mean": 0.5}})
    assert policy.env_kwargs == HARD
    assert policy.scores == {"speed": {"mean": 0.5}}
    description = policy.description
    assert description["groups"]["duffing"] == 2.0
    assert description["groups"]["deborah"] == 0.5
    assert description["algorithm"] == {
        "name": "ppo",
        "hyperparameters": {"n_steps": 8},
        "seed": 3,
        "start": "even",
        "floor": None,
        "steps": 0,
    }
    assert description["versions"]["torch"] == torch.__version__.split("+")[0] or torch.__version__
    assert description["network"] == {"sizes": [5, 4, 2], "activation": "tanh", "outputs": "logits"}
    names = ["deformation", "velocity", "pressure", "foot_velocity", "valve 1 holds ago"]
    assert description["observation_space"]["names"] == names
    assert description["observation_space"]["low"][:3] == ["-inf", "-inf", 0.0]
    assert repr(policy) == "Policy(StickSlipCrawler-v0, ppo, 5-4-2)"
    seen = observations(100, 5)
    before = policy.predict(seen).tolist()
    policy.env_kwargs["hold"] = policy.description["env_kwargs"]["hold"] = 3.0
    policy.scores.clear()
    with torch.no_grad():
        model.policy.action_net.bias.fill_(1e6)
    assert policy.predict(seen).tolist() == before
    assert policy.description == description
    for each in (policy, pickle.loads(pickle.dumps(policy)), deepcopy(policy)):
        assert each.description == description
        assert each.predict(seen).tolist() == before
        with pytest.raises(ValueError, match="read-only"):
            each.layers[0].weight[0] = 1.0
        with pytest.raises(AttributeError):
            each.layers = ()


class Wider(StickSlipVecEnv):
    """Shows one number more than the environment does."""

    def __init__(self):
        super().__init__(1, **HARD)
        space = self.observation_space
        low, high = np.append(space.low, 0.0), np.append(space.high, 1.0)
        self.observation_space = type(space)(low.astype(np.float32), high.astype(np.float32))


def test_a_model_of_other_observations_is_refused():
    with pytest.raises(ValueError, match="model must take the 5 numbers that the environment shows, it takes 6"):
        policy_of(model_of(PPO, batch=Wider()), described())


def test_a_conditioned_policy_takes_the_weight_beside_the_observation():
    description = policy_of(model_of(PPO, net_arch=[7]), described()).description
    description |= {"conditioned": True, "network": {**description["network"], "sizes": [6, 7, 2]}}
    generator = np.random.default_rng(0)
    (first, bias), (last, offset) = [
        (generator.normal(size=(b, a)).astype(np.float32), generator.normal(size=b).astype(np.float32))
        for a, b in ((6, 7), (7, 2))
    ]
    policy = Policy([(first, bias), (last, offset)], description)
    seen, weights = observations(500, 5), np.random.default_rng(0).random(500)
    beside = np.column_stack([seen, weights]).astype(np.float32)
    outputs = np.tanh(beside @ first.T.astype(np.float64) + bias) @ last.T.astype(np.float64) + offset
    np.testing.assert_array_equal(policy.predict(seen, weights), outputs.argmax(axis=1))
    assert [int(policy.predict(one, 0.25)) for one in seen[:30]] == policy.predict(seen[:30], 0.25).tolist()
    np.testing.assert_array_equal(policy.predict(seen, 0.25), policy.predict(seen, np.full(500, 0.25)))
    assert not np.array_equal(policy.predict(seen, 0.0), policy.predict(seen, 1.0))
    for weight, message in (
        (None, "weight must be given"),
        (1.5, r"weight must be in \[0, 1\], got 1.5"),
        (np.nan, "weight must be finite"),
        ([0.1, 0.2], r"weight must be one number or one for each observation, got shape \(2,\)"),
    ):
        with pytest.raises(ValueError, match=message):
            policy.predict(seen, weight)


@pytest.mark.parametrize(
    ("seen", "message"),
    [
        (np.zeros(4), r"observation must be of shape \(5,\) or \(n, 5\), got \(4,\)"),
        (np.zeros((2, 3, 5)), "observation must be 1-dimensional or 2-dimensional"),
        (np.full(5, np.nan), "observation must be finite"),
        (np.full(5, 1e300), "observation in single precision must be finite"),
    ],
)
def test_what_is_no_observation_is_refused(seen, message):
    with pytest.raises(ValueError, match=message):
        policy_of(model_of(PPO), described()).predict(seen)
    with pytest.raises(ValueError, match="weight must be None"):
        policy_of(model_of(PPO), described()).predict(np.zeros(5), 0.5)


def test_a_policy_runs_where_nothing_is_installed_that_trains_one():
    blocked = "import sys; sys.modules.update(dict.fromkeys(['torch', 'stable_baselines3', 'sb3_contrib', 'yaml']))\n"
    code = "import stickslip.train.policies.files, stickslip.train.policies.policy; print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", blocked + code], capture_output=True, text=True, encoding="utf-8")
    assert (done.returncode, done.stdout.strip()) == (0, "False"), done.stderr
