"""A body in SI for any groups."""

from dataclasses import fields

import pytest

from stickslip.crawler import Actuator, Groups, PRESETS
from stickslip.explore.setup import NUMBERS, setup_of
from stickslip.explore.units import actuator_with, in_si, units_of


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_a_body_in_si_has_the_groups_and_the_scales_of_ecoflex(name):
    body = actuator_with(PRESETS[name])
    assert body.groups.to_dict() == pytest.approx(PRESETS[name].to_dict(), rel=1e-14)
    assert body.scales == pytest.approx(Actuator.ecoflex().scales, rel=1e-15)


def test_the_default_body_is_that_of_ecoflex():
    body, model = actuator_with(Groups()), Actuator.ecoflex()
    for each in fields(Actuator):
        assert getattr(body, each.name) == pytest.approx(getattr(model, each.name), rel=1e-14), each.name


def test_numbers_are_told_in_si():
    told = in_si(setup_of({"damping_ratio": 0.1, "hold": 2.0, "slope": 0.1}))
    assert told == {
        "duffing": "k₃ = 32.8 kN/m³",
        "damping_ratio": "b = 0.8 N s/m",
        "deborah": "τ = 31.2 ms",
        "radial_coupling": "α = 6.4 /m",
        "foot_mass_fraction": "m_f = 75 g",
        "static_friction": "μ_s = 0.816",
        "kinetic_friction": "μ_k = 0.544",
        "slope": "Mg sin = 0.2 N",
        "hold": "h = 125 ms",
    }
    assert set(told) < set(NUMBERS)


def test_the_units_shown_are_those_of_the_body():
    assert units_of(setup_of({}))[:3] == (1.0, 1.0, 1.0)
    shown = units_of(setup_of({"units": "SI", "foot_mass_fraction": 0.6}))
    assert shown[:3] == pytest.approx((31.25, 0.0625, 20.0), rel=1e-14)
    assert shown.speed_unit == "mm/s"
