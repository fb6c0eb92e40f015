"""The chain solved anew: a linear one whose foot stands still, by the exponential of its matrix.

Newton's second law for the masses of the tube and the payload, with nothing of the simulator in it: it checks the twin
that one spring is compared with.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from ...crawler import Groups

__all__ = ["exact_deformation"]


def exact_deformation(
    groups: Groups, valve: NDArray[np.int64], hold: float, samples: int, *, segments: int, tube_mass: float
) -> NDArray[np.float64]:
    """Deformation of the whole chain, from rest.

    Parameters
    ----------
    groups : Groups
        Without cubic stiffness or coupling; friction is not used.
    valve : (holds,) array of 0 and 1
    hold : float, > 0
        Natural time.
    samples : int
        Of each hold, the last at its end.
    segments : int
    tube_mass : float
        Over that of payload and foot.

    Returns
    -------
    (holds * samples,) array
        Natural units.
    """
    masses = np.full(segments, tube_mass / segments)
    masses[-1] = 1.0 - groups.foot_mass_fraction + 0.5 * tube_mass / segments
    # Segment j pulls its front end back, and its rear end on, by N times its stretch and by as much damping, less p.
    stretch = segments * (np.eye(segments) - np.eye(segments, k=-1))
    pull = np.eye(segments) - np.eye(segments, k=1)
    rates = np.zeros((2 * segments + 2, 2 * segments + 2))  # positions, velocities, pressure, valve
    rates[:segments, segments : 2 * segments] = np.eye(segments)
    of_motion = rates[segments : 2 * segments]
    of_motion[:, :segments] = -(pull @ stretch) / masses[:, np.newaxis]
    of_motion[:, segments : 2 * segments] = 2.0 * groups.damping_ratio * of_motion[:, :segments]
    of_motion[:, -2] = pull.sum(axis=1) / masses
    rates[-2, -2:] = -1.0 / groups.deborah, 1.0 / groups.deborah
    step = expm(rates * (hold / samples))
    state = np.zeros(2 * segments + 2)
    found = []
    for bit in valve:
        state[-1] = bit
        for _ in range(samples):
            state = step @ state
            found.append(state[segments - 1])
    return np.array(found)
