"""A linear chain without integration: each phase of the foot by the exponential of its matrix, events by root finding.

Newton's second law for N + 1 nodes, foot first. The state is their positions and rates, the pressure and a 1, and in
one phase its rate is a constant matrix times it. A foot that sticks has a row of zeros.
"""

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

__all__ = ["exact_chain"]

_LOOKS = 256  # in a hold, at which an event is looked for


def exact_chain(groups, valve, hold, *, segments, tube_mass):
    """Deformation and foot at the end of each hold, and the times of events, of a linear chain on a ratchet."""
    masses = np.full(segments + 1, tube_mass / segments)
    masses[[0, -1]] /= 2.0
    masses += np.eye(segments + 1)[0] * groups.foot_mass_fraction
    masses += np.eye(segments + 1)[-1] * (1.0 - groups.foot_mass_fraction)
    nodes = segments + 1
    # Pull of a segment: p - D - 2 Pi2 D', with D = N times its stretch.
    pulls = np.zeros((segments, 2 * nodes + 2))
    for j in range(segments):
        for row, factor in ((0, 1.0), (nodes, 2.0 * groups.damping_ratio)):
            pulls[j, row + j] += factor * segments
            pulls[j, row + j + 1] -= factor * segments
        pulls[j, 2 * nodes] = 1.0
    free = np.zeros((2 * nodes + 2, 2 * nodes + 2))
    free[:nodes, nodes : 2 * nodes] = np.eye(nodes)
    for i in range(nodes):
        ahead = pulls[i] if i < segments else 0.0
        behind = pulls[i - 1] if i > 0 else 0.0
        free[nodes + i] = (behind - ahead) / masses[i]
    free[2 * nodes, 2 * nodes] = -1.0 / groups.deborah

    def matrix(slides, u):
        found = free.copy()
        found[2 * nodes, -1] = u / groups.deborah
        found[nodes, -1] -= groups.kinetic_friction / masses[0]
        if not slides:
            found[[0, nodes]] = 0.0
        return found

    def margin(slides, state):
        """What falls through 0 at the next event: the foot's speed, or the grip."""
        return state[nodes] if slides else groups.static_friction + pulls[0] @ state

    def after(t, slides, own, state):
        return margin(slides, expm(own * t) @ state)

    state, slides = np.eye(2 * nodes + 2)[-1], False
    deformation, foot, events = [], [], []
    for k, u in enumerate(valve):
        since = 0.0
        while since < hold:
            own = matrix(slides, u)
            look = (hold - since) / _LOOKS
            by, here, event = expm(own * look), state, None
            for i in range(_LOOKS):
                there = by @ here
                if margin(slides, there) < 0.0:
                    event = i * look
                    break
                here = there
            if event is None:
                state, since = here, hold
                continue
            root = brentq(after, 0.0, look, args=(slides, own, here), xtol=1e-15)
            state = expm(own * root) @ here
            since += event + root
            slides = not slides
            state[nodes] = 0.0
            events.append(k * hold + since)
        deformation.append(state[nodes - 1] - state[0])
        foot.append(state[0])
    return np.array(deformation), np.array(foot), np.array(events)
