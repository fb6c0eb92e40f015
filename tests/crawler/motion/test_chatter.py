"""What lies below the tolerance is neither an event nor an endless sequence of them."""

import numpy as np
import pytest
from stiff_judge import stiff_judge

from stickslip.crawler import Groups, Scene, simulate

TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12)
SAMPLES = 40
# A sound run takes some fifty steps; chatter takes all that it is given.
BUDGET = 3000


def heavy_footed(rng: np.random.Generator, static: float, *, linear: bool) -> tuple:
    """Arguments of `simulate`: a damped crawler whose light payload pulls its foot by less than many a tolerance."""
    smooth = {"duffing": 0.0, "radial_coupling": 0.0} if linear else {}
    groups = Groups(
        damping_ratio=float(10.0 ** rng.uniform(0.0, 2.0)),
        deborah=float(10.0 ** rng.uniform(-1.0, 1.0)),
        foot_mass_fraction=float(1.0 - 10.0 ** -rng.uniform(1.0, 8.0)),
        static_friction=static,
        kinetic_friction=static * float(rng.choice([0.5, 1.0])),
        **smooth,
    )
    scene = Scene(ratchet=bool(rng.random() < 0.5))
    return groups, rng.integers(0, 2, 8), float(10.0 ** rng.uniform(-0.5, 1.0)), scene


def go(case, tolerance, solver="radau"):
    groups, valve, hold, scene = case
    return simulate(groups, valve, hold, scene=scene, tolerance=tolerance, solver=solver, max_steps=BUDGET)


@pytest.mark.parametrize("static", [0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3])
def test_a_foot_pulled_by_less_than_the_tolerance_is_where_it_is_at_a_finer_one(static):
    for seed in range(SAMPLES):
        case = heavy_footed(np.random.default_rng(seed), static, linear=False)
        finest = go(case, TOLERANCES[-1])
        for tolerance in TOLERANCES[:-1]:
            done = go(case, tolerance)
            np.testing.assert_allclose(done.foot, finest.foot, rtol=0, atol=10.0 * tolerance, err_msg=f"{seed}")


@pytest.mark.parametrize("static", [1e-5, 1e-3, 1e-1])
def test_slips_do_not_depend_on_a_tolerance_below_a_tenth_of_the_friction(static):
    slips = 0
    for seed in range(2 * SAMPLES):
        case = heavy_footed(np.random.default_rng(seed), static, linear=False)
        fine = [tolerance for tolerance in (1e-2, 1e-4, 1e-6, 1e-9, 1e-12) if 10.0 * tolerance <= static]
        counts = [go(case, tolerance).slips for tolerance in fine]
        assert counts == counts[:1] * len(counts), (seed, case)
        slips += counts[0]
    assert slips > 20 or static > 1e-2


@pytest.mark.parametrize("static", [0.0, 1e-9, 1e-7, 1e-5])
def test_slips_are_those_of_the_closed_form_to_a_few_that_the_tolerance_hides(static):
    for seed in range(SAMPLES):
        case = heavy_footed(np.random.default_rng(seed), static, linear=True)
        exact = go(case, 1e-9, "closed_form")
        for tolerance in (1e-6, 1e-9):
            done = go(case, tolerance)
            np.testing.assert_allclose(done.foot, exact.foot, rtol=0, atol=10.0 * tolerance)
            if static >= 10.0 * tolerance:
                assert done.slips == exact.slips, (seed, case)
            if static > 0.0 or case[-1].ratchet:
                assert done.slips <= exact.slips + 4, (seed, case)


@pytest.mark.parametrize("mass", [1.0 - 1e-7, 1.0 - 1e-6])
def test_a_slip_that_begins_as_the_body_slows_is_one_whatever_the_tolerance(mass):
    # A judge of 60 digits has the moment at which the pull on the frictionless foot turns.
    groups = Groups(damping_ratio=50.0, foot_mass_fraction=mass, static_friction=0.0, kinetic_friction=0.0)
    valve = [1, 1, 1, 0, 0, 0, 1, 0]
    verdict = stiff_judge(groups, valve, 2.0, scene=Scene())
    for tolerance in (1e-2, 1e-4, 1e-6, 1e-7, 1e-9, 1e-12):
        done = simulate(groups, valve, 2.0, tolerance=tolerance, max_steps=BUDGET)
        assert done.slips == verdict.slips == 1
        np.testing.assert_allclose(done.foot, verdict.foot, rtol=0, atol=1e-3 * tolerance + 1e-13)
        assert done.events["time"][0] == pytest.approx(float(verdict.events[0][0]), abs=0.1)
