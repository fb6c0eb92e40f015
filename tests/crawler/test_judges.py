"""The solver against independent implementations: the check value, and crawlers from all over the ranges."""

from decimal import Decimal

import numpy as np
import pytest
from cases import assert_agrees, crawlers, HUNT, is_free, random_crawler, run, schedules, starts, WORD
from decimal_judge import as_written, decimal_judge
from hypothesis import assume, given
from hypothesis import strategies as st
from judge import judge

from stickslip.crawler import Groups, Scene, simulate, State

FOOT = Decimal("32.03368882790800707974502")  # default groups, hold 1, from rest, after WORD x 25
# Below this, the judges' own rounding may decide whether an event happens.
UNDECIDED = 1e-7
STIFF = {14, 17}  # crawlers that take the judge long


def test_check_value_is_that_of_forty_digit_arithmetic():
    verdict = decimal_judge(Groups(), WORD * 25, 1.0, number=as_written)
    assert abs(verdict.last_foot - FOOT) < Decimal("1e-23")
    assert verdict.slips == 50


def test_check_value_is_met():
    done = run(Groups(), WORD * 25, 1.0, tolerance=1e-15)
    assert done.foot[-1] == pytest.approx(float(FOOT), abs=1e-12)
    assert done.slips == 50


def test_error_falls_with_tolerance_all_the_way():
    errors = []
    for digits in range(3, 16):
        done = simulate(Groups(), WORD * 25, 1.0, tolerance=10.0**-digits)
        assert done.slips == 50
        errors.append(abs(done.foot[-1] - float(FOOT)))
        assert errors[-1] <= 10.0**-digits + 1e-13
    # One lucky error may be far below its tolerance, so each decade is held to the worst of those that follow it.
    worst = np.maximum.accumulate(errors[::-1])[::-1]
    assert (worst[2:-2] <= 0.1 * worst[:-4]).all()


def test_judges_agree_with_each_other():
    done, exact = (by(Groups(), WORD * 2, 1.0, samples_per_hold=3) for by in (judge, decimal_judge))
    np.testing.assert_allclose(done.foot, exact.foot, rtol=0, atol=1e-11)
    np.testing.assert_allclose([float(t) for t, _ in exact.events], [t for t, _ in done.events], rtol=0, atol=1e-11)


@pytest.mark.parametrize("scene", [Scene(), Scene(ratchet=False), Scene(anchored=True)], ids=str)
def test_agrees_with_scipy_in_motion_and_energies(scene):
    done = run(Groups(), WORD * 3, 1.0, scene=scene, samples_per_hold=4, tolerance=1e-14)
    verdict = judge(Groups(), WORD * 3, 1.0, scene=scene, samples_per_hold=4)
    assert_agrees(done, verdict, atol=1e-10)
    # The judge's work is the quadrature of p (1 + Pi5 z) z'.
    for energy in ("work", "viscous_loss", "friction_loss"):
        assert getattr(done, energy) == pytest.approx(getattr(verdict, energy), abs=1e-10)


@pytest.mark.parametrize("seed", sorted({*range(30)} - STIFF))
def test_agrees_with_decimal_arithmetic_from_anywhere_in_the_ranges(seed):
    groups, valve, hold, options = random_crawler(np.random.default_rng(seed), anchored=seed % 10 == 0)
    done = run(groups, valve, hold, tolerance=1e-13, **options)
    verdict = decimal_judge(groups, valve, hold, **options)
    if verdict.clearance > UNDECIDED:
        assert_agrees(done, verdict, atol=1e-8, free=is_free(groups, options["scene"]))
    else:
        np.testing.assert_allclose(done.foot, verdict.foot, rtol=0, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*STIFF, *range(1000, 1030)])
def test_agrees_with_decimal_arithmetic_from_anywhere_in_the_ranges_at_length(seed):
    test_agrees_with_decimal_arithmetic_from_anywhere_in_the_ranges(seed)


@HUNT
@given(groups=crawlers, valve=schedules, hold=st.floats(0.05, 4.0), initial=starts, ratchet=st.booleans())
def test_agrees_with_scipy_over_random_groups(groups, valve, hold, initial, ratchet):
    scene = Scene(ratchet=ratchet)
    options = {"scene": scene, "initial": initial, "samples_per_hold": 2}
    done = run(groups, valve, hold, tolerance=1e-13, **options)
    verdict = judge(groups, valve, hold, **options)
    assume(verdict.clearance > UNDECIDED)
    try:
        assert_agrees(done, verdict, atol=1e-7, free=is_free(groups, scene))
    except AssertionError:
        # SciPy looks for events between its own steps and can miss a short slip: 40 digits decide who did.
        exact = decimal_judge(groups, valve, hold, **options)
        assert_agrees(done, exact, atol=1e-7, free=is_free(groups, scene))
        return
    assert done.work == pytest.approx(verdict.work, abs=1e-7)
    assert done.viscous_loss == pytest.approx(verdict.viscous_loss, abs=1e-7)
    assert done.friction_loss == pytest.approx(verdict.friction_loss, abs=1e-7)


@pytest.mark.parametrize("ratio", [1e-6, 1.0 - 1e-6])
@pytest.mark.parametrize("ratchet", [True, False])
def test_a_foot_of_hardly_any_or_nearly_all_the_mass(ratio, ratchet):
    groups = Groups(foot_mass_fraction=ratio)
    options = {"scene": Scene(ratchet=ratchet), "initial": State(deformation=1.0)}
    # The fast motion is of a thousand radians a unit of time, so a fiftieth of one holds several of its periods.
    done = run(groups, [1, 0], 0.02, tolerance=1e-14, **options)
    verdict = decimal_judge(groups, [1, 0], 0.02, **options)
    assert verdict.clearance > UNDECIDED
    assert_agrees(done, verdict, atol=1e-9)


@pytest.mark.parametrize("deborah", [1e-6, 1e-3, 1e3, 1e6])
def test_a_fluid_that_is_almost_instant_or_almost_still(deborah):
    groups, initial = Groups(deborah=deborah), State(pressure=0.5, deformation=0.4)
    done = run(groups, [1, 0], 3.0, tolerance=1e-14, initial=initial, samples_per_hold=3)
    verdict = judge(groups, [1, 0], 3.0, initial=initial, samples_per_hold=3)
    assert_agrees(done, verdict, atol=1e-9)


def test_a_very_short_hold():
    initial = State(deformation=0.9)
    done = run(Groups(), [0, 1], 1e-9, tolerance=1e-14, initial=initial, samples_per_hold=2)
    assert_agrees(done, decimal_judge(Groups(), [0, 1], 1e-9, initial=initial, samples_per_hold=2), atol=1e-15)


def test_a_very_long_hold():
    # Undamped and without friction under the payload, the anchored body goes on for ever.
    groups, initial = Groups(damping_ratio=0.0, kinetic_friction=0.0), State(deformation=0.9)
    done = run(groups, [1], 100.0, tolerance=1e-14, initial=initial, samples_per_hold=2)
    assert_agrees(done, decimal_judge(groups, [1], 100.0, initial=initial, samples_per_hold=2), atol=1e-10)
    longer = run(groups, [1], 1e3, tolerance=1e-14, initial=initial, samples_per_hold=10)
    assert longer.foot[0] == pytest.approx(done.foot[-1], abs=1e-10)
    pieces = run(groups, [1] * 1000, 1.0, tolerance=1e-14, initial=initial)
    assert longer.slips == pieces.slips
    np.testing.assert_allclose(longer.foot, pieces.foot[99::100], rtol=0, atol=1e-8)
