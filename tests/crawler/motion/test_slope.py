"""A crawler on a slope, against the judges and against what a slope alone makes of a block."""

import numpy as np
import pytest
from cases import assert_agrees, BOUNCER, run, WORD
from decimal_judge import decimal_judge
from judge import judge

from stickslip.crawler import Groups, Scene, State


@pytest.mark.parametrize("slope", [0.2, -0.2, 0.9, -1.5])
@pytest.mark.parametrize("ratchet", [True, False])
@pytest.mark.parametrize("judge_of", [judge, decimal_judge])
def test_agrees_with_the_judges(slope, ratchet, judge_of):
    scene = Scene(slope=slope, ratchet=ratchet)
    done = run(Groups(), WORD, 1.0, scene=scene, samples_per_hold=3, tolerance=1e-14)
    verdict = judge_of(Groups(), WORD, 1.0, scene=scene, samples_per_hold=3)
    assert_agrees(done, verdict, atol=1e-9)


@pytest.mark.parametrize("slope", [0.3, -0.3])
def test_an_anchored_body_on_a_slope(slope):
    scene = Scene(anchored=True, slope=slope)
    done = run(Groups(), WORD, 1.0, scene=scene, tolerance=1e-14)
    assert_agrees(done, judge(Groups(), WORD, 1.0, scene=scene), atol=1e-9)


def test_a_body_hung_at_rest_stays_at_rest():
    # Stretched by its payload's weight, with a foot that the slope cannot pull loose.
    groups, slope = Groups(**BOUNCER), -0.4
    start = State(deformation=-slope * (1.0 - groups.foot_mass_fraction))
    done = run(groups, [0] * 5, 2.0, scene=Scene(slope=slope, anchored=True), initial=start)
    np.testing.assert_allclose(done.deformation, start.deformation, rtol=0, atol=1e-12)


def test_downhill_without_friction_the_whole_crawler_falls_freely():
    groups = Groups(**BOUNCER, static_friction=0.0, kinetic_friction=0.0)
    done = run(groups, [0] * 4, 1.0, scene=Scene(slope=-0.7), tolerance=1e-14)
    np.testing.assert_allclose(done.foot, 0.35 * done.time**2, rtol=1e-12)
    np.testing.assert_allclose(done.deformation, 0.0, rtol=0, atol=1e-12)


def test_uphill_is_slower_and_too_steep_a_slope_defeats_the_ratchet_less():
    level, uphill = (run(Groups(), WORD * 5, 1.0, scene=Scene(slope=slope)) for slope in (0.0, 0.3))
    assert uphill.foot[-1] < level.foot[-1]
    # r slope exceeds static friction: without the ratchet nothing holds the foot.
    sliding = run(Groups(), [0] * 5, 1.0, scene=Scene(slope=1.5, ratchet=False))
    assert sliding.foot[-1] < -5.0
