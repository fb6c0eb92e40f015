"""What drives what: reservoirs as functions from a stream of bits to states, one row a bit."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..crawler import Groups, Scene, simulate, Trajectory
from ..reservoir import delay_line, EchoStateNetwork
from ..validation import whole_number
from .streams import bits

Reservoir = Callable[[NDArray[np.int64], int], NDArray[np.float64]]
"""Takes bits (length,) and a seed for what in it is random; gives states (length, features)."""


def crawler_states(
    valve: ArrayLike,
    *,
    groups: Groups | str | Mapping[str, Any] | None = None,
    hold: float = 0.5,
    virtual_nodes: int = 4,
    scene: Scene | None = None,
    tolerance: float = 1e-9,
) -> NDArray[np.float64]:
    """Drive the crawler from rest and read its body several times a hold.

    Parameters
    ----------
    valve : array_like of shape (holds,)
        Of 0 and 1.
    groups : Groups, str, mapping or None
        As in `Groups.of`; the default crawler if None.
    hold : float, in (0, inf)
        Time that the valve keeps each state, natural units.
    virtual_nodes : int, at least 1
        Readings a hold, equally spaced, the last at its end.
    scene : Scene, optional
        On the ground with a ratcheted foot by default.
    tolerance : float
        As in `simulate`.

    Returns
    -------
    ndarray of shape (holds, 3 * virtual_nodes)
        Row k is read during hold k and has absorbed ``valve[k]``; columns as in `body_states`.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    u = bits("valve", valve)
    nodes = whole_number("virtual_nodes", virtual_nodes, 1)
    return body_states(simulate(Groups.of(groups), u, hold, scene=scene, tolerance=tolerance, samples_per_hold=nodes))


def body_states(motion: Trajectory) -> NDArray[np.float64]:
    """Lay the body's motion out as a reservoir's states, one row a hold.

    Parameters
    ----------
    motion : Trajectory
        Of one crawler.

    Returns
    -------
    ndarray of shape (holds, 3 * samples_per_hold)
        Deformations come first, then velocities, then pressures, each in order of time.
    """
    readings = (motion.deformation, motion.velocity, motion.pressure)
    return np.hstack([reading.reshape(len(motion.valve), -1) for reading in readings])


def crawler_and_baselines(*, virtual_nodes: int = 4, **crawler: Any) -> dict[str, Reservoir]:
    """Put a crawler beside a delay line and an echo-state network that have as many features.

    Parameters
    ----------
    virtual_nodes : int, at least 1
        Of the crawler, which makes three times as many features.
    **crawler
        The other keyword arguments of `crawler_states`.

    Returns
    -------
    dict of str to Reservoir

    Raises
    ------
    TypeError, ValueError
        If `virtual_nodes` is invalid; the other arguments are checked when the crawler is driven.
    """
    features = 3 * whole_number("virtual_nodes", virtual_nodes, 1)
    return {
        "crawler": lambda stream, _: crawler_states(stream, virtual_nodes=virtual_nodes, **crawler),
        "delay line": lambda stream, _: delay_line(stream, features),
        "echo-state network": lambda stream, seed: EchoStateNetwork(features, seed=seed).states(stream),
    }


RESERVOIRS = crawler_and_baselines()
"""The reservoirs known by name. Add your own."""
