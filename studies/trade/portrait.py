"""What a policy has learned, in numbers: its schedule, what it answers to a flip, and the register that imitates it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...envs import StickSlipCrawlerVectorEnv
from ...train.episodes import long_episode
from ...train.policies import Policy

__all__ = ["Imitation", "Portrait", "imitation", "portrait", "response"]

Bits = NDArray[np.int64]

_BURN_IN = 200
_LAGS = 24
_MOST_BITS = 8


@dataclass(frozen=True, eq=False)
class Portrait:
    """A policy at work, each array's first axis the n runs and the second the holds.

    Attributes
    ----------
    observations : (n, holds, k) array
        What it saw before each command.
    commands, valves : (n, holds) arrays of 0 and 1
        What it asked for, and what came of it.
    """

    policy: Policy
    weight: float | None
    observations: NDArray[np.float32]
    commands: Bits
    valves: Bits


@dataclass(frozen=True, eq=False)
class Imitation:
    """The register of some bits that commands most often as a policy does.

    Attributes
    ----------
    table : (2^bits,) array of 0 and 1
        Command after each past, the newest valve state its lowest bit.
    agreement : float
        Share of the commands that are the same, on runs that the table was not made of.
    """

    table: Bits
    agreement: float


def portrait(
    policy: Policy, weight: float | None = None, *, holds: int = 2000, seeds: Sequence[int] = range(8)
) -> Portrait:
    """Watch a policy at work, once its start is forgotten.

    Parameters
    ----------
    policy : Policy
    weight : float, optional
        Of memory, for a policy that takes it.
    holds : int
        Of each run.
    seeds : sequence of n int
        Of the flips.

    Returns
    -------
    Portrait
    """
    environment, chosen = _environment(policy, len(seeds)), _weight(policy, weight)
    size = environment.single_observation_space.shape or (0,)
    observations = np.empty((len(seeds), holds, *size), np.float32)
    commands, valves = np.empty((2, len(seeds), holds), np.int64)

    def act(k: int, seen: NDArray[np.float32]) -> Bits:
        if k >= _BURN_IN:
            observations[:, k - _BURN_IN] = seen
        return policy.predict(seen, chosen)

    for k, asked, _, infos in long_episode(environment, act, _BURN_IN + holds, seed=seeds):
        if k >= _BURN_IN:
            commands[:, k - _BURN_IN], valves[:, k - _BURN_IN] = asked, infos["valve"]
    return Portrait(policy, weight, observations, commands, valves)


def response(policy: Policy, weight: float | None = None, *, pairs: int = 256, seed: int = 0) -> NDArray[np.float64]:
    """How often a policy commands otherwise for one flip of the valve, by the holds since.

    Parameters
    ----------
    policy : Policy
    weight : float, optional
        Of memory, for a policy that takes it.
    pairs : int
        Of crawlers whose flips are the same but for one.
    seed : int
        Of the flips.

    Returns
    -------
    (lags,) array of float
        Share of pairs that differ in their command so many holds after the flip; 0 at lag 0, of the flip itself.
    """
    environment, chosen = _environment(policy, 2 * pairs), _weight(policy, weight)
    differ = np.zeros(_LAGS)

    def act(k: int, seen: NDArray[np.float32]) -> Bits:
        asked = np.array(policy.predict(seen, chosen))
        lag = k - _BURN_IN
        if lag >= 0:
            differ[lag] = np.mean(asked[::2] != asked[1::2])
        if lag == 0:
            asked[1::2] ^= 1
        return asked

    for _ in long_episode(environment, act, _BURN_IN + _LAGS, seed=[seed + k // 2 for k in range(2 * pairs)]):
        pass
    return differ


def imitation(of: Portrait, bits: int) -> Imitation:
    """The register that does most often as a policy does: after each past, what the policy commands most often.

    Parameters
    ----------
    of : Portrait
        Half of its runs make the table, the others judge it.
    bits : int, in [0, 8]
        Past valve states that the register sees.

    Returns
    -------
    Imitation

    Raises
    ------
    ValueError
        If `bits` is out of range, or there is one run alone.
    """
    if not 0 <= bits <= _MOST_BITS:
        raise ValueError(f"bits must be in [0, {_MOST_BITS}], got {bits}")
    runs = len(of.commands)
    if runs < 2:
        raise ValueError(f"portrait must have two runs at least, got {runs}")
    past = np.zeros((runs, of.valves.shape[1] - bits), np.int64)
    for age in range(bits):
        past |= of.valves[:, bits - 1 - age : of.valves.shape[1] - 1 - age] << age
    asked = of.commands[:, bits:]
    making = slice(0, runs // 2)
    votes = np.bincount(past[making].ravel(), weights=2 * asked[making].ravel() - 1, minlength=2**bits)
    table = (votes > 0).astype(np.int64)
    judging = slice(runs // 2, None)
    return Imitation(table, float(np.mean(table[past[judging]] == asked[judging])))


def _environment(policy: Policy, count: int) -> StickSlipCrawlerVectorEnv:
    return StickSlipCrawlerVectorEnv(
        count, **{**policy.env_kwargs, "memory_weight": 0.0}, max_episode_steps=None, copy=False, threads=1
    )


def _weight(policy: Policy, weight: float | None) -> float | None:
    return weight if policy.conditioned else None
