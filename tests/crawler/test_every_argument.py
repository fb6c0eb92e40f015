"""Every optional argument of what `stickslip.crawler` offers is changed, and does what it says."""

import inspect
import math
from dataclasses import fields
from unittest.mock import patch

import numpy as np
import pytest
from cases import WORD
from judge import judge

from stickslip.common.sharing import processors, share
from stickslip.crawler import Actuator, ChainState, Groups, PRESETS, REST, Scene, simulate, SolverError, State
from stickslip.crawler.batch import driving

SHORT = 1e-4
CHAIN = {"segments": 2, "tube_mass": 0.5}


def optional(function):
    """Names of the arguments that have a default."""
    return {
        name
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.default is not inspect.Parameter.empty
    }


# simulate


def scene_changes_the_world():
    anchored, uphill = (simulate({}, WORD, 1.0, scene=scene) for scene in ({"anchored": True}, {"slope": 0.2}))
    plain = simulate({}, WORD, 1.0)
    assert not anchored.foot.any()
    assert 0.0 < uphill.foot[-1] < plain.foot[-1]


def tolerance_bounds_the_error():
    verdict = judge(Groups(), WORD, 1.0)
    errors = [
        np.abs(simulate({}, WORD, 1.0, solver="taylor", tolerance=tolerance).foot - verdict.foot).max()
        for tolerance in (1e-2, 1e-5, 1e-8)
    ]
    for error, tolerance in zip(errors, (1e-2, 1e-5, 1e-8), strict=True):
        assert 1e-4 * tolerance < error < tolerance


def solver_is_the_one_asked_for():
    for name in ("closed_form", "taylor", "radau"):
        assert simulate("linear", WORD, 1.0, solver=name).model == f"on the ground, {name.replace('_', ' ')}"


def samples_per_hold_are_as_many_and_where_they_belong():
    often, once = (simulate({}, WORD, 1.0, samples_per_hold=n) for n in (4, 1))
    np.testing.assert_allclose(often.time, 0.25 * np.arange(1, 33), rtol=1e-15)
    np.testing.assert_array_equal(often.foot[3::4], once.foot)


def initial_is_where_it_starts():
    start = State(0.3, -0.2, 0.6, 5.0, 0.4)
    done = simulate({}, [1], SHORT, initial=start)
    moved = [start.deformation - 0.2 * SHORT, start.foot + 0.4 * SHORT]
    assert [done.deformation[0], done.foot[0]] == pytest.approx(moved, abs=1e-7)
    assert [done.velocity[0], done.pressure[0], done.foot_velocity[0]] == pytest.approx([-0.2, 0.6, 0.4], abs=1e-3)
    chain = simulate({}, [1], SHORT, scene=CHAIN, initial=ChainState([0.1, 0.3], [0.2, -0.5], 0.6, 5.0, 0.4))
    assert chain.segment_deformation[:, 0] == pytest.approx([0.1, 0.3], abs=1e-4)
    assert chain.segment_velocity[:, 0] == pytest.approx([0.2, -0.5], abs=2e-3)
    assert [chain.pressure[0], chain.foot[0], chain.foot_velocity[0]] == pytest.approx([0.6, 5.0, 0.4], abs=2e-3)
    assert [chain.deformation[0], chain.velocity[0]] == pytest.approx([0.4, -0.3], abs=1e-3)
    # Of a State all segments are stretched alike.
    alike = simulate({}, [1], SHORT, scene=CHAIN, initial=start)
    assert alike.segment_deformation[:, 0] == pytest.approx([0.15, 0.15], abs=1e-4)
    assert alike.segment_velocity[:, 0] == pytest.approx([-0.1, -0.1], abs=2e-3)


def max_steps_is_the_budget():
    with pytest.raises(SolverError, match=r"^the step budget of 7 was spent at time "):
        simulate({}, WORD, 1.0, max_steps=7)
    with pytest.raises(ValueError, match=r"^max_steps must be a whole number >= 1, got 0$"):
        simulate({}, WORD, 1.0, max_steps=0)


def condition_is_found_where_asked_for():
    assert simulate({}, WORD, 1.0, condition=False).condition is None
    # Nothing but a decay by damping: of a body that swings alone the start is forgotten.
    forgotten = simulate({"damping_ratio": 0.5}, [0], 60.0, scene={"anchored": True}, condition=True)
    assert forgotten.condition < 1e-10


def threads_share_a_batch():
    for given, used in ((3, 3), (1, 1), (None, processors())):
        with patch.object(driving, "share", wraps=share) as shared:
            simulate({}, [WORD, WORD], 1.0, threads=given)
        assert shared.call_args.args[2] == used


SIMULATE = {
    "scene": scene_changes_the_world,
    "tolerance": tolerance_bounds_the_error,
    "solver": solver_is_the_one_asked_for,
    "samples_per_hold": samples_per_hold_are_as_many_and_where_they_belong,
    "initial": initial_is_where_it_starts,
    "max_steps": max_steps_is_the_budget,
    "condition": condition_is_found_where_asked_for,
    "threads": threads_share_a_batch,
}


def test_no_argument_of_simulate_is_left_out():
    assert optional(simulate) == set(SIMULATE)


@pytest.mark.parametrize("name", SIMULATE)
def test_an_argument_of_simulate(name):
    SIMULATE[name]()


def test_defaults_of_simulate_are_those_of_its_page():
    plain = simulate({}, WORD, 1.0)
    written = simulate(
        Groups(), WORD, 1.0, scene=Scene(), tolerance=1e-9, solver="auto", samples_per_hold=1, initial=REST
    )
    np.testing.assert_array_equal(plain.foot, written.foot)
    assert plain.model == written.model
    assert plain.initial == REST == State(0.0, 0.0, 0.0, 0.0, 0.0)
    coarse = simulate({}, WORD, 1.0, tolerance=1.001e-9)
    assert not np.array_equal(plain.foot, coarse.foot)


@pytest.mark.parametrize(("holds", "hold"), [(1, 1e4), (2, 1e4), (7, 30.0)])
def test_the_budget_by_default_is_a_million_steps_and_a_thousand_a_hold(holds, hold):
    with pytest.raises(SolverError, match=rf"^the step budget of {1_000_000 + 1000 * holds} was spent"):
        simulate({"damping_ratio": 1e8}, [1] * holds, hold, solver="taylor", tolerance=1e-2)


# Groups and scenes


EFFECTS = {
    # Each on its own, from z = 0.5, v = 0.25, p = 0.5 over a resting foot: F = p (1 + Pi5 z) - z - Pi1 z^3 - 2 Pi2 v,
    # v' = F / (1 - r), p' = (u - p) / Pi4.
    "duffing": (2.0, {"velocity": -2.0 * 0.5**3}),
    "damping_ratio": (0.4, {"velocity": -2.0 * 0.4 * 0.25}),
    "radial_coupling": (0.8, {"velocity": 0.5 * 0.8 * 0.5}),
    "deborah": (0.1, {"pressure": 0.5 / 0.1 - 0.5}),
    "foot_mass_fraction": (0.8, {}),
}
BARE = {"duffing": 0.0, "damping_ratio": 0.0, "radial_coupling": 0.0, "deborah": 1.0, "foot_mass_fraction": 0.5}


@pytest.mark.parametrize("name", EFFECTS)
@pytest.mark.parametrize("solver", ["taylor", "radau"])
def test_a_group_acts_as_the_equations_say(name, solver):
    value, changes = EFFECTS[name]
    start = State(0.5, 0.25, 0.5)
    heavy = {"static_friction": 9.0}  # holds the foot
    rates = []
    for groups in (BARE, BARE | {name: value}):
        done = simulate(groups | heavy, [1], SHORT, initial=start, solver=solver, tolerance=1e-13)
        rates.append({key: (getattr(done, key)[0] - getattr(start, key)) / SHORT for key in ("velocity", "pressure")})
    before, after = rates
    assert before["velocity"] == pytest.approx((0.5 - 0.5) / 0.5, abs=2e-3)
    for key, change in changes.items():
        unit = 1.0 - BARE["foot_mass_fraction"] if key == "velocity" else 1.0
        assert after[key] - before[key] == pytest.approx(change / unit, abs=5e-3)
    if name == "foot_mass_fraction":
        # The payload's share: at z = 0 all of p = 0.5 accelerates it.
        for share in (0.5, 0.8):
            done = simulate(BARE | heavy | {name: share}, [0], SHORT, initial=State(pressure=0.5), solver=solver)
            assert done.velocity[0] / SHORT == pytest.approx(0.5 / (1.0 - share), rel=1e-3)


@pytest.mark.parametrize("solver", ["closed_form", "taylor", "radau"])
def test_frictions_act_as_the_equations_say(solver):
    # Stretched by z and at rest, the body pulls with z: above s the foot slides with w' = (z - k) / r.
    groups = {"duffing": 0.0, "damping_ratio": 0.0, "radial_coupling": 0.0, "foot_mass_fraction": 0.5}
    for static, kinetic, stretch in ((0.4, 0.1, 0.39), (0.4, 0.1, 0.41), (0.5, 0.1, 0.45), (0.4, 0.3, 0.41)):
        frictions = {"static_friction": static, "kinetic_friction": kinetic}
        done = simulate(groups | frictions, [0], SHORT, initial=State(stretch, -1e-9), solver=solver, tolerance=1e-12)
        expected = (stretch - kinetic) / 0.5 if stretch > static else 0.0
        assert done.foot_velocity[0] / SHORT == pytest.approx(expected, abs=1e-3)
        assert done.slips == (stretch > static)


@pytest.mark.parametrize("scene", [{}, CHAIN, {"tube_mass": 0.5}], ids=str)
def test_a_slope_pulls_backward_uphill(scene):
    """Without friction and spring force the whole crawler falls with the slope, whatever it is made of."""
    free = {"static_friction": 0.0, "kinetic_friction": 0.0, "duffing": 0.0}
    for slope in (0.3, -0.3):
        mass = 1.0 + scene.get("tube_mass", 0.0)
        done = simulate(free, [0], 2.0, scene={"ratchet": False, "slope": slope} | scene, tolerance=1e-13)
        way = done.foot[0] * 0.3 + done.payload[0] * 0.7
        if scene:
            middle = np.cumsum([done.foot[0], *done.segment_deformation[:, 0]])
            weights = np.full(len(middle), 0.5 / (len(middle) - 1))
            weights[[0, -1]] *= 0.5
            way = (way + weights @ middle) / mass
        assert way == pytest.approx(-0.5 * slope * 2.0**2, abs=1e-11)


def test_no_group_and_no_field_of_a_scene_is_left_out():
    assert {field.name for field in fields(Groups)} == {*EFFECTS, "static_friction", "kinetic_friction"}
    assert {field.name for field in fields(Scene)} == {"anchored", "ratchet", "slope", "segments", "tube_mass"}
    assert Scene() == Scene(anchored=False, ratchet=True, slope=0.0, segments=1, tube_mass=0.0)


def test_a_ratchet_lets_the_foot_forward_only():
    pulled, pushed = State(deformation=0.9), State(deformation=-0.9)
    for ratchet in (True, False):
        forward = simulate({}, [0], 0.5, scene={"ratchet": ratchet}, initial=pulled)
        backward = simulate({}, [0], 0.5, scene={"ratchet": ratchet}, initial=pushed)
        assert forward.foot[0] > 0.01
        assert (backward.foot[0] < -0.01) == (not ratchet)
        assert ratchet == (backward.foot[0] == 0.0)


def test_the_presets():
    changed = {
        name: {key: value for key, value in groups.to_dict().items() if value != getattr(Groups(), key)}
        for name, groups in PRESETS.items()
    }
    assert changed == {
        "ecoflex-00-30": {},
        "linear": {"duffing": 0.0, "radial_coupling": 0.0},
        "high-damping": {"damping_ratio": 0.5},
        "aggressive-forcing": {"duffing": 5.0, "radial_coupling": 0.5},
        "extreme-fluid-lag": {"deborah": 5.0},
        "fast-valve": {"deborah": 0.1},
        "low-friction": {"static_friction": 0.15, "kinetic_friction": 0.1},
    }


# Actuators


BASE = {
    "payload_mass": 0.3,
    "foot_mass": 0.1,
    "stiffness": 100.0,
    "bore_area": 2e-4,
    "peak_pressure": 2e4,
    "lag": 0.03,
    "static_friction": 0.9,
    "kinetic_friction": 0.6,
}
# P_max A_0 = 4 N, z_c = 4 cm, M = 0.4 kg, t_c = sqrt(0.004) s.
ACTUATOR = {
    "cubic_stiffness": (5e4, {"duffing": 5e4 * 0.04**2 / 100.0}),
    "damping": (0.8, {"damping_ratio": 0.8 / (2.0 * math.sqrt(40.0))}),
    "radial_coupling": (5.0, {"radial_coupling": 0.2}),
    "gravity": (1.62, {"static_friction": 0.9 * 0.1 * 1.62 / 4.0, "kinetic_friction": 0.6 * 0.1 * 1.62 / 4.0}),
    "segments": (5, {}),
}
TUBE = {
    "youngs_modulus": 7e4,
    "outer_radius": 0.01,
    "inner_radius": 0.006,
    "density": 1070.0,
    "length": 0.11,
    "payload_mass": 0.2,
    "foot_mass": 0.1,
    "peak_pressure": 3e4,
    "lag": 0.02,
    "static_friction": 1.0,
    "kinetic_friction": 0.8,
}


def test_no_argument_of_an_actuator_is_left_out():
    assert optional(Actuator) == set(ACTUATOR)
    assert optional(Actuator.from_tube) == {*ACTUATOR, "tube_share"}


@pytest.mark.parametrize("name", ACTUATOR)
def test_an_argument_of_an_actuator(name):
    value, changed = ACTUATOR[name]
    plain, other = Actuator(**BASE), Actuator(**BASE, **{name: value})
    expected = plain.groups.to_dict() | changed
    assert other.groups.to_dict() == pytest.approx(expected, rel=1e-14)
    assert getattr(other, name) == value
    if name != "segments":
        assert expected != pytest.approx(plain.groups.to_dict(), rel=1e-3)
    assert other.segment_stiffness == (500.0 if name == "segments" else 100.0)


def test_an_actuator_by_default_is_linear_undamped_and_on_earth():
    groups = Actuator(**BASE).groups
    assert groups.duffing == groups.damping_ratio == groups.radial_coupling == 0.0
    assert groups.static_friction == pytest.approx(0.9 * 0.1 * 9.80665 / 4.0, rel=1e-14)


@pytest.mark.parametrize("changes", [{name: value} for name, (value, _) in ACTUATOR.items()] + [{}], ids=str)
def test_a_tube_hands_every_argument_on(changes):
    """Lumped by hand."""
    wall, bore = math.pi * (0.01**2 - 0.006**2), math.pi * 0.006**2
    half = 0.5 * 1070.0 * wall * 0.11
    expected = Actuator(
        payload_mass=0.2 + half,
        foot_mass=0.1 + half,
        stiffness=7e4 * wall / 0.11,
        bore_area=bore,
        peak_pressure=3e4,
        lag=0.02,
        static_friction=1.0,
        kinetic_friction=0.8,
        **changes,
    )
    made = Actuator.from_tube(**TUBE, **changes)
    for field in fields(Actuator):
        assert getattr(made, field.name) == pytest.approx(getattr(expected, field.name), rel=1e-14), field.name


@pytest.mark.parametrize("share", [0.0, 1.0 / 3.0, 0.5])
def test_either_end_bears_a_share_of_the_tube(share):
    mass = 1070.0 * math.pi * (0.01**2 - 0.006**2) * 0.11
    made = Actuator.from_tube(**TUBE, tube_share=share)
    assert made.payload_mass == pytest.approx(0.2 + share * mass, rel=1e-14)
    assert made.foot_mass == pytest.approx(0.1 + share * mass, rel=1e-14)
    with pytest.raises(ValueError, match=r"^tube_share must be in \[0, 0.5\], got 0.6"):
        Actuator.from_tube(**TUBE, tube_share=0.6)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("youngs_modulus", 1e-3, 1e15),
        ("outer_radius", None, 1e6),
        ("inner_radius", 1e-6, None),
        ("length", 1e-6, 1e6),
        ("density", 0.0, 1e15),
        ("payload_mass", 0.0, 1e15),
        ("foot_mass", 0.0, 1e15),
    ],
)
def test_the_ends_of_what_a_tube_may_measure(name, low, high):
    for end, beyond in ((low, 0.99), (high, 1.01)):
        if end is not None:
            Actuator.from_tube(**TUBE | {name: end})
        if end:
            with pytest.raises(ValueError, match=rf"^{name} must be in \["):
                Actuator.from_tube(**TUBE | {name: beyond * end})


def test_the_ends_of_what_an_actuator_may_be():
    for name in ("stiffness", "lag", "damping", "gravity"):
        for end, beyond in ((1e-37, 0.99e-37), (1e37, 1.01e37)):
            Actuator(**BASE | {name: end})
            with pytest.raises(ValueError, match=rf"^{name} must be in \[1e-37, 1e37\], got "):
                Actuator(**BASE | {name: beyond})
