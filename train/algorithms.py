"""The algorithms by name: all that is to be said of one here, besides its file of hyperparameters."""

from importlib import import_module
from typing import cast, TYPE_CHECKING

from ..common.extras import optional_import

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

__all__ = ["ALGORITHMS", "algorithm_class"]

ALGORITHMS = {
    "ppo": "stable_baselines3.PPO",
    "a2c": "stable_baselines3.A2C",
    "dqn": "stable_baselines3.DQN",
    "qrdqn": "sb3_contrib.QRDQN",
    "recurrent_ppo": "sb3_contrib.RecurrentPPO",
}
"""Where the class of each is, of Stable-Baselines3's kind; imported on first use, since torch takes seconds.

What else a run has to know the class says itself: an off-policy one has a buffer to keep. The policy stands in
``hyperparameters/<name>.yml`` beside everything that was tuned.
"""


def algorithm_class(name: str) -> "type[BaseAlgorithm]":
    """The class of an algorithm.

    Parameters
    ----------
    name : str
        One of :data:`ALGORITHMS`.

    Raises
    ------
    MissingExtra
        If what it needs is not installed.
    """
    module, _, kind = ALGORITHMS[name].rpartition(".")
    with optional_import():
        return cast("type[BaseAlgorithm]", getattr(import_module(module), kind))
