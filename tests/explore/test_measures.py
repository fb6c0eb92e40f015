"""What takes a long run, against the measures of the laboratory."""

import numpy as np

from stickslip.explore.measures import DELAYS, exponents_of, LONG, long_run, profile_of
from stickslip.explore.presets import preset
from stickslip.explore.setup import setup_of
from stickslip.train.schedules import performance, repeat


def test_speed_and_memory_are_those_of_every_schedule():
    setup = preset("slow-word")
    command, valve = repeat("11100", LONG, dither=0.1, seed=0)
    same = performance(
        command, valve, dither=0.1, groups=setup.groups, hold=0.5, scene=setup.scene, tolerance=setup.tolerance
    )
    found = long_run(setup)
    assert found.speed == same.speed
    assert found.memory.corrected == same.memory.corrected
    assert found.doubt == ""
    profile = profile_of(found.memory)
    np.testing.assert_array_equal(profile["capacity"], same.memory.profile)
    np.testing.assert_array_equal(profile["delay"], np.arange(DELAYS))
    assert profile["capacity"][profile["found"] > 0].sum() == found.memory.corrected


def test_where_flips_are_few_or_none_it_is_said():
    none = long_run(preset("clean-gait"))
    assert none.memory is None
    assert none.speed > 0.9
    assert all(len(column) == 0 for column in profile_of(none.memory).values())
    few = long_run(setup_of({"dither": 0.01}))
    assert "scored samples are few" in few.doubt
    assert few.memory is not None
    hardly_any = long_run(setup_of({"dither": 1e-5}))
    assert hardly_any.memory is None
    assert "flips are so rare" in hardly_any.doubt


def test_the_exponents_of_a_linear_body_that_sticks_are_its_damping():
    # So little pressure reaches a foot that holds: z'' = (F) / (1 - r) with F = p - z - 2 Pi2 v.
    setup = setup_of({"duffing": 0.0, "radial_coupling": 0.0, "static_friction": 1.0, "kinetic_friction": 1.0})
    setup = setup_of({"damping_ratio": 0.3}, setup)
    valve = repeat("10", 1000)[1]
    found = exponents_of(setup, valve)
    rate = -setup.groups.damping_ratio / (1 - setup.groups.foot_mass_fraction)
    np.testing.assert_allclose(found.exponents, [rate, rate], rtol=0.02)
    assert found.verdict == "contracting"
