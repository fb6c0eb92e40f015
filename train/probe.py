"""A small measurement by which a changed body or reward is told from the one that a file was made with."""

from collections.abc import Mapping
from typing import Any

from ..common.fingerprint import rounded
from ..envs import StickSlipCrawlerEnv

__all__ = ["first_rewards"]

_STEPS = 16


def first_rewards(env_kwargs: Mapping[str, Any]) -> list[float | str]:
    """What a fixed word earns in the first steps of an environment, rounded.

    Parameters
    ----------
    env_kwargs : mapping
        Arguments of the environment.

    Returns
    -------
    list
        As in `stickslip.common.fingerprint`.
    """
    environment = StickSlipCrawlerEnv(**env_kwargs)
    environment.reset(seed=0)
    return [rounded(float(environment.step((step // 3 + 1) % 2)[1])) for step in range(_STEPS)]
