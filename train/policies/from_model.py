"""A trained model of Stable-Baselines3 as a policy of plain numbers."""

import platform
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
from gymnasium.spaces import flatdim

from ... import __version__
from ...common.extras import optional_import
from ...common.fingerprint import described
from ...envs import StickSlipCrawlerEnv
from ...envs.observation import OBSERVATION
from ..run import Configuration
from .description import described_space, FORMAT
from .policy import Layer, Policy

with optional_import():
    from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
    from sb3_contrib.qrdqn.policies import QRDQNPolicy
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.policies import ActorCriticPolicy
    from stable_baselines3.common.torch_layers import FlattenExtractor
    from stable_baselines3.dqn.policies import DQNPolicy
    from torch import nn

__all__ = ["policy_of"]

_ACTIVATIONS = {nn.Tanh: "tanh", nn.ReLU: "relu"}
_PACKAGES = ("gymnasium", "numpy", "torch", "stable_baselines3", "sb3_contrib")


def policy_of(
    model: BaseAlgorithm,
    configuration: Configuration,
    scores: Mapping[str, Any] | None = None,
) -> Policy:
    """The policy of a trained model.

    Parameters
    ----------
    model : BaseAlgorithm
        Of PPO, A2C, DQN or QR-DQN with an ``MlpPolicy``.
    configuration : Configuration
        What it was trained by.
    scores : mapping, optional
        What it came to, ready for JSON; `stickslip.train.scores.score` measures it.

    Returns
    -------
    Policy
        With weights of its own: a training that goes on does not change them. The quantiles of QR-DQN, whose mean
        decides, are averaged in the last layer.

    Raises
    ------
    ValueError
        If the policy is recurrent, or its network is not such a perceptron from the environment's observations.
    """
    environment = StickSlipCrawlerEnv(**configuration.env_kwargs)
    layers, activation, outputs = _network(model)
    sizes = [layers[0].weight.shape[1], *(len(layer.bias) for layer in layers)]
    seen = flatdim(environment.observation_space)
    if sizes[0] != seen:
        raise ValueError(f"model must take the {seen} numbers that the environment shows, it takes {sizes[0]}")
    description = {
        "format": FORMAT,
        "environment": configuration.environment,
        "env_kwargs": configuration.env_kwargs,
        "groups": environment.settings.groups.to_dict(),
        "observation_space": described_space(environment.observation_space) | {"names": _names(seen)},
        "action_space": described_space(environment.action_space),
        "conditioned": False,
        "network": {"sizes": sizes, "activation": activation, "outputs": outputs},
        "algorithm": {
            "name": configuration.algorithm,
            "hyperparameters": described(configuration.hyperparameters),
            "seed": configuration.seed,
            "start": configuration.start,
            "floor": configuration.floor,
            "steps": int(model.num_timesteps),
        },
        "versions": {
            "stickslip": __version__,
            "python": platform.python_version(),
            **{name: version(name) for name in _PACKAGES},
        },
        "scores": dict(scores or {}),
    }
    return Policy(layers, description)


def _names(count: int) -> list[str]:
    """What each number of an observation is; of the valve states, the newest first, how many holds ago it began."""
    body = [each.name for each in OBSERVATION]
    return body + [f"valve {age} holds ago" for age in range(1, count - len(body) + 1)]


def _network(model: BaseAlgorithm) -> tuple[list[Layer], str, str]:
    """Layers, activation, and what the outputs are."""
    policy = model.policy
    if isinstance(policy, RecurrentActorCriticPolicy):
        raise ValueError(
            f"model must have a policy without memory, got {type(policy).__name__}: a recurrent one is kept as "
            "Stable-Baselines3's zip alone"
        )
    if isinstance(policy, ActorCriticPolicy):
        extractor, modules = policy.pi_features_extractor, [*policy.mlp_extractor.policy_net, policy.action_net]
        outputs = "logits"
    elif isinstance(policy, DQNPolicy):
        extractor, modules, outputs = policy.q_net.features_extractor, [*policy.q_net.q_net], "action values"
    elif isinstance(policy, QRDQNPolicy):
        net = policy.quantile_net
        extractor, modules, outputs = net.features_extractor, [*net.quantile_net], "action values"
    else:
        raise ValueError(f"model must have an MlpPolicy of PPO, A2C, DQN or QR-DQN, got {type(policy).__name__}")
    if type(extractor) is not FlattenExtractor:
        raise ValueError(f"model must take its observations as they are, it has a {type(extractor).__name__}")
    affine, between = modules[::2], modules[1::2]
    kinds = {type(module) for module in between}
    if not all(isinstance(module, nn.Linear) for module in affine) or len(kinds - set(_ACTIVATIONS)) or len(kinds) > 1:
        names = [type(module).__name__ for module in modules]
        raise ValueError(f"model must be of linear layers with all Tanh or all ReLU between them, got {names}")
    layers = [Layer(_numbers(module.weight), _numbers(module.bias)) for module in affine]
    if isinstance(policy, QRDQNPolicy):
        layers[-1] = _averaged(layers[-1], policy.quantile_net.n_quantiles)
    return layers, _ACTIVATIONS[kinds.pop()] if kinds else "tanh", outputs


def _averaged(layer: Layer, quantiles: int) -> Layer:
    """Means of an affine map's outputs over quantiles, of which each has one output for each action."""
    weight = layer.weight.reshape(quantiles, -1, layer.weight.shape[1]).mean(axis=0, dtype=np.float64)
    bias = layer.bias.reshape(quantiles, -1).mean(axis=0, dtype=np.float64)
    return Layer(weight.astype(np.float32), bias.astype(np.float32))


def _numbers(parameter: Any) -> np.ndarray:
    return np.asarray(parameter.detach().cpu().numpy(), np.float32).copy()
