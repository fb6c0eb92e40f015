"""Hyperparameters of the algorithms, a file each, in the form of rl-baselines3-zoo, and what reads them."""

from .reading import entropy_schedule, linear_schedule, read_hyperparameters, resolve

__all__ = ["entropy_schedule", "linear_schedule", "read_hyperparameters", "resolve"]
