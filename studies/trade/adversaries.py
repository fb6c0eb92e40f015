"""Policies that would live on the memory reward without memory, if it could be done.

The reward's score is of a readout that learns while it is scored, and a policy may know that: it may change its gait
when the readout has just settled, write past flips into the valve by its commands, or look ahead at what the readout is
going to earn. Beside each mean of the reward stands the capacity that a readout fitted afterwards, to all the other
samples of the same window, has of the same motion.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import known_names, whole_number
from ...envs import StickSlipCrawlerVectorEnv
from ...envs.settings import Settings
from ...reservoir import memory_capacity
from ...reservoir.bootstrap import Estimate, mean_over_runs
from ...tasks import crawler_states
from ...train.episodes import Act, long_episode
from .conditions import conditions, refuse_silence
from .judgement import held_out_seeds
from .open_loop import commands_of
from .rollouts import arguments_of, WASHOUT

__all__ = ["ADVERSARIES", "HONEST", "Adversary", "Audit", "audit", "earned_and_held"]

Bits = NDArray[np.int64]
Adversary = Callable[[StickSlipCrawlerVectorEnv], Act]
"""Takes the batch of environments that it is going to act in, and gives its joint action."""

_FAST = "11100111000"
# After so many holds, a multiple of its letters, a schedule begins again.
_PERIOD = 55_000


@dataclass(frozen=True, eq=False)
class Audit:
    """What n policies earned for memory, and what memory there was.

    Attributes
    ----------
    names : tuple of str
    earned : (n, m) array
        Mean memory reward of the window, on m seeds, had the flips in it the variance that they have on average. The
        reward is in units of that variance, a capacity in units of the window's own, and by how much they differ is
        chance that no policy has a hand in.
    capacities : (n, m) array
        Of the same motion in the same window, each sample predicted by a readout fitted to all the others.
    seeds : tuple of int
    holds : int
        Of the window, after `WASHOUT`.
    """

    names: tuple[str, ...]
    earned: NDArray[np.float64]
    capacities: NDArray[np.float64]
    seeds: tuple[int, ...]
    holds: int

    def excess(self, name: str) -> Estimate:
        """What one earned beyond the capacity, and its interval over the seeds."""
        i = self.names.index(name)
        return mean_over_runs(self.earned[i] - self.capacities[i], bounds=(-np.inf, np.inf))


def audit(
    adversaries: Mapping[str, Adversary] | None = None,
    *,
    seeds: int = 10,
    holds: int = 4000,
    threads: int | None = None,
    **env_kwargs: Any,
) -> Audit:
    """Compare what policies earn for memory with the memory there is.

    Parameters
    ----------
    adversaries : mapping of str to callable, optional
        By name; `HONEST` and `ADVERSARIES` by default.
    seeds : int, >= 1
        Held-out seeds.
    holds : int, >= 200
        Of the window.
    threads : int, optional
    **env_kwargs
        As for `conditions`; with dither.

    Returns
    -------
    Audit

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.
    """
    settings = conditions(**env_kwargs)
    refuse_silence(settings)
    known_names("target", [settings.target], ["memory"])
    whole_number("holds", holds, 200)
    tried = {**HONEST, **ADVERSARIES} if adversaries is None else adversaries
    held_out = held_out_seeds(seeds)
    both = np.array([earned_and_held(each, settings, held_out, holds, threads) for each in tried.values()])
    return Audit(tuple(tried), both[:, 0], both[:, 1], held_out, holds)


def earned_and_held(
    adversary: Adversary, settings: Settings, seeds: tuple[int, ...], holds: int, threads: int | None
) -> NDArray[np.float64]:
    """What a policy earned for memory, and what memory there was, on each seed.

    Parameters
    ----------
    adversary : callable
    settings : Settings
        See `conditions`.
    seeds : tuple of m int
        Of the flips.
    holds : int
        Of the window, after `WASHOUT` more.
    threads : int or None

    Returns
    -------
    (2, m) array
        Rows as `Audit.earned` and `Audit.capacities` have them.
    """
    environment = _environment(settings, len(seeds), threads)
    valves = np.empty((len(seeds), WASHOUT + holds), np.int64)
    earned, messages = np.empty(valves.shape), np.empty(valves.shape)
    for k, _, _, infos in long_episode(environment, adversary(environment), valves.shape[1], seed=seeds):
        valves[:, k], earned[:, k], messages[:, k] = infos["valve"], infos["memory"], infos["innovation"]
    held = [
        memory_capacity(
            crawler_states(
                valve,
                groups=settings.groups,
                scene=settings.scene,
                hold=settings.hold,
                virtual_nodes=settings.virtual_nodes,
                tolerance=settings.tolerance,
            ),
            message,
            settings.delays,
            washout=WASHOUT,
            scoring="leave one out",
        ).total
        for valve, message in zip(valves, messages, strict=True)
    ]
    variance = np.mean(messages[:, WASHOUT:] ** 2, axis=1) / settings.variance
    return np.stack([earned[:, WASHOUT:].mean(axis=1) / variance, held])


def _environment(settings: Settings, count: int, threads: int | None) -> StickSlipCrawlerVectorEnv:
    return StickSlipCrawlerVectorEnv(count, **arguments_of(settings), max_episode_steps=None, threads=threads)


def _schedule(name: str) -> Adversary:
    def adversary(environment: StickSlipCrawlerVectorEnv) -> Act:
        commands = commands_of([name], _PERIOD, 0)[0]
        return lambda k, _: np.full(environment.num_envs, commands[k % _PERIOD])

    return adversary


def _switching(first: str, second: str, block: int) -> Adversary:
    """One word for a block of holds, then another, and so on: the readout's weights are always those of the past."""

    def adversary(environment: StickSlipCrawlerVectorEnv) -> Act:
        words = [[int(letter) for letter in word] for word in (first, second)]

        def act(k: int, _: NDArray[np.float32]) -> Bits:
            word = words[k // block % 2]
            return np.full(environment.num_envs, word[k % len(word)])

        return act

    return adversary


def _relay(delay: int, word: str = "0") -> Adversary:
    """Write the flip of some holds ago into the valve, on top of a word."""

    def adversary(environment: StickSlipCrawlerVectorEnv) -> Act:
        asked: list[Bits] = []
        flips: list[Bits] = []

        def act(k: int, observations: NDArray[np.float32]) -> Bits:
            if k > 0:
                flips.append(asked[-1] ^ observations[:, 4].astype(np.int64))
            base = np.full(environment.num_envs, int(word[k % len(word)]))
            asked.append(base ^ flips[-delay] if len(flips) >= delay else base)
            return asked[-1]

        return act

    return adversary


def _looking(sign: float) -> Adversary:
    """Look one hold ahead, whether the valve flips or not, at what the readout is going to earn, or to lose."""

    def adversary(environment: StickSlipCrawlerVectorEnv) -> Act:
        settings, count = environment.settings, environment.num_envs
        dither = settings.dither
        branches = _environment(settings, 4 * count, None)
        flipping = {flip: next(s for s in range(10_000) if _flips(s, dither) is flip) for flip in (False, True)}
        seeds = [flipping[flip] for flip in (False, True, False, True)] * count
        commands = np.tile([0, 0, 1, 1], count)

        def act(_: int, __: NDArray[np.float32]) -> Bits:
            states = environment.get_state(generator=False)
            branches.set_state([state for state in states for _ in range(4)])
            branches.np_random = [np.random.default_rng(seed) for seed in seeds]
            earned = branches.step(commands)[4]["memory"].reshape(count, 2, 2) @ [1.0 - dither, dither]
            return np.argmax(sign * earned, axis=1)

        return act

    return adversary


def _flips(seed: int, dither: float) -> bool:
    return bool(np.random.default_rng(seed).random() < dither)


HONEST: dict[str, Adversary] = {
    "held open": _schedule("1"),
    "held shut": _schedule("0"),
    "fastest word": _schedule(_FAST),
    "random 50%": _schedule("random 50%"),
}
"""Policies that do not care for the readout, as a measure of the others."""

ADVERSARIES: dict[str, Adversary] = {
    **{f"open and shut in blocks of {block}": _switching("1", "0", block) for block in (10, 30, 100, 300)},
    "open and fast in blocks of 100": _switching("1", _FAST, 100),
    **{f"relay of the flip {delay} ago": _relay(delay) for delay in (1, 2, 5, 10, 20)},
    "relay of the flip 3 ago, on the fastest word": _relay(3, _FAST),
    "takes what the readout earns most by": _looking(1.0),
    "takes what the readout earns least by": _looking(-1.0),
}
"""Policies made to earn for memory without having it."""
