"""From an observation to the valve, whatever the policy is."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["acting", "other_groups", "trained_in"]

_NEARLY = 0.05  # relative: by so much a body is not known anyway


def acting(policy: Any) -> Callable[[NDArray[np.float32]], int]:
    """What a policy does, as a function to 0 or 1.

    Parameters
    ----------
    policy : Policy, model of Stable-Baselines3, or callable
        The first two have ``predict(observation, deterministic=True)``; a callable takes the observation.

    Raises
    ------
    TypeError, ValueError
        If it is none of these, or wants a weight of memory.
    """
    if getattr(policy, "conditioned", False) is True:
        raise ValueError(f"policy must take no weight of memory, got {policy!r}: choose one by policy.at(0.3)")
    predict = getattr(policy, "predict", None)
    if predict is None and not callable(policy):
        raise TypeError(f"policy must have a method predict, or be callable, got {policy!r}")

    def act(observation: NDArray[np.float32]) -> int:
        answer = policy(observation) if predict is None else predict(observation, deterministic=True)
        if isinstance(answer, tuple) and len(answer) == 2:
            answer, state = answer
            if state is not None:
                raise ValueError("policy must not be recurrent: give a function that keeps its state")
        value = np.asarray(answer)
        if value.size != 1 or value.item() not in (0, 1):
            raise ValueError(f"policy must act by 0 or 1, got {answer!r}")
        return int(value.item())

    return act


def trained_in(policy: Any) -> Mapping[str, Any]:
    """Arguments of the environment that a policy was trained in; none if it does not say."""
    told = getattr(policy, "env_kwargs", None)
    return told if isinstance(told, Mapping) else {}


def other_groups(policy: Any, groups: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Groups of the body that a policy was trained on, and those of this one, where they differ by more than 5%.

    Parameters
    ----------
    policy : Policy
        What was drawn in its training is left out.
    groups : mapping
        Of this body, by name.
    """
    drawn = trained_in(policy).get("randomize") or {}
    pairs = {name: (value, groups[name]) for name, value in policy.description["groups"].items() if name not in drawn}
    return {name: pair for name, pair in pairs.items() if abs(pair[1] - pair[0]) > _NEARLY * abs(pair[0])}
