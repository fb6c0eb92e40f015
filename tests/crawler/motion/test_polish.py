"""Where a step of the resting foot ends: at the root of the force that the state has, whatever its series says."""

import numpy as np
import pytest
from scipy.optimize import brentq

from stickslip.crawler import Groups, Scene
from stickslip.crawler.model.state import BACKWARD, Body, coefficients_of, FORWARD, STUCK
from stickslip.crawler.motion.events import _polish
from stickslip.crawler.steps.workspace import FORCE, ROWS, SCRATCH, V, WIDTH, Z

GROUPS = Groups(
    duffing=2.0, damping_ratio=0.2, deborah=0.7, radial_coupling=0.4, static_friction=0.3, foot_mass_fraction=0.25
)
SCENE = Scene(ratchet=False, slope=0.05)
ORDER, LENGTH = 6, 0.9
# Of one power more than the force's series has: it is of the order of the step, and the motion of one more.
STRETCH = np.array([0.1, 0.9, 0.2, -0.1, 0.05, 0.02, -0.01, 0.3])
RATE = np.array([0.3, -0.2, 0.1, 0.05, -0.02, 0.01, 0.02, 0.4])


class Case:
    """A motion, and the margin by which the grip holds on the way."""

    def __init__(self, direction, doubt=1e-3, start=0.0):
        self.direction, self.doubt = direction, doubt
        self.valve, self.pressure = (1.0, 0.3) if direction == FORWARD else (0.1, 0.0)
        self.z, self.v = direction * STRETCH, direction * RATE
        self.z[0] += direction * start

    def margin(self, t):
        g, powers = GROUPS, np.power.outer(t, np.arange(ORDER + 2))
        z, v = powers @ self.z, powers @ self.v
        p = self.valve + (self.pressure - self.valve) * np.exp(-t / g.deborah)
        force = p * (1 + g.radial_coupling * z) - z - g.duffing * z**3 - 2 * g.damping_ratio * v
        return g.static_friction + self.doubt + self.direction * (force + g.foot_mass_fraction * SCENE.slope)

    def polished(self, moment, length=LENGTH, margin=None):
        series = np.full((ROWS, WIDTH), np.nan)  # what is not asked for tells nothing
        times = np.linspace(0.0, LENGTH, 50)
        fit = np.polynomial.Polynomial.fit(times, self.margin(times), ORDER).convert().coef
        series[Z, : ORDER + 2], series[V, : ORDER + 2] = self.z, self.v
        series[FORCE, : ORDER + 1] = 0.0
        series[SCRATCH, : ORDER + 1] = fit if margin is None else margin
        body = Body(self.z[0], self.v[0], self.pressure, 0.0, 0.0, STUCK, 0)
        coefficients = coefficients_of(GROUPS, SCENE)
        return _polish(moment, self.direction, body, coefficients, self.valve, ORDER, length, self.doubt, series)


@pytest.mark.parametrize("direction", [FORWARD, BACKWARD])
@pytest.mark.parametrize("off", [-0.05, 1e-7, 0.05])
def test_it_is_the_root_of_the_force_at_the_state(direction, off):
    for doubt in (0.0, 1e-3, 0.1):
        case = Case(direction, doubt)
        root = brentq(case.margin, 0.0, LENGTH, xtol=1e-15, rtol=1e-15)
        assert case.margin(0.0) > 0.01 > -0.01 > case.margin(LENGTH)
        assert case.polished(root + off) == pytest.approx(root, rel=0, abs=1e-14)


@pytest.mark.parametrize("direction", [FORWARD, BACKWARD])
def test_it_is_on_the_step_or_nowhere(direction):
    case = Case(direction)
    root = brentq(case.margin, 0.0, LENGTH, xtol=1e-15, rtol=1e-15)
    assert case.polished(0.9 * root, length=0.95 * root) == np.inf
    assert Case(direction, start=1.0).polished(0.1) == 0.0


@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_where_the_series_does_not_fall_it_stays_if_the_grip_is_gone(slope):
    case = Case(FORWARD)
    rising = np.eye(ORDER + 1)[1] * slope
    root = brentq(case.margin, 0.0, LENGTH, xtol=1e-15, rtol=1e-15)
    assert case.polished(root + 0.1, margin=rising) == root + 0.1
    assert case.polished(root - 0.1, margin=rising) == np.inf
