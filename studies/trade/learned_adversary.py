"""A policy that is learned for what the memory reward pays beyond the memory there is.

Its reward is the excess itself, over a whole window, which no step tells: linear policies, which see more than any
policy of the environment does, are searched by the cross-entropy method [1]_.

References
----------
.. [1] Rubinstein (1999). The cross-entropy method for combinatorial and continuous optimization. For policies: Mannor,
   Rubinstein, Gat (2003). The cross-entropy method for fast policy search.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import whole_number
from ...envs import StickSlipCrawlerVectorEnv
from ...envs.settings import Settings
from ...train.episodes import Act
from .adversaries import Adversary, earned_and_held
from .conditions import conditions, refuse_silence

__all__ = ["inputs", "learned_adversary", "linear"]

_OBSERVED = 5
# The best share of a generation makes the next one, beside as much of the last.
_ELITE, _KEPT = 0.25, 0.3


def inputs(settings: Settings) -> int:
    """How many numbers a policy sees: a 1, the flips that the readout is asked for, the body, the readout's states."""
    return 1 + settings.delays + _OBSERVED + 3 * settings.virtual_nodes


def linear(weights: NDArray[np.float64]) -> Adversary:
    """Policies that open the valve where a weighted sum of what they see is positive.

    Parameters
    ----------
    weights : (n, d) array
        Of n policies, as many as there are environments or a divisor of it: those of one policy are side by side. The
        d are those of `inputs`.

    Returns
    -------
    Adversary
    """

    def adversary(environment: StickSlipCrawlerVectorEnv) -> Act:
        count, delays = environment.num_envs, environment.settings.delays
        own = np.repeat(weights, count // len(weights), axis=0)
        flips = np.zeros((count, delays))
        asked = np.zeros(count, np.int64)

        def act(k: int, observations: NDArray[np.float32]) -> NDArray[np.int64]:
            if k > 0:
                flips[:, 1:] = flips[:, :-1].copy()
                flips[:, 0] = (asked ^ observations[:, 4].astype(np.int64)) - environment.settings.dither
            body = observations[:, :_OBSERVED].astype(np.float64)
            seen = np.column_stack([np.ones(count), flips, body, environment.readout_states()])
            asked[:] = (seen * own).sum(axis=1) > 0.0
            return asked

        return act

    return adversary


def learned_adversary(
    *,
    generations: int = 20,
    policies: int = 16,
    seeds: int = 1,
    holds: int = 2500,
    seed: int = 0,
    threads: int | None = None,
    **env_kwargs: Any,
) -> Adversary:
    """Learn a policy that earns as much as it can beyond the capacity of the same window.

    Parameters
    ----------
    generations, policies : int, >= 1
        So many times so many policies are tried.
    seeds : int, >= 1
        Of the flips on which each is tried, others in each generation.
    holds : int, >= 200
        Of the window.
    seed : int
        Of the search.
    threads : int, optional
    **env_kwargs
        As for `stickslip.studies.trade.adversaries.audit`, which judges it on seeds that it has not seen.

    Returns
    -------
    Adversary

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.
    """
    settings = conditions(**env_kwargs)
    refuse_silence(settings)
    for name, value, least in (
        ("generations", generations, 1),
        ("policies", policies, 1),
        ("seeds", seeds, 1),
        ("holds", holds, 200),
    ):
        whole_number(name, value, least)
    generator = np.random.default_rng(seed)
    size = inputs(settings)
    mean, deviation = np.zeros(size), np.ones(size)
    best = max(1, round(_ELITE * policies))
    for _ in range(generations):
        tried = mean + deviation * generator.standard_normal((policies, size))
        flips = tuple(generator.integers(1_000_000, size=seeds).tolist())
        earned, held = earned_and_held(linear(tried), settings, flips * policies, holds, threads)
        excess = (earned - held).reshape(policies, seeds).mean(axis=1)
        elite = tried[np.argsort(-excess)[:best]]
        mean = _KEPT * mean + (1.0 - _KEPT) * elite.mean(axis=0)
        deviation = _KEPT * deviation + (1.0 - _KEPT) * elite.std(axis=0)
    return linear(mean[np.newaxis])
