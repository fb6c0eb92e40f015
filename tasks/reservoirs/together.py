"""Bodies that are to be driven several times move as one batch, each to the bit as by a call of its own."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...crawler import simulate, SolverError
from ...crawler.model.tube import is_chain
from ..encodings import encode
from .body import BodyReservoir
from .reservoir import Reservoir

__all__ = ["Remembering", "drive_together", "states_of_each"]

# Samples of a batch, of which each takes 40 bytes.
_MOST_SAMPLES = 4_000_000


def states_of_each(bodies: Sequence[BodyReservoir], series: Sequence[ArrayLike]) -> list[NDArray[np.float64]]:
    """What each of several bodies gives when it is called with its series.

    Parameters
    ----------
    bodies : sequence of BodyReservoir
    series : sequence of array_like
        One a body.

    Returns
    -------
    list of ndarray of shape (samples, features)

    Raises
    ------
    ValueError, SolverError
        As a call of one of them would.
    """
    valves = [encode(each, body.encoding, body.holds_per_sample) for body, each in zip(bodies, series, strict=True)]
    alike: dict[Any, list[int]] = {}
    for i, (body, valve) in enumerate(zip(bodies, valves, strict=True)):
        scene = is_chain(body.scene), body.scene.segments
        read = body.virtual_nodes, body.holds_per_sample, body.readings
        alike.setdefault((len(valve), valve.dtype, *scene, *read, body.tolerance), []).append(i)
    states: dict[int, NDArray[np.float64]] = {}
    for rows in alike.values():
        one = bodies[rows[0]]
        most = max(1, _MOST_SAMPLES // (len(valves[rows[0]]) * one.samples_per_hold))
        for first in range(0, len(rows), most):
            some = rows[first : first + most]
            motion = simulate(
                [bodies[i].groups for i in some],
                [valves[i] for i in some],
                [bodies[i].hold for i in some],
                scene=[bodies[i].scene for i in some],
                tolerance=one.tolerance,
                samples_per_hold=one.samples_per_hold,
            )
            states.update(zip(some, one.read(motion), strict=True))
    return [states[i] for i in range(len(bodies))]


class Remembering:
    """A reservoir that is driven once by each series, however many ask for that.

    Parameters
    ----------
    reservoir : Reservoir
    """

    def __init__(self, reservoir: Reservoir) -> None:
        self.reservoir = reservoir
        self.states: dict[tuple[bytes, int], NDArray[np.float64]] = {}
        self.candidates = [Remembering(candidate) for candidate in getattr(reservoir, "candidates", ())]

    def __call__(self, series: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
        """States of the first such call."""
        key = series.tobytes(), seed
        if key not in self.states:
            self.states[key] = self.reservoir(series, seed)
        return self.states[key]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.reservoir, name)


def drive_together(calls: Iterable[tuple[Remembering, NDArray[np.float64], int]]) -> None:
    """Drive all bodies among some reservoirs by what they will be called with, a series and a seed.

    Where one of them fails nothing is remembered, and the call itself will tell.
    """
    ahead = {(id(each), series.tobytes(), seed): (each, series) for each, series, seed in calls}
    driven, bodies = [], []
    for (_, told, seed), (each, series) in ahead.items():
        if isinstance(each.reservoir, BodyReservoir):
            driven.append((each, (told, seed), series))
            bodies.append(each.reservoir)
    if len(bodies) < 2:
        return
    try:
        found = states_of_each(bodies, [series for _, _, series in driven])
    except SolverError:
        return
    for (each, key, _), states in zip(driven, found, strict=True):
        each.states[key] = states
