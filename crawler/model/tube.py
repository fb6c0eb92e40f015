"""Where the tube's mass sits: at the nodes of a chain, or at the two ends of one segment."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...common.validation import finite_array
from .groups import Groups
from .scene import Scene
from .state import ChainState

__all__ = ["as_crawler", "is_chain", "node_masses", "stretches_of"]


def is_chain(scene: Scene) -> bool:
    """Whether the segments must be told apart: without mass between them they all pull alike."""
    return scene.segments > 1 and scene.tube_mass > 0.0


def node_masses(groups: Groups, scene: Scene) -> NDArray[np.float64]:
    """Masses from foot to payload in units of m_p + m_f: each segment's is borne half and half by its two ends.

    Parameters
    ----------
    groups : Groups
    scene : Scene

    Returns
    -------
    (segments + 1,) array
    """
    masses = np.full(scene.segments + 1, scene.tube_mass / scene.segments)
    masses[[0, -1]] *= 0.5
    masses[0] += groups.foot_mass_fraction
    masses[-1] += 1.0 - groups.foot_mass_fraction
    return masses


def as_crawler(groups: Groups, scene: Scene) -> tuple[Groups, Scene, float]:
    """Groups and scene of the crawler that is one heavy segment, and its unit of time.

    Its own mass, 1 + tube_mass, is that crawler's unit, which changes what is made of mass: the time by the root, and
    with it damping ratio, Deborah number and weight along the slope. Lengths, forces and energies stay.

    Parameters
    ----------
    groups : Groups
    scene : Scene
        Any but a chain's.

    Returns
    -------
    groups : Groups
    scene : Scene
        With one massless segment.
    unit : float
        t_c of that crawler over t_c of `groups`; 1 for a massless tube, whose groups are returned as they are.
    """
    if scene.tube_mass == 0.0:
        return groups, scene if scene.segments == 1 else replace(scene, segments=1), 1.0
    mass = 1.0 + scene.tube_mass
    unit = math.sqrt(mass)
    equivalent = replace(
        groups,
        damping_ratio=groups.damping_ratio / unit,
        deborah=groups.deborah / unit,
        foot_mass_fraction=(groups.foot_mass_fraction + 0.5 * scene.tube_mass) / mass,
    )
    return equivalent, replace(scene, tube_mass=0.0, slope=scene.slope * mass), unit


def stretches_of(initial: ChainState, scene: Scene) -> NDArray[np.float64]:
    """The stretches D = N d and D' of the segments, shape (2, segments).

    Raises
    ------
    ValueError
        If `initial` has another number of segments than `scene`, is not finite, or stretches massless segments
        unevenly: they all pull alike.
    TypeError
        If the stretches are not arrays of real numbers.
    """
    segments = scene.segments
    stretches = np.empty((2, segments))
    for row, name in zip(stretches, ("segment_deformation", "segment_velocity"), strict=True):
        values = finite_array(f"initial {name}", getattr(initial, name), 1)
        if len(values) != segments:
            raise ValueError(f"initial {name} must have segments = {segments} values, got {len(values)}")
        if not is_chain(scene) and np.ptp(values) > 0.0:
            raise ValueError(f"initial {name} must be the same for all segments where tube_mass is 0, got {values}")
        row[:] = segments * values
    return stretches
