"""Several policies in one: at each weight it acts as the one that pays best there."""

import numpy as np
import pytest
import torch

import stickslip
from stickslip.envs import StickSlipCrawlerVectorEnv
from stickslip.train import distilled
from stickslip.train.distilled import best_at, distil
from stickslip.train.policies import Policy


def holding(bias, speed, memory):
    """A policy that holds the valve still, or, with no bias, follows the last valve state, with scores of its own."""
    knee = stickslip.pretrained("knee")
    description = knee.description
    description["network"]["sizes"] = [8, 2]
    description["scores"] = {"speed": {"mean": speed}, "memory": {"mean": memory}}
    weight = np.zeros((2, 8), np.float32)
    weight[1, 4] = 0.0 if bias else 2.0
    return Policy([(weight, np.array([0.0, bias or -1.0], np.float32))], description)


SHUT, OPEN = holding(-1.0, 0.5, 0.0), holding(1.0, 0.0, 1.0)


def test_the_best_is_that_of_most_reward():
    # (1 - w) / 2 against w: level at a third.
    assert best_at([SHUT, OPEN], np.array([0.0, 0.33, 0.34, 1.0])).tolist() == [0, 0, 1, 1]


def test_one_network_acts_as_the_best_at_each_weight():
    settings = {"hidden": (8,), "rounds": 2, "holds": 20, "updates": 300}
    pupil = distil([SHUT, OPEN], **settings)
    seen = np.abs(np.random.default_rng(0).normal(size=(200, 8))) * 0.3
    for weight, action in ((0.0, 0), (0.2, 0), (0.6, 1), (1.0, 1)):
        assert np.mean(pupil.predict(seen, weight) == action) > 0.97
    assert pupil.conditioned
    assert "memory_weight" not in pupil.env_kwargs
    assert [each["scores"] for each in pupil.description["algorithm"]["teachers"]] == [SHUT.scores, OPEN.scores]
    again, other = distil([SHUT, OPEN], **settings), distil([SHUT, OPEN], **settings, seed=1)
    np.testing.assert_array_equal(again.layers[0].weight, pupil.layers[0].weight)
    assert not np.array_equal(other.layers[0].weight, pupil.layers[0].weight)


def test_teachers_of_other_environments_are_refused():
    description = OPEN.description
    description["env_kwargs"]["hold"] = 0.25
    with pytest.raises(ValueError, match="policies must be of one environment but for memory_weight"):
        distil([SHUT, Policy(OPEN.layers, description)])


@pytest.fixture
def crawled(monkeypatch):
    """What the batches of `distil` are asked for and do, one entry a batch: arguments, seed, commands and seen."""
    batches = []

    class Watched(StickSlipCrawlerVectorEnv):
        def __init__(self, count, **arguments):
            super().__init__(count, **arguments)
            batches.append({"count": count, "arguments": arguments, "commands": [], "seen": []})

        def reset(self, *, seed=None, options=None):
            batches[-1]["seed"] = seed
            observation, infos = super().reset(seed=seed, options=options)
            batches[-1]["seen"].append(observation)
            return observation, infos

        def step(self, actions):
            batches[-1]["commands"].append(np.array(actions))
            came = super().step(actions)
            batches[-1]["seen"].append(came[0])
            return came

    monkeypatch.setattr(distilled, "StickSlipCrawlerVectorEnv", Watched)
    return batches


def test_bodies_crawl_as_their_teachers_do_and_then_as_the_pupil(crawled):
    holds = 6
    pupil = torch.nn.Linear(9, 2)
    states, answers = distilled._crawl([SHUT, OPEN], None, holds, np.random.default_rng(3))
    by_pupil, _ = distilled._crawl([SHUT, OPEN], pupil, holds, np.random.default_rng(3))
    weight = states[:64, -1].astype(np.float64)
    np.testing.assert_array_equal(states[:, -1], np.tile(states[:64, -1], holds))
    # Before half of them were squared and halved there was one in each 64th of [0, 1].
    even = weight.copy()
    even[::2] = np.sqrt(2.0 * weight[::2])
    assert sorted(np.floor(64.0 * even + 1e-4 * (np.arange(64) % 2 == 0)).tolist()) == list(range(64))
    np.testing.assert_array_equal(answers, np.tile((weight > 1 / 3).astype(int), holds))
    for seen, batch in zip((states, by_pupil), crawled, strict=True):
        np.testing.assert_array_equal(seen[:, :-1], np.concatenate(batch["seen"][:holds]))
        assert (batch["count"], batch["arguments"]["memory_weight"]) == (64, 0.0)
        assert batch["arguments"]["max_episode_steps"] is None
    np.testing.assert_array_equal(np.concatenate(crawled[0]["commands"]), answers)
    with torch.no_grad():
        outputs = pupil(torch.from_numpy(by_pupil)).numpy()
    np.testing.assert_array_equal(np.concatenate(crawled[1]["commands"]), outputs[:, 1] > outputs[:, 0])
    assert crawled[0]["seed"] == crawled[1]["seed"] != 0


def test_a_round_is_so_many_steps_of_adam_on_the_cross_entropy():
    """Kingma, Ba (2015), by hand, of a network without hidden layers."""
    pupil = distil([SHUT, OPEN], hidden=(), rounds=2, holds=2, updates=3, seed=5)
    generator = np.random.default_rng(5)
    with torch.random.fork_rng():
        torch.manual_seed(5)
        network = torch.nn.Linear(9, 2)
    parameters = [each.detach().numpy().astype(np.float64) for each in network.parameters()]
    first, second = ([np.zeros_like(each) for each in parameters] for _ in range(2))
    seen, wanted = np.empty((0, 9)), np.empty(0, int)
    for k in range(2):
        with torch.no_grad():
            for own, value in zip(network.parameters(), parameters, strict=True):
                own.copy_(torch.from_numpy(value))
        states, answers = distilled._crawl([SHUT, OPEN], network if k else None, 2, generator)
        seen, wanted = np.concatenate([seen, states]), np.concatenate([wanted, answers])
        for step in range(3 * k + 1, 3 * k + 4):
            chosen = generator.integers(len(seen), size=1024)
            outputs = seen[chosen] @ parameters[0].T + parameters[1]
            surplus = np.exp(outputs) / np.exp(outputs).sum(axis=1, keepdims=True)
            surplus[np.arange(1024), wanted[chosen]] -= 1.0
            for i, gradient in enumerate((surplus.T @ seen[chosen] / 1024, surplus.mean(axis=0))):
                first[i] = 0.9 * first[i] + 0.1 * gradient
                second[i] = 0.999 * second[i] + 0.001 * gradient**2
                root = np.sqrt(second[i] / (1.0 - 0.999**step)) + 1e-8
                parameters[i] = parameters[i] - 3e-3 * first[i] / (1.0 - 0.9**step) / root
    for own, value in zip(pupil.layers[0], parameters, strict=True):
        np.testing.assert_allclose(own, value, rtol=0, atol=2e-6)
    told = {"name": "distillation", "seed": 5, "rounds": 2, "holds": 2, "updates": 3}
    assert {name: pupil.description["algorithm"][name] for name in told} == told
    assert pupil.description["network"] == {"sizes": [9, 2], "activation": "tanh", "outputs": "logits"}
    assert pupil.scores == {}


@pytest.mark.parametrize("name", ["rounds", "holds", "updates"])
def test_a_distillation_has_a_round_a_hold_and_an_update_at_least(name):
    with pytest.raises(ValueError, match=f"^{name} must be a whole number >= 1, got 0$"):
        distil([SHUT, OPEN], **{name: 0})
