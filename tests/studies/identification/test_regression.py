"""The law by a regression that knows of slips, and slips found in noise."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip import Groups, simulate
from stickslip.studies.identification import Measurements, regress
from stickslip.studies.identification.regression import payload_law, sliding
from stickslip.tasks import random_bits

CHANNELS = ("deformation", "velocity", "pressure", "foot_velocity")
STIFF = Groups(duffing=50.0)


def run_of(groups, noise, seed=0, valve=None):
    motion = simulate(groups, random_bits(200, seed) if valve is None else valve, 1.0, samples_per_hold=50)
    return motion, Measurements.of(motion, *CHANNELS, noise=noise, seed=seed)


def test_without_noise_every_group_is_found_to_a_thousandth():
    groups = regress(run_of(Groups(), 0.0)[1]).groups
    for name, value in Groups().to_dict().items():
        assert getattr(groups, name) == pytest.approx(value, rel=1e-3), name


@pytest.mark.parametrize("groups", [Groups(), STIFF], ids=["default", "stiff"])
def test_at_one_percent_noise_unseen_holds_are_foretold_through_slips_that_were_found(groups):
    found = regress(run_of(groups, 0.01)[1]).groups
    unseen = random_bits(200, 99)
    true, told = (simulate(each, unseen, 1.0, samples_per_hold=50).deformation for each in (groups, found))
    assert np.mean((true - told) ** 2) / true.var() < 1e-4


def test_a_valley_of_a_wrong_count_of_slips_is_not_taken_for_the_static_friction():
    # Beside 0.2998, the deepest, there is a valley at 0.3085, in which what is left is three times as large.
    motion = simulate(STIFF, random_bits(200, [4, 0]), 1.0, samples_per_hold=50)
    found = regress(Measurements.of(motion, *CHANNELS, noise=0.01, seed=4)).groups
    assert found.static_friction == pytest.approx(STIFF.static_friction, rel=0.01)


def test_slides_are_found_in_noise():
    motion, run = run_of(STIFF, 0.01)
    truth = motion.foot_velocity > 0.0
    found = regress(run).sliding
    assert np.mean(found != truth) < 0.05
    np.testing.assert_array_equal(found, sliding(run.foot_velocity))


def test_phases_that_are_known_are_taken():
    motion, run = run_of(Groups(), 0.01)
    known = motion.foot_velocity > 0.0
    law = regress(run, phases=known)
    np.testing.assert_array_equal(law.sliding, known)
    assert law.groups.kinetic_friction == pytest.approx(0.2, rel=5e-3)


def test_duty_cycles_are_pressures_too():
    _, run = run_of(Groups(deborah=0.3), 0.0, valve=np.random.default_rng(0).random(100))
    assert regress(run).groups.deborah == pytest.approx(0.3, rel=1e-6)


def test_the_weak_form_finds_the_terms_of_a_forced_oscillator():
    t = np.arange(0.0, 40.0, 0.02)
    x, v = np.sin(t) + 0.3 * np.cos(2.3 * t), np.cos(t) - 0.69 * np.sin(2.3 * t)
    drive = 0.5 * np.sin(t) - 0.3 * (2.3**2 - 1.5) * np.cos(2.3 * t)  # x'' = -1.5 x + drive
    found = payload_law(np.stack([x, drive]), v, 0.02, 0.4)
    np.testing.assert_allclose(found, [-1.5, 1.0], rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"velocity": None}, "these lack velocity in all samples"),
        ({"deformation": "gap"}, "these lack deformation in all samples"),
    ],
)
def test_refuses_measurements_that_lack_something(change, message):
    _, run = run_of(Groups(), 0.0)
    if change.get("deformation") == "gap":
        change = {"deformation": np.where(np.arange(run.times.size) == 5, np.nan, run.deformation)}
    with pytest.raises(ValueError, match=message):
        regress(replace(run, times=None, **change))


def test_refuses_a_foot_that_never_slides_and_bumps_that_do_not_fit():
    _, run = run_of(Groups(static_friction=9.0), 0.0)
    with pytest.raises(ValueError, match="the foot must slide for 7 samples at least once"):
        regress(run)
    with pytest.raises(ValueError, match="support must be of 2 samples or more"):
        regress(run_of(Groups(), 0.0)[1], support=0.01)
