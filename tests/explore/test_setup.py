"""Setups: what a page may be asked for, and what moves with what."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from stickslip.crawler import Groups, Scene
from stickslip.crawler import PRESETS as BODIES
from stickslip.explore.motion import shown
from stickslip.explore.presets import preset, PRESETS
from stickslip.explore.setup import changed, NUMBERS, Setup, setup_of, SWITCHES, without_effect
from stickslip.train.policies.pretrained import PRETRAINED


def test_every_number_of_a_setup_has_a_slider_and_starts_within_it():
    values = Setup().to_dict()
    assert {name for name, value in values.items() if isinstance(value, float)} == set(NUMBERS)
    assert all(number.low <= values[name] <= number.high for name, number in NUMBERS.items())
    assert Setup().groups == Groups()


def test_every_truth_of_a_setup_has_a_switch_and_is_the_scene_s():
    values = Setup().to_dict()
    assert {name for name, value in values.items() if isinstance(value, bool)} == set(SWITCHES)
    assert Setup().scene == Scene()
    assert setup_of({"ratchet": False, "slope": 0.1}).scene == Scene(ratchet=False, slope=0.1)
    assert changed(Setup(), "anchored", True).scene == Scene(anchored=True)


def test_a_setup_is_never_changed():
    with pytest.raises(FrozenInstanceError):
        Setup().hold = 2.0


def test_what_is_without_effect_changes_nothing():
    assert without_effect(Setup()) == []
    clamped = preset("anchored")
    others = {"static_friction": 0.9, "kinetic_friction": 0.7, "ratchet": False}
    assert sorted(without_effect(clamped)) == sorted(others)
    one, other = (shown(setup).motion for setup in (clamped, setup_of(others, clamped)))
    np.testing.assert_array_equal(one.deformation, other.deformation)
    assert not one.foot.any()


def test_a_setup_is_that_of_its_own_fields():
    setup = setup_of({"duffing": 2.0, "slope": -0.1, "drive": "policy", "policy": "speed", "units": "SI"})
    assert setup.groups == Groups(duffing=2.0)
    assert setup.scene.slope == -0.1
    assert setup_of(setup.to_dict()) == setup
    assert setup_of({"hold": 2.0}, setup) == setup_of({**setup.to_dict(), "hold": 2.0})


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("duffing", 20.5, r"duffing must be in \[0, 20\], got 20.5"),
        ("foot_mass_fraction", 0.0, r"foot_mass_fraction must be in \[0.05, 0.95\], got 0.0"),
        ("hold", float("nan"), r"hold must be in \[0.05, 5\], got nan"),
        ("hold", "1", r"hold must be a number in \[0.05, 5\], got '1'"),
        ("tolerance", 0.1, r"tolerance must be in \[1e-15, 0.01\], got 0.1"),
        ("dither", 0.6, r"dither must be in \[0, 0.5\], got 0.6"),
        ("slope", True, r"slope must be a number in \[-0.3, 0.3\], got True"),
        ("word", "", r"word must be 1 to 32 letters 0 and 1, got ''"),
        ("word", "012", r"word must be 1 to 32 letters 0 and 1, got '012'"),
        ("word", "01" * 17, r"word must be 1 to 32 letters 0 and 1"),
        ("word", 11, r"word must be 1 to 32 letters 0 and 1, got 11"),
        ("drive", "wind", r"drive must be one of \['word', 'policy', 'live'\], got 'wind'"),
        ("policy", "../knee", r"policy must be one of \[.*'knee'.*\], got '../knee'"),
        ("units", "imperial", r"units must be one of \['natural', 'SI'\], got 'imperial'"),
        ("ratchet", 1, r"ratchet must be True or False, got 1"),
        ("anchored", "true", r"anchored must be True or False, got 'true'"),
        ("colour", "red", r"setup has no 'colour'; allowed are \['duffing'"),
    ],
)
def test_what_is_not_allowed_is_refused_by_name(name, value, message):
    for refuse in (lambda: setup_of({name: value}), lambda: changed(Setup(), name, value)):
        with pytest.raises((TypeError, ValueError), match=f"^{message}"):
            refuse()


def test_either_friction_takes_the_other_along_where_it_must():
    assert changed(Setup(), "static_friction", 0.1).groups == Groups(static_friction=0.1, kinetic_friction=0.1)
    assert changed(Setup(), "static_friction", 0.25).groups == Groups(static_friction=0.25)
    assert changed(Setup(), "kinetic_friction", 0.5).groups == Groups(static_friction=0.5, kinetic_friction=0.5)
    assert changed(Setup(), "kinetic_friction", 0.1).groups == Groups(kinetic_friction=0.1)


def test_presets_are_what_they_are_called():
    assert preset("fastest-word") == Setup()
    assert preset("clean-gait").dither == 0.0
    assert preset("coin").dither == 0.5
    assert preset("space-bar").drive == "live"
    assert {each.setup.policy for each in PRESETS.values() if each.setup.drive == "policy"} <= set(PRETRAINED)
    assert all(PRESETS[name].setup == Setup(groups=body) for name, body in list(BODIES.items())[1:])
    assert len({each.setup for each in PRESETS.values()}) == len(PRESETS)
    with pytest.raises(ValueError, match=r"^preset must be one of \['fastest-word', .*\], got 'slowest-word'$"):
        preset("slowest-word")
