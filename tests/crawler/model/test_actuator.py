"""The crawler in SI units: equations 3 to 6, S14 and S15 by hand, and trajectories made dimensional."""

from dataclasses import fields, replace
from math import pi, sqrt

import numpy as np
import pytest
from cases import run, WORD

from stickslip.crawler import Actuator, ChainState, Groups, PRESETS, REST, simulate, State, Trajectory

BY_HAND = {
    "payload_mass": 0.3,
    "foot_mass": 0.1,
    "stiffness": 100.0,
    "cubic_stiffness": 5e4,
    "damping": 0.8,
    "bore_area": 2e-4,
    "peak_pressure": 2e4,
    "lag": 0.03,
    "radial_coupling": 5.0,
    "static_friction": 0.9,
    "kinetic_friction": 0.6,
    "gravity": 10.0,
}


def test_ecoflex_is_the_preset_and_the_default_crawler_to_the_bit():
    assert Actuator.ecoflex().groups == PRESETS["ecoflex-00-30"] == Groups()


def test_ecoflex_is_the_tube_that_its_docstring_describes():
    wall, bore = 1.14e-4, 1.0e-4
    tube = Actuator.from_tube(
        youngs_modulus=70e3,
        outer_radius=sqrt((wall + bore) / pi),
        inner_radius=sqrt(bore / pi),
        density=1070.0,
        length=0.125,
        payload_mass=0.167,
        foot_mass=0.067,
        peak_pressure=20e3,
        lag=0.03125,
        static_friction=0.82,
        kinetic_friction=0.54,
    )
    ecoflex = Actuator.ecoflex()
    for name in ("payload_mass", "foot_mass", "stiffness", "bore_area", "static_friction", "kinetic_friction"):
        assert getattr(ecoflex, name) == pytest.approx(getattr(tube, name), rel=0.01), name
    assert ecoflex.scales == pytest.approx(tube.scales, rel=0.01)
    assert ecoflex.scales == (0.125 / 4, 1 / 16, 2.0, 20e3)


LIMITS = ["payload_mass", "foot_mass", "stiffness", "bore_area", "peak_pressure", "lag", "cubic_stiffness"]
LIMITS += ["damping", "radial_coupling", "static_friction", "gravity"]


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("absurd", [1e-300, 1e-200, 1e-40, 1e40, 1e200, 1e308])
def test_a_magnitude_that_no_body_has_is_refused_by_the_fields_name(name, absurd):
    with pytest.raises(ValueError, match=rf"^{name} must be in .*, got {absurd!r}".replace("+", r"\+")):
        Actuator(**BY_HAND | {"kinetic_friction": 0.0, name: absurd})


def test_what_is_not_refused_has_groups_and_scales():
    """At every corner of the magnitudes allowed."""
    rng = np.random.default_rng(0)
    names = [*LIMITS, "kinetic_friction"]
    made = 0
    for _ in range(3000):
        values = dict(zip(names, rng.choice([1e-37, 1.0, 1e37], len(names)).tolist(), strict=True))
        values["kinetic_friction"] = min(values["kinetic_friction"], values["static_friction"])
        if values["payload_mass"] < 1e-16 * values["foot_mass"]:
            with pytest.raises(ValueError, match=r"^payload_mass must be more than a rounding of foot_mass"):
                Actuator(**values)
            continue
        actuator = Actuator(**values)
        made += 1
        assert np.isfinite([*actuator.groups.to_dict().values(), *actuator.scales, actuator.scales.energy]).all()
        assert min(actuator.scales) > 0.0
    assert made > 1000


@pytest.mark.parametrize("name", ["youngs_modulus", "outer_radius", "inner_radius", "density", "length", "foot_mass"])
@pytest.mark.parametrize("absurd", [1e-200, 1e200])
def test_an_absurd_tube_is_refused_by_the_name_that_was_given(name, absurd):
    if name in ("density", "foot_mass") and absurd < 1.0:
        Actuator.from_tube(**TUBE | {name: absurd})  # as good as none
        return
    with pytest.raises(ValueError, match=f"^{name} must be in"):
        Actuator.from_tube(**TUBE | {name: absurd})


def test_the_thinnest_wall_of_any_tube_makes_an_actuator():
    for radius in (1e-6, 1.0, 1e6):
        for modulus, length in ((1e-3, 1e6), (1e15, 1e-6)):
            thin = {"outer_radius": float(np.nextafter(radius, 2 * radius)), "inner_radius": radius}
            if radius == 1e6:
                thin = {"outer_radius": radius, "inner_radius": float(np.nextafter(radius, 0))}
            Actuator.from_tube(**TUBE | thin | {"youngs_modulus": modulus, "length": length})


def test_groups_and_scales_by_hand():
    actuator = Actuator(**BY_HAND)
    # P_max A_0 = 4 N, so z_c = 4 cm; M = 0.4 kg, so t_c = sqrt(0.004) s.
    assert actuator.scales == pytest.approx((0.04, sqrt(0.004), 4.0, 2e4))
    assert actuator.scales.energy == pytest.approx(0.16)
    expected = {
        "duffing": 5e4 * 0.04**2 / 100.0,
        "damping_ratio": 0.8 / (2.0 * sqrt(0.4 * 100.0)),
        "deborah": 0.03 / sqrt(0.004),
        "radial_coupling": 5.0 * 0.04,
        "foot_mass_fraction": 0.25,
        "static_friction": 0.9 * 0.1 * 10.0 / 4.0,
        "kinetic_friction": 0.6 * 0.1 * 10.0 / 4.0,
    }
    assert actuator.groups.to_dict() == pytest.approx(expected, rel=1e-14)


def test_groups_are_free_of_units():
    # The same crawler in grams, centimetres and milliseconds.
    kg, m, s = 1e3, 1e2, 1e3
    newton, pascal = kg * m / s**2, kg / (m * s**2)
    units = {
        "payload_mass": kg,
        "foot_mass": kg,
        "stiffness": newton / m,
        "cubic_stiffness": newton / m**3,
        "damping": newton * s / m,
        "bore_area": m**2,
        "peak_pressure": pascal,
        "lag": s,
        "radial_coupling": 1.0 / m,
        "static_friction": 1.0,
        "kinetic_friction": 1.0,
        "gravity": m / s**2,
    }
    other = Actuator(**{name: value * units[name] for name, value in BY_HAND.items()})
    assert other.groups.to_dict() == pytest.approx(Actuator(**BY_HAND).groups.to_dict(), rel=1e-12)


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


def test_from_tube_by_hand():
    body = Actuator.from_tube(**TUBE, segments=4)
    wall = pi * (0.01**2 - 0.006**2)
    # N segments of S15 in series, N of S14 in all, half of that at either end.
    assert body.segment_stiffness == pytest.approx(7e4 * wall / (0.11 / 4))
    assert body.stiffness == pytest.approx(7e4 * wall / 0.11)
    segment_mass = 1070.0 * wall * 0.11 / 4
    assert body.payload_mass == pytest.approx(0.2 + 2 * segment_mass)
    assert body.foot_mass == pytest.approx(0.1 + 2 * segment_mass)
    assert body.mass == pytest.approx(0.3 + 4 * segment_mass)
    assert body.bore_area == pytest.approx(pi * 0.006**2)


def test_how_finely_the_tube_is_thought_divided_does_not_change_the_body():
    assert Actuator.from_tube(**TUBE, segments=1).groups == Actuator.from_tube(**TUBE, segments=50).groups


@pytest.mark.parametrize("name", [field.name for field in fields(Actuator) if field.name != "segments"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
def test_refuses_what_is_not_finite_or_negative(name, bad):
    with pytest.raises(ValueError, match=rf"{name} must be in .*, got {bad!r}"):
        Actuator(**BY_HAND | {name: bad})


@pytest.mark.parametrize("name", ["payload_mass", "foot_mass", "stiffness", "bore_area", "peak_pressure", "lag"])
def test_refuses_zero_where_it_would_divide(name):
    with pytest.raises(ValueError, match=rf"{name} must be in \(0, inf\), got 0"):
        Actuator(**BY_HAND | {name: 0.0})


def test_refuses_more_kinetic_than_static_friction():
    with pytest.raises(ValueError, match=r"kinetic_friction must be in \[0, static_friction = 0\.9\], got 1"):
        Actuator(**BY_HAND | {"kinetic_friction": 1.0})


@pytest.mark.parametrize(("bad", "error"), [(0, ValueError), (-1, ValueError), (1.5, TypeError), (True, TypeError)])
def test_refuses_a_broken_number_of_segments(bad, error):
    with pytest.raises(error, match=r"segments must be .*>= 1, got"):
        Actuator(**BY_HAND, segments=bad)


def test_refuses_words():
    with pytest.raises(TypeError, match=r"stiffness must be a number .*'soft'"):
        Actuator(**BY_HAND | {"stiffness": "soft"})


@pytest.mark.parametrize("change", [{"inner_radius": 0.01}, {"inner_radius": 0.02}, {"inner_radius": 0.0}])
def test_refuses_a_tube_without_wall_or_bore(change):
    with pytest.raises(ValueError, match="inner_radius must be in"):
        Actuator.from_tube(**TUBE | change)


@pytest.mark.parametrize("name", ["youngs_modulus", "outer_radius", "length", "density"])
def test_refuses_a_tube_of_nothing(name):
    with pytest.raises(ValueError, match=f"{name} must be in"):
        Actuator.from_tube(**TUBE | {name: -1.0})


def test_a_trajectory_in_si_is_scaled_throughout():
    actuator = Actuator(**BY_HAND)
    natural = run(actuator.groups, WORD * 2, 1.0, samples_per_hold=3)
    si = natural.in_si(actuator)
    length, time, force, pressure = actuator.scales
    factors = {
        "time": time,
        "hold": time,
        "deformation": length,
        "foot": length,
        "payload": length,
        "velocity": length / time,
        "foot_velocity": length / time,
        "pressure": pressure,
        "work": force * length,
        "stored": force * length,
        "viscous_loss": force * length,
        "friction_loss": force * length,
        "dissipation": force * length,
    }
    for name, factor in factors.items():
        np.testing.assert_allclose(getattr(si, name), getattr(natural, name) * factor, rtol=1e-14, err_msg=name)
    np.testing.assert_allclose(si.events["time"], natural.events["time"] * time, rtol=1e-15)
    np.testing.assert_array_equal(si.events["mode"], natural.events["mode"])
    assert si.slips == natural.slips
    assert si.actuator is actuator
    # The original is left as it was.
    assert natural.actuator is None
    assert natural.events["time"][-1] <= natural.time[-1]


SI_FIELD_OF = {
    "cubic_stiffness": "duffing",
    "damping": "damping_ratio",
    "lag": "deborah",
    "radial_coupling": "radial_coupling",
    "payload_mass": "damping_ratio",
    "static_friction": "static_friction",
    "gravity": "static_friction",
}


def test_in_si_obeys_newton():
    # While the foot sticks, the payload's acceleration in SI is the force in SI over its mass.
    actuator = Actuator(**BY_HAND)
    fine = run(actuator.groups, [1], 0.2, samples_per_hold=200, tolerance=1e-14).in_si(actuator)
    z, v, p = fine.deformation, fine.velocity, fine.pressure
    force = p * actuator.bore_area * (1.0 + actuator.radial_coupling * z)
    force -= actuator.stiffness * z + actuator.cubic_stiffness * z**3 + actuator.damping * v
    assert not fine.slips
    acceleration = np.gradient(v, fine.time)[1:-1]
    np.testing.assert_allclose(actuator.payload_mass * acceleration, force[1:-1], rtol=1e-3, atol=1e-6)


def test_in_si_refuses_an_actuator_of_other_groups():
    actuator = Actuator(**BY_HAND)
    done = run(actuator.groups, WORD, 1.0)
    for name, group in SI_FIELD_OF.items():
        other = replace(actuator, **{name: 1.001 * getattr(actuator, name)})
        with pytest.raises(ValueError, match=f"actuator must have the groups that were simulated, {group} = "):
            done.in_si(other)


def test_in_si_takes_another_actuator_of_the_same_groups_but_for_roundings():
    actuator = Actuator(**BY_HAND)
    done = run(actuator.groups, WORD, 1.0)
    # Everything twice as heavy, stiff and strong: the same motion.
    doubled = ["payload_mass", "foot_mass", "stiffness", "cubic_stiffness", "damping", "peak_pressure"]
    twice = replace(actuator, **{name: 2.0 * getattr(actuator, name) for name in doubled})
    assert done.in_si(twice).work == pytest.approx(2.0 * done.in_si(actuator).work)
    rounded = replace(actuator.groups, duffing=float(np.nextafter(actuator.groups.duffing, 1.0)))
    run(rounded, WORD, 1.0).in_si(actuator)


def test_in_si_looks_at_every_crawler_of_a_batch():
    actuator = Actuator(**BY_HAND)
    simulate([actuator, actuator.groups], WORD, 1.0).in_si(actuator)
    with pytest.raises(ValueError, match=r"groups that were simulated, deborah = 0\.7 of crawler 1, got 0\.474"):
        simulate([actuator, replace(actuator.groups, deborah=0.7)], WORD, 1.0).in_si(actuator)


def test_the_start_is_kept_and_scaled():
    actuator = Actuator(**BY_HAND)
    length, time, _, pressure = actuator.scales
    factors = [length, length / time, pressure, length, length / time]
    start = State(0.1, 0.2, 0.3, 0.4, 0.5)
    done = simulate(actuator, WORD, 1.0, initial=start)
    assert done.initial == start
    assert done.in_si(actuator).initial == pytest.approx([a * b for a, b in zip(start, factors, strict=True)])
    chain = ChainState([0.1, 0.2], [0.0, 0.3], 0.5)
    done = simulate(actuator, WORD, 1.0, scene={"segments": 2, "tube_mass": 0.2}, initial=chain).in_si(actuator)
    assert done.initial.segment_deformation == pytest.approx([0.1 * length, 0.2 * length])
    assert done.initial.pressure == pytest.approx(0.5 * pressure)
    assert run(Groups(), WORD, 1.0).initial == REST


def test_in_si_twice_is_refused():
    actuator = Actuator.ecoflex()
    si = run(Groups(), [1, 0], 1.0).in_si(actuator)
    with pytest.raises(ValueError, match="in SI already"):
        si.in_si(actuator)


def test_every_array_of_a_trajectory_is_documented_and_present():
    done = run(Groups(), WORD, 1.0)
    assert isinstance(done, Trajectory)
    assert replace(done).foot is done.foot
    for name in ("time", "deformation", "velocity", "pressure", "foot", "foot_velocity", "payload"):
        assert getattr(done, name).shape == (8,)
        assert getattr(done, name).dtype == np.float64
    assert done.valve.tolist() == WORD
    assert isinstance(done.slips, int)
    for name in ("work", "stored", "viscous_loss", "friction_loss", "dissipation", "energy_residual"):
        assert np.ndim(getattr(done, name)) == 0
    assert "taylor" in done.model
