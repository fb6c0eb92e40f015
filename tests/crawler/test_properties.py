"""What must hold of every simulation, whatever the numbers."""

import numpy as np
import pytest
from cases import crawlers, HUNT, random_crawler, run, schedules, starts, WORD
from hypothesis import given
from hypothesis import strategies as st

from stickslip.crawler import Groups, Scene, simulate, SolverError, State

holds = st.floats(0.05, 5.0)
four_holds = st.lists(st.integers(0, 1), min_size=4, max_size=4)
scenes = st.builds(Scene, anchored=st.just(False), ratchet=st.booleans())
SAMPLED = ("deformation", "velocity", "pressure", "foot", "foot_velocity")


def assert_same(left, right, *, left_samples=slice(None), right_samples=slice(None)):
    """Equal bit for bit, but for which samples were kept."""
    for name in SAMPLED:
        np.testing.assert_array_equal(getattr(left, name)[..., left_samples], getattr(right, name)[..., right_samples])
    for name in ("slips", "work", "stored", "viscous_loss", "friction_loss"):
        np.testing.assert_array_equal(getattr(left, name), getattr(right, name))


@HUNT
@given(groups=crawlers, valve=schedules, hold=holds, scene=scenes, initial=starts, more=st.integers(2, 7))
def test_sampling_more_often_changes_nothing(groups, valve, hold, scene, initial, more):
    once = run(groups, valve, hold, scene=scene, initial=initial, samples_per_hold=2)
    often = run(groups, valve, hold, scene=scene, initial=initial, samples_per_hold=2 * more)
    assert_same(once, often, right_samples=slice(more - 1, None, more))
    np.testing.assert_array_equal(once.time, often.time[more - 1 :: more])
    np.testing.assert_array_equal(once.events, often.events)


@HUNT
@given(
    groups=crawlers, valve=schedules, hold=holds, ratchet=st.booleans(), tolerance=st.sampled_from([1e-3, 1e-6, 1e-13])
)
def test_every_tolerance_and_hold_is_simulated(groups, valve, hold, ratchet, tolerance):
    # `run` checks the clock, the pressure, the events, the diode and the energy balance.
    run(groups, valve, hold, scene=Scene(ratchet=ratchet), tolerance=tolerance, samples_per_hold=3)


@pytest.mark.parametrize("seed", range(60))
def test_crawlers_from_anywhere_in_the_ranges_obey_the_laws(seed):
    groups, valve, hold, options = random_crawler(np.random.default_rng(10_000 + seed))
    run(groups, valve, hold, tolerance=10.0 ** -(4 + seed % 12), **options)


@pytest.mark.parametrize("seed", range(12))
def test_one_long_hold_is_two_short_ones(seed):
    groups, valve, hold, options = random_crawler(np.random.default_rng(20_000 + seed))
    options.pop("samples_per_hold")
    whole = run(groups, valve, hold, tolerance=1e-13, samples_per_hold=2, **options)
    halves = run(groups, np.repeat(valve, 2), hold / 2, tolerance=1e-13, **options)
    np.testing.assert_allclose(whole.foot, halves.foot, rtol=0, atol=1e-8)
    np.testing.assert_allclose(whole.deformation, halves.deformation, rtol=0, atol=1e-8)


@HUNT
@given(
    members=st.lists(st.tuples(crawlers, st.lists(st.integers(0, 1), min_size=4, max_size=4)), min_size=1, max_size=4)
)
def test_batch_rows_are_single_runs(members):
    groups, valves = [g for g, _ in members], [v for _, v in members]
    batch = simulate(groups, valves, 0.8, samples_per_hold=2)
    assert batch.deformation.shape == (len(members), 8)
    assert batch.slips.shape == batch.work.shape == batch.energy_residual.shape == (len(members),)
    for row, (g, v) in enumerate(members):
        alone = run(g, v, 0.8, samples_per_hold=2)
        for name in SAMPLED:
            np.testing.assert_array_equal(getattr(batch, name)[row], getattr(alone, name))
        for name in ("slips", "work", "stored", "viscous_loss", "friction_loss"):
            assert getattr(batch, name)[row] == getattr(alone, name)
        own = batch.events[batch.events["crawler"] == row]
        np.testing.assert_array_equal(own["time"], alone.events["time"])
        np.testing.assert_array_equal(own["mode"], alone.events["mode"])


def test_one_crawler_takes_many_schedules_and_many_crawlers_one():
    schedules = [WORD, WORD[::-1]]
    batch = simulate(Groups(), schedules, 1.0)
    np.testing.assert_array_equal(batch.foot[1], run(Groups(), WORD[::-1], 1.0).foot)
    groups = [Groups(), Groups(deborah=2.0)]
    batch = simulate(groups, WORD, 1.0)
    np.testing.assert_array_equal(batch.valve, [WORD, WORD])
    np.testing.assert_array_equal(batch.foot[1], run(groups[1], WORD, 1.0).foot)


def test_a_run_is_repeated_bit_for_bit():
    assert_same(*(run(Groups(), WORD * 5, 0.9, samples_per_hold=3) for _ in range(2)))


@HUNT
@given(groups=crawlers, valve=schedules, hold=holds, where=st.floats(-100.0, 100.0))
def test_where_the_foot_starts_does_not_matter(groups, valve, hold, where):
    here = run(groups, valve, hold)
    there = run(groups, valve, hold, initial=State(foot=where))
    np.testing.assert_allclose(there.foot - where, here.foot, rtol=0, atol=1e-11)
    for name in ("deformation", "velocity", "foot_velocity", "events"):
        np.testing.assert_array_equal(getattr(there, name), getattr(here, name))


def test_a_simulation_continues_from_its_last_sample():
    whole = run(Groups(), WORD * 2, 1.0, tolerance=1e-14)
    first = run(Groups(), WORD, 1.0, tolerance=1e-14)
    middle = State(*(float(getattr(first, name)[-1]) for name in SAMPLED))
    second = run(Groups(), WORD, 1.0, tolerance=1e-14, initial=middle)
    np.testing.assert_allclose(second.foot, whole.foot[8:], rtol=0, atol=1e-12)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("duffing", [0.0, 0.5, 8.0, 300.0])
@pytest.mark.parametrize("mass", [0.07, 0.5, 0.95])
def test_the_error_is_of_the_order_of_the_tolerance(tolerance, duffing, mass):
    # Anchored, so that no event amplifies it. From rest the cubic spring first acts on the ninth order of the series.
    groups = Groups(duffing=duffing, damping_ratio=0.016, deborah=1.013, radial_coupling=0.0, foot_mass_fraction=mass)
    done, exact = (
        simulate(groups, [1, 0, 1], 6.3, scene=Scene(anchored=True), tolerance=t, samples_per_hold=5)
        for t in (tolerance, 1e-15)
    )
    assert np.abs(done.deformation - exact.deformation).max() < 100.0 * tolerance


@pytest.mark.parametrize("tolerance", [1e-3, 1e-9, 1e-15])
@pytest.mark.parametrize("scene", [Scene(), Scene(anchored=True)], ids=str)
@pytest.mark.parametrize(("holds_open", "hold"), [(1, 1e3), (100, 10.0), (2000, 0.5)])
def test_a_body_that_nothing_bounds_is_said_to_diverge(tolerance, scene, holds_open, hold):
    groups = Groups(duffing=0.0, radial_coupling=2.0)
    with pytest.raises(SolverError, match=r"diverged at time \d.*radial_coupling > 1 needs duffing > 0"):
        simulate(groups, [1] * holds_open, hold, scene=scene, tolerance=tolerance)


def test_a_cubic_spring_bounds_what_the_radial_coupling_drives():
    done = run(Groups(duffing=0.1, radial_coupling=5.0), [1] * 20, 1.0, samples_per_hold=3)
    assert np.abs(done.deformation).max() < 30.0
