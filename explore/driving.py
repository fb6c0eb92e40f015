"""What the valve of a setup does, hold by hold."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..envs import StickSlipCrawlerEnv
from ..train.evaluation import roll_out
from ..train.policies.policy import Policy
from ..train.policies.pretrained import pretrained
from ..train.schedules import repeat
from .setup import Setup

__all__ = ["SEED", "driven", "environment_kwargs", "policy_of", "takes_weight"]

SEED = 0
"""Of the flips."""


def driven(setup: Setup, holds: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """What is asked of the valve by a word or a policy, and what comes of it. Longer runs begin as shorter ones do.

    Parameters
    ----------
    setup : Setup
        That is not live.
    holds : int

    Returns
    -------
    command, valve : (holds,) arrays of 0 and 1
    """
    if setup.drive == "word":
        return repeat(setup.word, holds, dither=setup.dither, seed=SEED)
    environment = StickSlipCrawlerEnv(**environment_kwargs(setup), groups=setup.groups, scene=setup.scene)
    return roll_out(policy_of(setup), environment, holds, SEED)


def policy_of(setup: Setup) -> Policy:
    """The policy of a setup, at its weight if it takes one."""
    policy = _read(setup.policy)
    return policy.at(setup.weight) if policy.conditioned else policy


def takes_weight(policy: str) -> bool:
    """Whether a policy that is shipped was trained for any weight of memory."""
    return _read(policy).conditioned


def environment_kwargs(setup: Setup) -> dict[str, Any]:
    """Arguments of the environment in which a policy acts, but for groups and scene: what it sees is as it learned."""
    return {
        "hold": setup.hold,
        "tolerance": setup.tolerance,
        "dither": setup.dither,
        "memory_weight": 0.0,
        "valve_history": _read(setup.policy).env_kwargs.get("valve_history", 1),
    }


@lru_cache
def _read(name: str) -> Policy:
    return pretrained(name)
