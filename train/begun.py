"""A policy as the beginning of a training."""

from typing import Any, TYPE_CHECKING

from ..common.extras import optional_import
from .policies.policy import Policy

with optional_import():
    import torch
    from stable_baselines3.common.policies import ActorCriticPolicy

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

__all__ = ["begin_from"]

# What is left of the differences between logits: what was certain to one in ten thousand is so to one in sixteen.
_CERTAINTY = 0.3


def begin_from(model: "BaseAlgorithm", policy: Policy) -> None:
    """Have a model that has not learned yet act as a policy does, but less certainly, so that it tries what lies near.

    Parameters
    ----------
    model : BaseAlgorithm
        Of PPO or A2C, with a network as the policy's; changed in place.
    policy : Policy
        Whose outputs are logits.

    Raises
    ------
    ValueError
        If the networks differ.
    """
    network: Any = model.policy
    layers = (
        [*network.mlp_extractor.policy_net, network.action_net][::2] if isinstance(network, ActorCriticPolicy) else []
    )
    own = [tuple(layer.weight.shape) for layer in layers]
    if own != [layer.weight.shape for layer in policy.layers]:
        raise ValueError(f"policy to begin from must have layers of the shapes {own}, it is {policy!r}")
    with torch.no_grad():
        for layer, (weight, bias) in zip(layers, policy.layers, strict=True):
            layer.weight.copy_(torch.tensor(weight))
            layer.bias.copy_(torch.tensor(bias))
        layers[-1].weight.mul_(_CERTAINTY)
        layers[-1].bias.mul_(_CERTAINTY)
