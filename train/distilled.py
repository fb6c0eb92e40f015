"""Several policies in one that takes the weight of memory: it does what the best of them does at each weight."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.extras import optional_import
from ..common.threads import library_threads
from ..common.validation import whole_number
from ..envs import StickSlipCrawlerVectorEnv
from .episodes import long_episode
from .imitation import CRAWLERS, fit, optimizer_of
from .policies.policy import Layer, Policy
from .scores import judging

with optional_import():
    import torch
    from torch import nn

__all__ = ["best_at", "distil"]

# At which the teachers are looked up that a description names: those that are the best nowhere have taught nothing.
_WEIGHTS_TOLD = 1001


def best_at(policies: Sequence[Policy], weight: NDArray[np.float64]) -> NDArray[np.int64]:
    """Which policy has most reward at a weight of memory, by what each scored.

    Parameters
    ----------
    policies : sequence of Policy
        Each with the means of ``"speed"`` and ``"memory"`` in its scores.
    weight : (n,) array, in [0, 1]

    Returns
    -------
    (n,) array of int
        Places in `policies`.
    """
    speed, memory = (np.array([each.scores[name]["mean"] for each in policies]) for name in ("speed", "memory"))
    return ((1.0 - weight)[:, None] * speed + weight[:, None] * memory).argmax(axis=1)


def distil(
    policies: Sequence[Policy],
    *,
    hidden: Sequence[int] = (64, 64),
    rounds: int = 5,
    holds: int = 300,
    updates: int = 600,
    seed: int = 0,
) -> Policy:
    """Teach one network to act as the best of several policies at each weight of memory.

    The pupil crawls, each body with a weight of its own, and learns what the best policy at that weight would have
    done in the states that it came to [1]_; in the first round the teachers crawl.

    Parameters
    ----------
    policies : sequence of Policy
        Of one environment but for its ``memory_weight``, none taking a weight, each with scores.
    hidden : sequence of int
        Widths of the hidden layers.
    rounds : int, >= 1
        In which bodies crawl and the network is fitted to all that was seen so far.
    holds : int, >= 1
        Steps of each of the 64 bodies in a round.
    updates : int, >= 1
        Gradient steps after each round.
    seed : int
        Of weights, flips and batches.

    Returns
    -------
    Policy
        That takes the weight. It has no scores yet; `stickslip.train.shipping.ship` measures it.

    Raises
    ------
    ValueError
        If the policies are of different environments.

    References
    ----------
    .. [1] Ross, Gordon, Bagnell (2011). A reduction of imitation learning and structured prediction to no-regret online
       learning (DAgger). Over several teachers: Rusu et al. (2016). Policy distillation.
    """
    arguments = [{**each.env_kwargs, "memory_weight": None} for each in policies]
    if any(each != arguments[0] for each in arguments):
        raise ValueError(f"policies must be of one environment but for memory_weight, got {arguments}")
    for name, value in {"rounds": rounds, "holds": holds, "updates": updates}.items():
        whole_number(name, value, 1)
    description = policies[0].description
    inputs = description["network"]["sizes"][0] + 1
    generator = np.random.default_rng(seed)
    seen, wanted = np.empty((0, inputs), np.float32), np.empty(0, np.int64)
    with library_threads(1), torch.random.fork_rng():
        torch.manual_seed(seed)
        network = _perceptron([inputs, *hidden, 2])
        optimizer = optimizer_of(network.parameters())
        for k in range(rounds):
            pupil = network if k else None
            states, answers = _crawl(policies, pupil, holds, generator)
            seen, wanted = np.concatenate([seen, states]), np.concatenate([wanted, answers])
            fit(network, optimizer, seen, wanted, updates, generator)
    del description["env_kwargs"]["memory_weight"]
    description |= {
        "conditioned": True,
        "network": {"sizes": [inputs, *hidden, 2], "activation": "tanh", "outputs": "logits"},
        "algorithm": {
            "name": "distillation",
            "seed": seed,
            "rounds": rounds,
            "holds": holds,
            "updates": updates,
            "teachers": [
                {"algorithm": policies[i].description["algorithm"], "scores": policies[i].scores}
                for i in np.unique(best_at(policies, np.linspace(0.0, 1.0, _WEIGHTS_TOLD))).tolist()
            ],
        },
        "scores": {},
    }
    return Policy(_layers(network), description)


def _perceptron(sizes: Sequence[int]) -> nn.Sequential:
    modules: list[nn.Module] = []
    for k, (a, b) in enumerate(pairwise(sizes)):
        modules += [nn.Tanh()] * (k > 0) + [nn.Linear(a, b)]
    return nn.Sequential(*modules)


def _layers(network: nn.Sequential) -> list[Layer]:
    affine = [module for module in network if isinstance(module, nn.Linear)]
    return [Layer(*(each.detach().numpy().copy() for each in (module.weight, module.bias))) for module in affine]


def _crawl(
    policies: Sequence[Policy], pupil: nn.Module | None, holds: int, generator: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """What is seen, the weight beside it, as the pupil crawls or else its teachers, and what these would do there."""
    weight = (generator.permutation(CRAWLERS) + generator.random(CRAWLERS)) / CRAWLERS
    # Half of them as above, half among the small weights, where the front bends.
    weight[::2] *= 0.5 * weight[::2]
    teacher = best_at(policies, weight)
    arguments: dict[str, Any] = judging(policies[0].env_kwargs)
    batch = StickSlipCrawlerVectorEnv(CRAWLERS, **arguments, max_episode_steps=None)
    states: list[NDArray[np.float32]] = []
    answers: list[NDArray[np.int64]] = []

    def act(_: int, observation: NDArray[np.float32]) -> NDArray[np.int64]:
        each = np.stack([policy.predict(observation) for policy in policies])
        states.append(np.column_stack([observation, weight]).astype(np.float32))
        answers.append(each[teacher, np.arange(CRAWLERS)])
        if pupil is None:
            return answers[-1]
        with torch.no_grad():
            commands: NDArray[np.int64] = pupil(torch.from_numpy(states[-1])).argmax(dim=1).numpy()
        return commands

    for _ in long_episode(batch, act, holds, seed=int(generator.integers(2**31))):
        pass
    return np.concatenate(states), np.concatenate(answers)
