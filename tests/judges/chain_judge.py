"""The chain from Newton's second law for each of its masses: positions and rates of N + 1 nodes, foot first.

Events and integration are those of `judge`; the equations of motion and the energies are written anew.
"""

import numpy as np
from judge import Crawling, follow, STICK, Verdict

from stickslip.crawler import ChainState, REST, Scene

__all__ = ["Hauling", "chain_judge"]


class Hauling(Crawling):
    """One chain on its way: state is N + 1 positions, N + 1 rates, work, viscous loss, friction loss."""

    @property
    def count(self):
        return self.scene.segments

    @property
    def foot_rate(self):
        return self.count + 1

    @property
    def masses(self):
        masses = np.zeros(self.count + 1)
        masses[0] = self.groups.foot_mass_fraction
        masses[-1] = 1.0 - self.groups.foot_mass_fraction
        for segment in range(self.count):
            masses[segment] += 0.5 * self.scene.tube_mass / self.count
            masses[segment + 1] += 0.5 * self.scene.tube_mass / self.count
        return masses

    @property
    def foot_mass(self):
        return self.masses[0]

    def forces(self, pressure, state):
        """Of every segment on the mass in front of it; its opposite acts on the mass behind."""
        g, n = self.groups, self.count
        stretch, rate = np.diff(state[: n + 1], axis=0), np.diff(state[n + 1 : 2 * n + 2], axis=0)
        spring = n * stretch + n**3 * g.duffing * stretch**3
        return pressure * (1.0 + n * g.radial_coupling * stretch) - spring - 2.0 * n * g.damping_ratio * rate

    def force(self, pressure, state):
        return self.forces(pressure, state)[0]

    def rates(self, pressure, state):
        g, n = self.groups, self.count
        forces = self.forces(pressure, state)
        friction = -self.motion * g.kinetic_friction
        total = np.zeros(n + 1)
        total[1:] += forces
        total[:-1] -= forces
        total[0] += friction
        acceleration = total / self.masses - self.scene.slope
        if self.motion == STICK:
            acceleration[0] = 0.0
        stretch, rate = np.diff(state[: n + 1]), np.diff(state[n + 1 : 2 * n + 2])
        power = pressure * np.sum((1.0 + n * g.radial_coupling * stretch) * rate)
        heat = 2.0 * n * g.damping_ratio * np.sum(rate**2)
        return np.concatenate([state[n + 1 : 2 * n + 2], acceleration, [power, heat, -friction * state[n + 1]]])


def chain_judge(groups, valve, hold, *, scene, samples_per_hold=1, initial=None):
    """Integrate one chain with SciPy, arguments as those of `simulate`: a verdict, and stretches and rates of segments.

    Returns
    -------
    verdict : Verdict
    segment_deformation, segment_velocity : (segments, samples) arrays
    """
    start, n = initial or REST, scene.segments
    if isinstance(start, ChainState):
        stretch, rate = np.array(start.segment_deformation), np.array(start.segment_velocity)
    else:
        stretch, rate = np.full(n, start.deformation / n), np.full(n, start.velocity / n)
    positions = start.foot + np.concatenate([[0.0], np.cumsum(stretch)])
    speeds = start.foot_velocity + np.concatenate([[0.0], np.cumsum(rate)])
    run = Hauling(groups, scene or Scene(), np.concatenate([positions, speeds, np.zeros(3)]))
    run.motion = int(np.sign(start.foot_velocity))
    p, rows, clearance = follow(run, valve, hold, samples_per_hold, start.pressure)
    places, speeds = np.array(rows[: n + 1]), np.array(rows[n + 1 : 2 * n + 2])
    verdict = Verdict(
        places[-1] - places[0],
        speeds[-1] - speeds[0],
        p,
        places[0],
        speeds[0],
        run.events,
        clearance,
        *run.state[2 * n + 2 :],
        places[0, -1],
    )
    return verdict, np.diff(places, axis=0), np.diff(speeds, axis=0)
