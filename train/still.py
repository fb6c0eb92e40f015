"""A policy that holds its valve as it is told, whatever it sees."""

from typing import Any, TYPE_CHECKING

from ..common.extras import optional_import

with optional_import():
    import torch
    from torch import nn

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

__all__ = ["hold_still"]

# What an algorithm of Stable-Baselines3 calls the network whose last layer decides, in the order of asking.
_DECIDING = ("action_net", "q_net", "quantile_net")
_CERTAIN = 10.0


def hold_still(model: "BaseAlgorithm", command: int) -> None:
    """Have a model command the same for ever: its last layer forgets what it sees.

    Parameters
    ----------
    model : BaseAlgorithm
        With two actions; changed in place. What it learns from is left as it is.
    command : {0, 1}
        0 shuts the valve, 1 opens it.
    """
    policy: Any = model.policy
    network = next(getattr(policy, name) for name in _DECIDING if hasattr(policy, name))
    last = [layer for layer in network.modules() if isinstance(layer, nn.Linear)][-1]
    # The commands are the fastest index of its outputs: logits, values, or quantiles of these.
    preference = torch.tensor([_CERTAIN * (command == 0), _CERTAIN * (command == 1)])
    with torch.no_grad():
        last.weight.zero_()
        last.bias.copy_(preference.repeat(last.out_features // 2))
