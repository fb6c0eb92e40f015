"""Policies and valve words over runs much longer than an episode, on seeds that no training has seen."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..envs import StickSlipCrawlerVectorEnv
from .episodes import Act, long_episode
from .evaluation import Acting, actor

__all__ = ["LongRuns", "of_policy", "of_words"]


class LongRuns(NamedTuple):
    """Means over the steps of each run, one run a seed; a body is judged once it is under way."""

    speed: NDArray[np.float64]
    """(runs,), z_c / t_c."""
    memory: NDArray[np.float64]
    """(runs,), what the readout earned a step."""
    reward: NDArray[np.float64]
    """(runs,)."""


def of_policy(
    policy: Acting, env_kwargs: Mapping[str, Any], *, seeds: Sequence[int], steps: int, burn_in: int
) -> LongRuns:
    """Let a policy act, deterministically, on each seed.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
    env_kwargs : mapping
        Arguments of the environment.
    seeds : sequence of int
        Of the flips and the draws, a run each.
    steps : int, >= 1
        Of each run that count.
    burn_in : int, >= 0
        Steps before them, in which the body gets under way and the readout learns.

    Returns
    -------
    LongRuns
        Of as many runs as seeds.
    """
    act = actor(policy, len(seeds))
    return _run(lambda _, observations: act(observations), env_kwargs, seeds, steps, burn_in)


def of_words(
    words: Sequence[str], env_kwargs: Mapping[str, Any], *, seeds: Sequence[int], steps: int, burn_in: int
) -> list[LongRuns]:
    """Repeat each word such as "11100" on each seed.

    Parameters
    ----------
    words : sequence of str
        Of 0 and 1, none empty.
    env_kwargs, seeds, steps, burn_in
        As for `of_policy`.

    Returns
    -------
    list of LongRuns
        One a word. The runs of all words and of a policy on one seed have the same flips and the same body.
    """
    lengths = np.repeat([len(word) for word in words], len(seeds))
    letters = np.zeros((len(words), max(map(len, words))), np.int64)
    for row, word in zip(letters, words, strict=True):
        row[: len(word)] = [int(letter) for letter in word]
    letters = np.repeat(letters, len(seeds), axis=0)
    of_each = np.arange(len(letters))

    def act(step: int, _: NDArray[np.float32]) -> NDArray[np.int64]:
        commands: NDArray[np.int64] = letters[of_each, step % lengths]
        return commands

    all_runs = _run(act, env_kwargs, list(seeds) * len(words), steps, burn_in)
    rows = np.array(all_runs).reshape(3, len(words), len(seeds))
    return [LongRuns(*rows[:, i]) for i in range(len(words))]


def _run(act: Act, env_kwargs: Mapping[str, Any], seeds: Sequence[int], steps: int, burn_in: int) -> LongRuns:
    environments = StickSlipCrawlerVectorEnv(len(seeds), **env_kwargs, max_episode_steps=None, copy=False)
    sums = np.zeros((3, len(seeds)))
    for k, _, rewards, infos in long_episode(environments, act, burn_in + steps, seed=seeds):
        if k >= burn_in:
            sums += infos["speed"], infos["memory"], rewards
    return LongRuns(*(sums / steps))
