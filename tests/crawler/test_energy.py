"""Work, stored energy and losses."""

import numpy as np
import pytest
from cases import BOUNCER, HUNT, run, WORD
from hypothesis import given
from hypothesis import strategies as st

from stickslip.crawler import Groups, Scene, simulate, State

LINEAR = Groups(**BOUNCER | {"damping_ratio": 0.05, "deborah": 1.06, "foot_mass_fraction": 0.036})


@pytest.mark.parametrize("groups", [Groups(), LINEAR, Groups(damping_ratio=3.5)], ids=["default", "linear", "damped"])
@pytest.mark.parametrize("anchored", [True, False])
def test_the_balance_closes_to_the_tolerance(groups, anchored):
    for tolerance in 10.0 ** np.arange(-14, -3):
        done = run(groups, [0, 1, 0, 1], 4.16, scene=Scene(anchored=anchored), tolerance=tolerance)
        assert abs(done.energy_residual) < 3.0 * tolerance + 1e-13


@HUNT
@given(deborah=st.floats(0.02, 5.0), damping=st.floats(0.0, 3.0), hold=st.floats(0.1, 5.0), start=st.floats(-1.0, 1.0))
def test_the_balance_closes_in_a_linear_body(deborah, damping, hold, start):
    groups = Groups(**BOUNCER | {"deborah": deborah, "damping_ratio": damping})
    done = run(groups, [1, 0, 1], hold, initial=State(start, -start, abs(start)), tolerance=1e-12)
    assert abs(done.energy_residual) < 1e-10


def test_work_is_the_pressure_times_the_change_of_volume():
    # Anchored motion has no kinks, so Simpson's rule over many samples is an independent quadrature.
    groups, samples = Groups(), 4000
    done = simulate(
        groups, WORD, 1.0, scene=Scene(anchored=True), samples_per_hold=samples, tolerance=1e-14, initial=State(0.2)
    )
    power = done.pressure * (1.0 + groups.radial_coupling * done.deformation) * done.velocity
    heat = 2.0 * groups.damping_ratio * done.velocity**2
    for integrand, expected in ((power, done.work), (heat, done.viscous_loss)):
        padded = np.concatenate([[0.0], integrand])  # at rest without pressure no power flows
        simpson = padded[0] + padded[-1] + 4.0 * padded[1::2].sum() + 2.0 * padded[2:-1:2].sum()
        assert simpson / (3.0 * samples) == pytest.approx(expected, abs=1e-9)


def test_friction_loss_is_the_drag_times_the_way():
    groups = Groups()
    done = run(groups, WORD * 5, 1.0, tolerance=1e-13)
    assert done.friction_loss == pytest.approx(groups.kinetic_friction * done.foot[-1], rel=1e-12)


def test_a_body_released_without_damping_friction_or_pressure_keeps_its_energy():
    groups = Groups(duffing=3.0, damping_ratio=0.0, static_friction=0.0, kinetic_friction=0.0)
    done = run(
        groups, [0] * 30, 1.0, scene=Scene(ratchet=False), initial=State(0.9, 0.3, 0.0, 0.0, 0.2), tolerance=1e-14
    )
    assert done.work == 0.0
    assert done.stored == pytest.approx(0.0, abs=1e-11)


def test_stored_energy_is_kinetic_and_elastic():
    groups, start = Groups(duffing=2.0), State(0.5, -0.2, 0.3, 0.0, 0.4)
    done = simulate(groups, [1], 0.3, initial=start)

    def energy(z, v, w):
        r = groups.foot_mass_fraction
        return r * w**2 / 2 + (1 - r) * (v + w) ** 2 / 2 + z**2 / 2 + groups.duffing * z**4 / 4

    grown = energy(done.deformation[-1], done.velocity[-1], done.foot_velocity[-1]) - energy(0.5, -0.2, 0.4)
    assert done.stored == pytest.approx(grown, rel=1e-14)
