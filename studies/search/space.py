"""What a search chooses from: named dimensions, each a variation, and what is built of a point in their cube."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import known_names, number_within, whole_number
from ...crawler import Groups, Scene
from ...crawler.model.groups import RANGES
from ...crawler.model.tube import is_chain
from ...crawler.model.variations import Choice, Range, Variation, variations, varied
from ...reservoir.echo_state import TOPOLOGIES
from ...tasks.encodings import ENCODINGS
from ...tasks.reservoirs import BodyReservoir, EchoState, Reservoir

__all__ = ["Choice", "Range", "Space", "body_space", "crawler_space", "echo_state_space"]


@dataclass(frozen=True)
class Space:
    """Reservoirs to choose from.

    Attributes
    ----------
    dimensions : mapping of str to Range or Choice
        By name.
    build : callable
        Makes a reservoir of the values by name, or gives None for what is not worth trying.
    """

    dimensions: Mapping[str, Variation]
    build: Callable[[Mapping[str, Any]], Reservoir | None]

    def at(self, point: NDArray[np.float64]) -> dict[str, Any]:
        """The values at a point of the unit cube, shape (dimensions,)."""
        return {
            name: dimension.at(float(share))
            for (name, dimension), share in zip(self.dimensions.items(), point, strict=True)
        }

    def where(self, **fixed: Any) -> "Space":
        """The part of the space where some dimensions have one value each.

        Raises
        ------
        ValueError
            If a dimension is unknown, or a value is none that its choice or any range could give.
        TypeError
            If a range is fixed at what is no number.
        """
        known_names("space", fixed, tuple(self.dimensions))
        for name, value in fixed.items():
            dimension = self.dimensions[name]
            if isinstance(dimension, Range):
                number_within(name, value, "(-inf, inf)")
            else:
                known_names(name, [value], dimension.values)
        return Space({**self.dimensions, **{name: Choice([value]) for name, value in fixed.items()}}, self.build)


_SEGMENTS = (1, 2, 3, 5, 6, 10, 15, 20, 30, 60)
_READINGS = {
    ", ".join(readings): readings
    for readings in (
        ("deformation",),
        ("velocity",),
        ("deformation", "velocity"),
        ("deformation", "velocity", "pressure"),
    )
}
# Of a chain that swings faster or is stiffer within a sample, one evaluation takes as long as dozens of others.
_MOST_RADIANS, _MOST_TIME_CONSTANTS = 12.0, 30.0
# The readout's penalty hides what is smaller than 1e-4 of the states: digits beyond these are of no use to it.
_TOLERANCE = 1e-7


def body_space(features: int) -> Space:
    """Bodies of at most so many features: a crawler or a chain, on the ground or anchored.

    Parameters
    ----------
    features : int, at least 3
        Virtual nodes are as many as fit, so that segments and virtual nodes compete for the same features.

    Returns
    -------
    Space
        Over the groups, the scene, the length of a hold, the encoding, the holds a sample, and what is read. Chains
        that swing by more than 12 radians in a sample, or settle in less than a thirtieth of one, are left out for
        their cost.

    Raises
    ------
    TypeError, ValueError
        If `features` is not such an integer.
    """
    features = whole_number("features", features, 3)
    dimensions: dict[str, Variation] = {
        "segments": Choice([n for n in _SEGMENTS if n <= features]),
        "ground": Choice(("anchored", "ratchet", "free")),
        "readings": Choice(tuple(_READINGS)),
        "encoding": Choice(tuple(ENCODINGS)),
        "holds_per_sample": Choice((1, 2, 4)),
        "sample_time": Range(0.03, 10.0, log=True),
        "tube_mass": Range(0.1, 300.0, log=True),
        "slope": Range(-0.5, 0.5),
        "duffing": Range(1e-3, 10.0, log=True),
        "damping_ratio": Range(1e-4, 3.0, log=True),
        "deborah": Range(5e-3, 5.0, log=True),
        "radial_coupling": Range(1e-3, 2.0, log=True),
        "foot_mass_fraction": Range(0.02, 0.98),
        "static_friction": Range(1e-3, 1.0, log=True),
        "kinetic_share": Range(0.0, 1.0),
    }
    return Space(dimensions, partial(_body, features))


def _body(features: int, values: Mapping[str, Any]) -> BodyReservoir | None:
    segments, mass, lasting = values["segments"], values["tube_mass"], values["sample_time"]
    if lasting * 2 * segments / math.sqrt(mass) > _MOST_RADIANS:
        return None
    if lasting * 8 * values["damping_ratio"] * segments**2 / mass > _MOST_TIME_CONSTANTS:
        return None
    world = Scene(
        anchored=values["ground"] == "anchored",
        ratchet=values["ground"] != "free",
        segments=segments,
        tube_mass=mass if segments > 1 else 0.0,
    )
    hold = lasting / values["holds_per_sample"]
    numbers = {name: value for name, value in values.items() if name in RANGES}
    numbers["kinetic_friction"] = values["kinetic_share"] * values["static_friction"]
    groups, scene, hold = varied(Groups(), world, hold, {**numbers, "slope": values["slope"]})
    readings = _READINGS[values["readings"]]
    columns = sum(segments if is_chain(scene) and reading != "pressure" else 1 for reading in readings)
    if columns > features:
        return None
    return BodyReservoir(
        groups,
        scene,
        hold=hold,
        encoding=values["encoding"],
        holds_per_sample=values["holds_per_sample"],
        virtual_nodes=features // columns,
        readings=readings,
        tolerance=_TOLERANCE,
    )


def crawler_space(body: BodyReservoir, varying: Mapping[str, Any]) -> Space:
    """One body, of which some numbers vary.

    Parameters
    ----------
    body : BodyReservoir
    varying : mapping of str to (low, high) or Range
        Such as ``{"duffing": (0, 5), "slope": (-0.1, 0.1), "hold": Range(0.1, 10, log=True)}``.

    Returns
    -------
    Space
        Kinetic friction above static friction is left out.

    Raises
    ------
    TypeError, ValueError
        As in `stickslip.crawler.model.variations.variations`.
    """
    return Space(variations("varying", varying), partial(_crawler, body))


def _crawler(body: BodyReservoir, values: Mapping[str, Any]) -> BodyReservoir | None:
    own = body.groups.to_dict()
    kinetic, static = (values.get(name, own[name]) for name in ("kinetic_friction", "static_friction"))
    return None if kinetic > static else body.varied(values)


def echo_state_space(features: int) -> Space:
    """Echo-state networks of so many nodes, over all that `EchoState` lets one choose.

    Parameters
    ----------
    features : int, at least 1

    Returns
    -------
    Space
        Over the topology, the spectral radius, the input scaling, the leak, and whether the drive is centred.

    Raises
    ------
    TypeError, ValueError
        If `features` is not such an integer.
    """
    features = whole_number("features", features, 1)
    dimensions: dict[str, Variation] = {
        "spectral_radius": Range(0.1, 1.3),
        "input_scaling": Range(0.01, 5.0, log=True),
        "leak": Range(0.1, 1.0),
        "topology": Choice(TOPOLOGIES),
        "centred": Choice((False, True)),
    }
    return Space(dimensions, partial(_network, features))


def _network(features: int, values: Mapping[str, Any]) -> EchoState:
    return EchoState(features, **values)
