"""What the policies of a front have learned: those of the knee and of most speed, looked at closely."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .conditions import conditions
from .front import Front, Point
from .judgement import held_out_seeds, judge
from .portrait import Imitation, imitation, Portrait, portrait, response
from .registers import register_runs
from .running import TradeFolder

__all__ = ["Learned", "learned"]

_BITS = range(7)
# A register of fewer bits is taken for as good where it agrees to this share.
_AS_GOOD = 0.005


@dataclass(frozen=True, eq=False)
class Learned:
    """Policies looked at, by what they are called.

    Attributes
    ----------
    portraits, responses, imitations : mapping
        As in `stickslip.studies.trade.portrait`: the answers to one flip by the holds since, and the registers by bits.
    registers : mapping of str to (int, Point)
        The register of fewest bits that imitates each as well as any, judged by itself.
    """

    portraits: Mapping[str, Portrait]
    responses: Mapping[str, NDArray[np.float64]]
    imitations: Mapping[str, Mapping[int, Imitation]]
    registers: Mapping[str, tuple[int, Point]]


def learned(folder: TradeFolder, front: Front) -> Learned | None:
    """Look at the policies of a front's knee and of its most speed.

    Parameters
    ----------
    folder : TradeFolder
        That holds them.
    front : Front
        With a dither above 0.

    Returns
    -------
    Learned or None
        None where the front has no policy. A front without a knee is told by its fastest alone.
    """
    chosen = {name: point for name, point in (("knee", front.knee), ("fastest", front.fastest)) if point is not None}
    if not chosen:
        return None
    cells = [cell for stage in folder.trade.cells() for cell in stage]
    policies = {
        name: folder.policy(next(cell for cell in cells if cell.name == point.name)) for name, point in chosen.items()
    }
    portraits = {name: portrait(policies[name], point.weight) for name, point in chosen.items()}
    imitations = {name: {bits: imitation(each, bits) for bits in _BITS} for name, each in portraits.items()}
    registers = {}
    settings = conditions(**{**folder.trade.env_kwargs, "dither": front.dither})
    for name, found in imitations.items():
        best = max(each.agreement for each in found.values())
        bits = next(bits for bits, each in found.items() if each.agreement >= best - _AS_GOOD)
        table = found[bits].table
        judged = judge(
            ["".join(map(str, table))],
            lambda seed, table=table: register_runs([table], front.dither, folder.trade.holds, seed),  # type: ignore[misc]
            settings,
            seeds=held_out_seeds(folder.trade.judges),
        )
        registers[name] = bits, Point("register", judged.names[0], None, None, judged.speeds[0], judged.memories[0])
    responses = {name: response(policies[name], point.weight) for name, point in chosen.items()}
    return Learned(portraits, responses, imitations, registers)
