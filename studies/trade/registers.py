"""The simplest closed loop: the command is a table of the last few valve states.

A valve state is the command, flipped now and then, and the body does not feed back: what registers do is found without
moving it. The past valve states are the bits of one number, the newest the lowest, and the table has a bit for each.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import whole_number
from ...envs.observation import OBSERVATION
from ...envs.settings import Settings
from ...reservoir.bootstrap import Estimate
from ...train.begun import Teacher
from ...train.episodes import Act
from .conditions import conditions
from .judgement import held_out_seeds, judge, Judgement
from .selection import select

__all__ = ["Registers", "Simple", "best_registers", "feedback_runs", "register_runs", "simple_registers", "tables_of"]

Bits = NDArray[np.int64]

_MOST_BITS = 4
_SIMPLE = 3
_SCREENING = 400


@dataclass(frozen=True, eq=False)
class Registers:
    """All registers of some bits under one set of conditions.

    Attributes
    ----------
    settings : Settings
        The conditions.
    bits : int
        Past valve states that they see.
    speeds, memories : (n,) arrays
        What each came to in the longest run that it was tried in, n = 2^(2^bits): noisy, and the best of them lucky.
        Register i has for its table the bits of i, its command after past j being bit j.
    front : Judgement
        Of those chosen, on held-out seeds, by falling speed; their names are their tables, the command after past 0
        first.
    hypervolume : Estimate
        Of `front`, from (0, 0).
    """

    settings: Settings
    bits: int
    speeds: NDArray[np.float64]
    memories: NDArray[np.float64]
    front: Judgement
    hypervolume: Estimate


def best_registers(
    bits: int = 4,
    *,
    seeds: int = 10,
    holds: int = 10_000,
    screening_holds: int = _SCREENING,
    seed: int = 0,
    threads: int | None = None,
    **env_kwargs: Any,
) -> Registers:
    """Try every register of some bits, choose the front, and judge it afresh.

    Those of fewer bits are among them: their tables do not depend on the older states.

    Parameters
    ----------
    bits : int, 1 to 4
        There are 65,536 registers of 4 bits.
    seeds, holds, seed, threads
        As in `open_loop_front`.
    screening_holds : int, >= 200
        Of the first runs that choose; in the last there are 64 times as many.
    **env_kwargs
        As for `conditions`.

    Returns
    -------
    Registers

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.
    """
    settings = conditions(**env_kwargs)
    whole_number("bits", bits, 1, _MOST_BITS)
    whole_number("screening_holds", screening_holds, 200)
    whole_number("holds", holds, 1000)
    whole_number("seed", seed, 0)
    held_out = held_out_seeds(seeds)
    tables = tables_of(bits)

    def controllers(some: Bits, _: int) -> Act:
        return acting(tables[some])

    found = select(controllers, len(tables), screening_holds, settings, seed=seed, threads=threads)
    chosen = tables[found.front]
    names = ["".join(map(str, table)) for table in chosen.tolist()]
    front = judge(
        names, lambda held_out: register_runs(chosen, settings.dither, holds, held_out), settings, seeds=held_out
    )
    return Registers(settings, bits, found.speeds, found.memories, front, front.hypervolume())


@dataclass(frozen=True, eq=False)
class Simple:
    """The front of the simplest registers, as what a training can begin with.

    Attributes
    ----------
    tables : (n, 2^bits) array of 0 and 1
    speeds, memories : (n,) arrays
        What each came to in the runs that chose it.
    """

    tables: Bits
    speeds: NDArray[np.float64]
    memories: NDArray[np.float64]

    def above(self, floor: float) -> Teacher:
        """What the register with the most memory above a floor does, or the fastest if none is above.

        Parameters
        ----------
        floor : float
            On speed, z_c / t_c.

        Returns
        -------
        callable
            From observations (n, d) to commands (n,).
        """
        fast = self.speeds >= floor
        chosen = np.where(fast, self.memories, -np.inf) if fast.any() else self.speeds
        table = self.tables[chosen.argmax()]
        ages = np.arange(len(table).bit_length() - 1)

        def command(observations: NDArray[np.float32]) -> Bits:
            return table[observations[:, len(OBSERVATION) + ages].astype(np.int64) @ 2**ages]

        return command


def simple_registers(env_kwargs: Mapping[str, Any]) -> Simple:
    """Find the front of the registers of three valve states, or of as many as are shown if these are fewer.

    Parameters
    ----------
    env_kwargs : mapping
        Of the environment.

    Returns
    -------
    Simple
    """
    settings = conditions(**{name: value for name, value in env_kwargs.items() if name != "memory_weight"})
    tables = tables_of(min(_SIMPLE, settings.valve_history))
    found = select(lambda some, _: acting(tables[some]), len(tables), _SCREENING, settings, threads=1)
    return Simple(tables[found.front], found.speeds[found.front], found.memories[found.front])


def tables_of(bits: int) -> Bits:
    """All tables of so many bits of the past, shape (2^(2^bits), 2^bits)."""
    entries = 2**bits
    return np.arange(2**entries)[:, np.newaxis] >> np.arange(entries) & 1


def acting(tables: Bits) -> Act:
    """Joint action of registers in a batch of environments, one each; all past valve states are 0 at first."""
    count, entries = tables.shape
    flat = np.ascontiguousarray(tables).ravel()
    offset, past = np.arange(count) * entries, np.zeros(count, np.int64)

    def act(k: int, observations: NDArray[np.float32]) -> Bits:
        if k > 0:
            past[:] = (2 * past + observations[:, 4].astype(np.int64)) % entries
        return flat[offset + past]

    return act


def register_runs(tables: Bits | Sequence[Sequence[int]], dither: float, holds: int, seed: int) -> tuple[Bits, Bits]:
    """What registers command, and what the valves do, all with the same flips.

    Parameters
    ----------
    tables : (n, 2^bits) array of 0 and 1
    dither : float
    holds : int
    seed : int
        Of the flips.

    Returns
    -------
    commands, valves : (n, holds) arrays of 0 and 1
    """
    tables = np.asarray(tables, np.int64)
    rows = np.arange(len(tables))
    return feedback_runs(lambda _, past: tables[rows, past], tables.shape, dither, holds, seed)


def feedback_runs(
    command: Callable[[int, Bits], Bits], shape: tuple[int, ...], dither: float, holds: int, seed: int
) -> tuple[Bits, Bits]:
    """What feedback of the last valve states commands, and what the valves do, all with the same flips.

    Parameters
    ----------
    command : callable
        Takes the hold's number and the past valve states (n,), and gives the commands (n,).
    shape : (int, int)
        Of n controllers, and as many pasts as each tells apart.
    dither : float
    holds : int
    seed : int
        Of the flips.

    Returns
    -------
    commands, valves : (n, holds) arrays of 0 and 1
    """
    count, pasts = shape
    flips = np.random.default_rng(seed).random(holds) < dither
    commands, valves = np.empty((2, holds, count), np.int64)
    past = np.zeros(count, np.int64)
    for k in range(holds):
        commands[k] = command(k, past)
        valves[k] = commands[k] ^ flips[k]
        past = (2 * past + valves[k]) % pasts
    return commands.T.copy(), valves.T.copy()
