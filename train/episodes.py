"""One long episode of a batch of crawlers, step by step."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..envs import StickSlipCrawlerVectorEnv

__all__ = ["Act", "Step", "long_episode"]

Act = Callable[[int, NDArray[np.float32]], NDArray[np.int64]]
"""Joint action of n crawlers: takes the step's number, from 0, and the observations (n, ...), and gives the commands
(n,) of 0 and 1."""


class Step(NamedTuple):
    """What a step of n crawlers was and came to; an environment that does not copy writes over it at the next."""

    number: int
    """From 0."""
    commands: NDArray[np.int64]
    """(n,), of 0 and 1."""
    rewards: NDArray[np.float64]
    """(n,)."""
    infos: dict[str, Any]
    """As the environment tells them."""


def long_episode(
    environments: StickSlipCrawlerVectorEnv, act: Act, steps: int, *, seed: int | Sequence[int]
) -> Iterator[Step]:
    """Let crawlers start from rest and act; the environments are closed at the end, however it comes.

    Parameters
    ----------
    environments : StickSlipCrawlerVectorEnv
        Without a time limit, which would cut the episode.
    act : callable
    steps : int
    seed : int or sequence of int
        Of the flips and the draws, as `reset` takes it.

    Yields
    ------
    Step
    """
    try:
        observations, _ = environments.reset(seed=seed if isinstance(seed, int) else list(seed))
        for k in range(steps):
            commands = act(k, observations)
            observations, rewards, _, _, infos = environments.step(commands)
            yield Step(k, commands, rewards, infos)
    finally:
        environments.close()
