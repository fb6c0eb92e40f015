"""Reservoirs known by name: bodies, and the baselines beside them, of as many features."""

from dataclasses import replace
from typing import Any

from ...common.validation import whole_number
from .baselines import DelayLine, EchoState
from .body import BodyReservoir, READINGS
from .reservoir import Reservoir

__all__ = ["RESERVOIRS", "known_reservoirs"]

_TUBE_MASS = 0.3


def known_reservoirs(features: int = 12, *, segments: int = 3, **body: Any) -> dict[str, Reservoir]:
    """Bodies, and the baselines beside them, of as many features.

    Pressure only, linear, anchored and crawler are one ladder: each adds one part of the body to the one before, in
    this order the valve's lag, the elastomer, what is nonlinear in it, and the stick-slip friction.

    Parameters
    ----------
    features : int
        At least 3 and a multiple of it, for three readings of the crawler at every virtual node. A chain has the
        largest multiple of its readings that is no more, and at least one of each.
    segments : int, at least 2
        Of the chain, whose tube weighs 0.3 of payload and foot.
    **body
        Arguments of :class:`BodyReservoir` for all bodies; `scene` for the crawler and, anchored or in pieces, for
        the others. Not `virtual_nodes` or `readings`.

    Returns
    -------
    dict of str to Reservoir
        "crawler", "anchored", "linear", "pressure only", "chain of N", "delay line", "echo-state network", "cycle
        reservoir" and "orthogonal network", of which the last three are tuned.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    features = whole_number("features", features, len(READINGS))
    if features % len(READINGS):
        raise ValueError(f"features must be a multiple of {len(READINGS)}, got {features}")
    segments = whole_number("segments", segments, 2)
    crawler = BodyReservoir(virtual_nodes=features // len(READINGS), **body)
    anchored = replace(crawler, scene=replace(crawler.scene, anchored=True))
    tube_mass = crawler.scene.tube_mass or _TUBE_MASS
    chain = replace(crawler, scene=replace(crawler.scene, segments=segments, tube_mass=tube_mass), virtual_nodes=1)
    return {
        "crawler": crawler,
        "anchored": anchored,
        "linear": replace(anchored, groups=replace(crawler.groups, duffing=0.0, radial_coupling=0.0)),
        "pressure only": replace(anchored, readings=("pressure",), virtual_nodes=features),
        f"chain of {segments}": replace(chain, virtual_nodes=max(1, features // chain.features)),
        "delay line": DelayLine(features),
        "echo-state network": EchoState(features, tune=True),
        "cycle reservoir": EchoState(features, tune=True, topology="cycle"),
        "orthogonal network": EchoState(features, tune=True, topology="orthogonal"),
    }


RESERVOIRS = known_reservoirs()
"""The reservoirs known by name, at 12 features. Add your own."""
