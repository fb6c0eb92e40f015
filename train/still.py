"""Policies that hold their valve: one that does so whatever it sees, and one that begins to learn from there."""

from typing import Any, TYPE_CHECKING

from ..common.extras import optional_import

with optional_import():
    import torch
    from torch import nn

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

__all__ = ["begin_still", "hold_still"]

# What an algorithm of Stable-Baselines3 calls the network whose last layer decides, in the order of asking.
_DECIDING = ("action_net", "q_net", "quantile_net")
_CERTAIN = 10.0
# Of outputs that are logits: one command in thirteen is another.
_INCLINED = 2.5


def hold_still(model: "BaseAlgorithm", command: int) -> None:
    """Have a model command the same for ever: its last layer forgets what it sees.

    Parameters
    ----------
    model : BaseAlgorithm
        With two actions; changed in place. What it learns from is left as it is.
    command : {0, 1}
        0 shuts the valve, 1 opens it.
    """
    last = _last_layer(model)
    with torch.no_grad():
        last.weight.zero_()
        last.bias.copy_(_preferring(command, _CERTAIN, last))


def begin_still(model: "BaseAlgorithm", command: int) -> None:
    """Have a model that has not learned yet hold its valve mostly.

    From chances that are even a policy learns to walk, and does not come back to rest, where memory is.

    Parameters
    ----------
    model : BaseAlgorithm
        With two actions; changed in place.
    command : {0, 1}
        0 shuts the valve, 1 opens it.
    """
    last = _last_layer(model)
    with torch.no_grad():
        last.bias.add_(_preferring(command, _INCLINED, last))


def _last_layer(model: "BaseAlgorithm") -> nn.Linear:
    policy: Any = model.policy
    network = next(getattr(policy, name) for name in _DECIDING if hasattr(policy, name))
    return [layer for layer in network.modules() if isinstance(layer, nn.Linear)][-1]


def _preferring(command: int, strength: float, layer: nn.Linear) -> torch.Tensor:
    """Biases; the commands are the fastest index of a layer's outputs: logits, values, or quantiles of these."""
    return torch.tensor([strength * (command == 0), strength * (command == 1)]).repeat(layer.out_features // 2)
