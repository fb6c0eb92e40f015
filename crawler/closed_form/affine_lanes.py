"""Anchored linear crawlers of one kind, eight at once: a hold is one affine map, the same for all."""

import numpy as np
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from ...compiling.vectors import broadcast, flush_to_zero, load, store
from ..model.columns import Crawlers
from ..model.equations import acceleration_at_no_force
from ..model.state import Coefficients, STUCK
from ..motion.sampling import FARTHEST
from ..steps.options import DIVERGED, FINISHED
from ..steps.propagator import rates_of
from .search import FAINTEST

__all__ = ["advance_anchored_lanes"]


@compiled
def advance_anchored_lanes(
    first: int,
    crawlers: Crawlers,
    coefficients: Coefficients,
    valves: NDArray[np.float64],
    hold: float,
    table: NDArray[np.float64],
) -> None:
    """Advance the crawlers in columns `first` to `first + 7` by one hold, as `advance` does.

    Parameters
    ----------
    first : int
    crawlers : Crawlers
        Updated; its arrays are C-contiguous.
    coefficients : Coefficients
        Of them all.
    valves : (LANES,) array
        Of these crawlers, 0 or 1.
    hold : float
    table : (2 samples, ENTRIES) array
        From `tabulate`, for all of them.
    """
    bodies, samples = crawlers.bodies, crawlers.samples
    width = bodies.shape[1]
    rates = rates_of(coefficients, STUCK)
    valve = load(valves, 0)
    rest = valve + broadcast(acceleration_at_no_force(coefficients, STUCK) / rates.mobility)
    gap = flush_to_zero(load(bodies, 2 * width + first) - valve, FAINTEST)
    v = flush_to_zero(load(bodies, width + first), FAINTEST)
    z = flush_to_zero(load(bodies, first) - rest, FAINTEST)
    count = samples.shape[1]
    for j in range(count):
        over = table[j]
        moved_z = rest + (broadcast(over[0]) * z + broadcast(over[1]) * v + broadcast(over[2]) * gap)
        moved_v = broadcast(over[3]) * z + broadcast(over[4]) * v + broadcast(over[5]) * gap
        pressure = valve + broadcast(over[6]) * gap
        store(samples, j * width + first, moved_z)
        store(samples, (count + j) * width + first, moved_v)
        store(samples, (2 * count + j) * width + first, pressure)
        if j == count - 1:
            store(bodies, first, moved_z)
            store(bodies, width + first, moved_v)
            store(bodies, 2 * width + first, pressure)
    for i in range(first, first + len(valves)):
        near = abs(bodies[0, i]) + abs(bodies[1, i]) < FARTHEST
        crawlers.statuses[i] = FINISHED if near else DIVERGED
        crawlers.elapsed[i] = hold if near else 0.0
