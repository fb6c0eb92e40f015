"""Where a grip breaks, a slip ends and a free foot turns, each by hand on both sides of its threshold."""

import pytest
from cases import BOUNCER

from stickslip.crawler import Groups, Scene
from stickslip.crawler.model.state import BACKWARD, Body, coefficients_of, FORWARD, STUCK
from stickslip.crawler.motion.events import breaks_loose, comes_to_rest, jump, mode_after_rest, turning_speed

BOTH_WAYS = Scene(ratchet=False, slope=0.5)
RUBBING = Groups(**BOUNCER, static_friction=0.25, kinetic_friction=0.125, foot_mass_fraction=0.25)
FREE = Groups(**BOUNCER, static_friction=0.0, kinetic_friction=0.0, foot_mass_fraction=0.25)
ROUNDING = 1e-12


def test_a_grip_breaks_at_its_threshold_but_for_rounding():
    """The pull is z - r slope forward; what may round is as large as 1, z and the grip."""
    coefficients = coefficients_of(RUBBING, BOTH_WAYS)
    for mode in (FORWARD, BACKWARD):
        there = mode * 0.25 + 0.25 * 0.5
        size = 1.0 + abs(there) + 0.25
        for share, breaks in ((-1e11, True), (0.0, True), (0.7, True), (1.4, False), (1e11, False)):
            missed = share * ROUNDING * size
            assert breaks_loose(mode, coefficients, there - mode * missed, 0.0, 0.0) == breaks
            # Whoever is at rest and is not pulled loose has come to rest.
            assert comes_to_rest(mode, coefficients, there - mode * missed, 0.0, 0.0, 0.0) != breaks
        assert not comes_to_rest(mode, coefficients, 0.0, 0.0, 0.0, 1e-300 * mode)
    assert not comes_to_rest(FORWARD, coefficients_of(FREE, BOTH_WAYS), 0.0, 0.0, 0.0, 0.0)
    assert comes_to_rest(FORWARD, coefficients_of(FREE, Scene()), -0.5, 0.0, 0.0, 0.0)


def test_more_than_the_grip_turns_a_foot_round_and_the_diode_never_lets_it():
    coefficients = coefficients_of(RUBBING, BOTH_WAYS)
    for mode in (FORWARD, BACKWARD):
        for push, then in ((0.25, STUCK), (0.250001, -mode), (-9.0, STUCK)):
            assert mode_after_rest(mode, coefficients, mode * push - 0.25 * 0.5) == then
        assert mode_after_rest(mode, coefficients_of(FREE, BOTH_WAYS), -mode * 5.0) == -mode
    assert mode_after_rest(FORWARD, coefficients_of(RUBBING, Scene()), 9.0) == STUCK


def test_a_free_foot_turns_where_its_speed_is_told_from_errors_and_rounding():
    free = coefficients_of(FREE, BOTH_WAYS)
    body = Body(0.0, -2.0, 0.0, 0.0, 8.0, FORWARD, 0)
    assert turning_speed(body, free, 1e-3) == pytest.approx(4e-3 * 0.75, rel=1e-12)
    assert turning_speed(body, free, 1e-15) == pytest.approx(ROUNDING * (8.0 + 0.75 * 2.0), rel=1e-12)
    for held in (coefficients_of(RUBBING, BOTH_WAYS), coefficients_of(FREE, Scene())):
        assert turning_speed(body, held, 1e-3) == 0.0


def test_what_is_a_slip_and_what_keeps_its_speed():
    sliding, resting = (Body(1.0, 2.0, 0.5, 3.0, speed, mode, 7) for speed, mode in ((1e-9, FORWARD), (0.0, STUCK)))
    rubbing, free = coefficients_of(RUBBING, BOTH_WAYS), coefficients_of(FREE, BOTH_WAYS)
    for body, mode, coefficients, slips, speed in (
        (resting, FORWARD, rubbing, 8, 0.0),
        (resting, BACKWARD, free, 8, 0.0),
        (sliding, STUCK, rubbing, 7, 0.0),
        (sliding, BACKWARD, rubbing, 8, 0.0),
        (sliding, BACKWARD, free, 7, 1e-9),
    ):
        assert jump(body, mode, coefficients) == Body(1.0, 2.0, 0.5, 3.0, speed, mode, slips)
