"""What lies between the held-open corner and the knee, and why so little does.

Without flips a register comes to rest, its valve held for ever, or walks, its valve in a cycle. What rests moves by
its answers to flips alone, and flips are rare; what walks forgets the phase of its gait more slowly than flips disturb
it, and its strokes are noise to a readout that does not see the command. And who walks for a while and rests for a
while, by a clock of its own, shows a linear readout two bodies at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.validation import whole_number
from ...envs.settings import Settings
from .judgement import held_out_seeds, judge, Judgement, Runs
from .registers import acting, feedback_runs, register_runs, Registers, tables_of
from .rollouts import roll_out_many

__all__ = ["KINDS", "Gap", "gap", "kinds_of", "mixed_runs"]

Bits = NDArray[np.int64]

KINDS = ("rests", "walks", "either")
"""What a register does without flips: "either" where that depends on its first valve states."""

# Of each kind and floor so many run again, so much longer, before the best is judged.
_AGAIN, _HOLDS = 40, 4000
_SEED = 30_000_000


@dataclass(frozen=True, eq=False)
class Gap:
    """The most memory that registers of each kind have at floors on speed.

    Attributes
    ----------
    floors : tuple of f floats
    chosen : mapping of str to tuple of f str or None
        Of each of `KINDS`, the table with the most memory among those at least as fast; None where none is.
    judgement : Judgement
        Of all that are chosen, on held-out seeds.
    """

    floors: tuple[float, ...]
    chosen: dict[str, tuple[str | None, ...]]
    judgement: Judgement


def kinds_of(tables: Bits) -> NDArray[np.int64]:
    """What registers do without flips, as places in `KINDS`.

    Parameters
    ----------
    tables : (n, 2^bits) array of 0 and 1

    Returns
    -------
    (n,) array
    """
    count, entries = tables.shape
    rows = np.arange(count)
    walks = np.zeros((entries, count), np.bool_)
    for first in range(entries):
        past = np.full(count, first)
        for _ in range(entries):  # by then it is in its cycle
            past = (2 * past + tables[rows, past]) % entries
        # At rest all past valve states are alike.
        walks[first] = (past != 0) & (past != entries - 1)
        for still in (0, entries - 1):
            walks[first] |= (past == still) & (tables[:, still] != still % 2)
    return np.where(~walks.any(axis=0), 0, np.where(walks.all(axis=0), 1, 2))


def gap(
    registers: Registers,
    floors: Sequence[float] = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7),
    *,
    seeds: int = 10,
    holds: int = 10_000,
    threads: int | None = None,
) -> Gap:
    """Find the most memory of registers that rest, walk or do either, at floors on speed.

    Parameters
    ----------
    registers : Registers
        All of some bits, as `best_registers` scored them.
    floors : sequence of float
    seeds, holds, threads
        As in `open_loop_front`.

    Returns
    -------
    Gap
    """
    held_out = held_out_seeds(seeds)
    whole_number("holds", holds, 1000)
    tables = tables_of(registers.bits)
    kinds = kinds_of(tables)
    among: dict[tuple[int, float], Bits] = {}
    for kind in range(len(KINDS)):
        for floor in floors:
            fast = np.flatnonzero((kinds == kind) & (registers.speeds >= floor))
            among[kind, floor] = fast[np.argsort(-registers.memories[fast])[:_AGAIN]]
    again = np.unique(np.concatenate(list(among.values())))
    found = roll_out_many(
        lambda part: acting(tables[again[part]]),
        len(again),
        _HOLDS,
        registers.settings,
        seed=_SEED,
        threads=threads,
    )
    chosen: dict[str, list[str | None]] = {kind: [] for kind in KINDS}
    for (kind, floor), some in among.items():
        place = np.searchsorted(again, some)
        fast = place[found.speeds[place] >= floor]
        best = None if len(fast) == 0 else again[fast[np.argmax(found.memories[fast])]]
        chosen[KINDS[kind]].append(None if best is None else "".join(map(str, tables[best].tolist())))
    names = sorted({name for each in chosen.values() for name in each if name is not None})
    rows = np.array([[int(letter) for letter in name] for name in names])
    judgement = judge(
        names,
        lambda seed: register_runs(rows, registers.settings.dither, holds, seed),
        registers.settings,
        seeds=held_out,
    )
    return Gap(tuple(floors), {kind: tuple(each) for kind, each in chosen.items()}, judgement)


def mixed_runs(first: str, second: str, blocks: Sequence[int], settings: Settings, holds: int) -> Runs:
    """Runs of controllers that are one register for a block of holds, then another, and so on.

    Parameters
    ----------
    first, second : str
        Tables of registers of the same bits.
    blocks : sequence of n int
        Holds of a block of each controller.
    settings : Settings
    holds : int

    Returns
    -------
    callable
        As for `judge`.
    """
    tables = np.array([[int(letter) for letter in table] for table in (first, second)])
    lengths = np.array([whole_number("blocks", block, 1) for block in blocks])
    shape = len(lengths), tables.shape[1]
    return lambda seed: feedback_runs(
        lambda k, past: tables[k // lengths % 2, past], shape, settings.dither, holds, seed
    )
