"""Policies whose weights are written by hand, so that what they do is known."""

import numpy as np

from stickslip.train.policies import Layer, Policy
from stickslip.train.policies.description import FORMAT


def policy_of_layers(layers, env_kwargs=None):
    """A policy of affine maps, each a pair of weight and bias, with tanh between them."""
    layers = [Layer(np.array(weight, np.float32), np.array(bias, np.float32)) for weight, bias in layers]
    sizes = [layers[0].weight.shape[1], *(len(layer.bias) for layer in layers)]
    description = {
        "format": FORMAT,
        "environment": "StickSlipCrawler-v0",
        "env_kwargs": env_kwargs or {},
        "groups": {},
        "observation_space": {"type": "Box", "shape": [sizes[0]]},
        "action_space": {"type": "Discrete", "n": 2},
        "conditioned": False,
        "network": {"sizes": sizes, "activation": "tanh", "outputs": "logits"},
        "algorithm": {"name": "ppo"},
        "versions": {},
        "scores": {},
    }
    return Policy(layers, description)


def negation(delay):
    """A policy that commands the opposite of what the valve was, so many holds ago."""
    opening = np.zeros(4 + delay)
    opening[-1] = -1.0
    return policy_of_layers([([0 * opening, opening], [0.0, 0.5])], {"dither": 0.1, "valve_history": delay})


def relay(position):
    """A policy that opens the valve where the deformation is below a position."""
    return policy_of_layers([([[0.0] * 5, [-1.0, 0.0, 0.0, 0.0, 0.0]], [0.0, position])], {"dither": 0.1})
