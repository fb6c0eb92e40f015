"""Groups and Scene: presets, choices, and what they refuse."""

import json
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from stickslip.crawler import Groups, PRESETS, Scene

FIELDS = list(Groups().to_dict())


def test_defaults_are_those_of_the_design():
    assert list(Groups().to_dict().values()) == [0.5, 0.05, 0.5, 0.2, 0.3, 0.3, 0.2]
    assert FIELDS == [
        "duffing",
        "damping_ratio",
        "deborah",
        "radial_coupling",
        "foot_mass_fraction",
        "static_friction",
        "kinetic_friction",
    ]


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1e-9])
def test_refuses_what_is_not_finite_or_negative(name, bad):
    with pytest.raises(ValueError, match=rf"{name} must be in [\[(]0, .*[\])], got ") as caught:
        Groups(**{name: bad})
    assert repr(bad) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "bad", "allowed"),
    [
        ("deborah", 0.0, r"\(0, inf\)"),
        ("foot_mass_fraction", 0.0, r"\(0, 1\)"),
        ("foot_mass_fraction", 1.0, r"\(0, 1\)"),
        ("foot_mass_fraction", 1.5, r"\(0, 1\)"),
        ("kinetic_friction", 0.31, r"\[0, static_friction = 0\.3\]"),
    ],
)
def test_refuses_what_is_out_of_range(name, bad, allowed):
    with pytest.raises(ValueError, match=rf"{name} must be in {allowed}, got {bad}"):
        Groups(**{name: bad})


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize("bad", ["stiff", None, [1.0, 2.0], 1j])
def test_refuses_what_is_no_number(name, bad):
    with pytest.raises(TypeError, match=f"{name} must be"):
        Groups(**{name: bad})


def test_takes_the_ends_that_are_allowed():
    edge = Groups(0.0, 0.0, 1e-12, 0.0, 1e-12, 0.0, 0.0)
    assert edge.kinetic_friction == edge.static_friction == 0.0


def test_numbers_of_every_kind_become_floats():
    groups = Groups(duffing=1, deborah=np.float32(0.5), static_friction=np.int64(1))
    assert all(type(value) is float for value in groups.to_dict().values())
    assert json.loads(json.dumps(groups.to_dict())) == groups.to_dict()


def test_groups_are_values():
    assert Groups() == Groups()
    assert hash(Groups()) == hash(Groups())
    with pytest.raises(FrozenInstanceError):
        Groups().duffing = 1.0


def test_of_takes_a_preset_a_mapping_groups_or_nothing():
    assert Groups.of(None) == Groups()
    assert Groups.of({"duffing": 2.0}) == Groups(duffing=2.0)
    own = Groups(deborah=3.0)
    assert Groups.of(own) is own
    for name, preset in PRESETS.items():
        assert Groups.of(name) == preset
    assert Groups.of(Groups(duffing=4.0).to_dict()) == Groups(duffing=4.0)


def test_the_linear_preset_is_linear():
    assert PRESETS["linear"].duffing == PRESETS["linear"].radial_coupling == 0.0


def test_of_names_what_it_does_not_know():
    with pytest.raises(ValueError, match=r"groups .*ecoflex-00-30.*got 'jelly'"):
        Groups.of("jelly")
    with pytest.raises(ValueError, match=r"'stiffness'.*duffing"):
        Groups.of({"stiffness": 1.0})
    with pytest.raises(ValueError, match=r"deborah must be in \(0, inf\), got 0"):
        Groups.of({"deborah": 0})
    with pytest.raises(TypeError, match="groups must be"):
        Groups.of(3.0)


def test_scene_defaults_to_the_ground_with_a_diode():
    assert Scene() == Scene(anchored=False, ratchet=True) == Scene.of(None)
    assert Scene.of({"anchored": True}) == Scene(anchored=True)
    own = Scene(ratchet=False)
    assert Scene.of(own) is own
    assert Scene.of(json.loads(json.dumps(own.to_dict()))) == own


@pytest.mark.parametrize("name", ["anchored", "ratchet"])
@pytest.mark.parametrize("bad", [1, 0, "yes", None])
def test_scene_takes_only_true_and_false(name, bad):
    with pytest.raises(TypeError, match=rf"{name} must be True or False, got {bad!r}"):
        Scene(**{name: bad})


def test_scene_names_what_it_does_not_know():
    with pytest.raises(ValueError, match=r"'friction'.*anchored"):
        Scene.of({"friction": 1})
    with pytest.raises(TypeError, match="scene must be"):
        Scene.of(True)
