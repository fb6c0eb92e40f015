"""The closed form of linear crawlers: propagators, events, energies, and what it refuses."""

from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from cases import assert_agrees, HUNT, is_free, random_crawler, run, schedules, starts, WORD
from decimal_judge import decimal_judge
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from judge import judge
from modal_judge import LinearMotion, modal_judge

from stickslip.crawler import Groups, Scene, simulate, SolverError, State
from stickslip.crawler.loop import advance
from stickslip.crawler.model.state import Body, coefficients_of, FORWARD, NOTHING_YET, STUCK
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import Hold, OUT_OF_STEPS, Recording
from stickslip.crawler.steps.propagator import propagator, rates_of, tabulate

LINEAR = Groups.of("linear")
SYMMETRIC = Scene(ratchet=False)
SCENES = [Scene(), SYMMETRIC, Scene(anchored=True), Scene(slope=0.2), Scene(slope=-0.3, ratchet=False)]


def spread(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def linear(groups, **changes):
    return replace(groups, duffing=0.0, radial_coupling=0.0, **changes)


# Propagators


def exact_propagator(rates, t):
    """exp(A t) of the state (z, v, q), in 60 digits and with scaling and squaring."""
    y, d, lag = (mp.mpf(value) for value in (rates.mobility, rates.damping, rates.lag))
    matrix = mp.matrix([[0, 1, 0], [-y, -y * d, y], [0, 0, -lag]]) * mp.mpf(t)
    return mp.expm(matrix, method="taylor")


def assert_propagates(groups, motion, t, tolerance=2e-15):
    """Each entry against mpmath, in units of its largest, save for the phase: omega t is known to one part in 2^53."""
    rates = rates_of(coefficients_of(groups, Scene()), motion)
    over = propagator(rates, t)
    with mp.workdps(60):
        # As many squarings of the matrix as its norm asks for lose as many digits.
        norm = t * max(1.0, rates.mobility * (1.0 + rates.damping), rates.lag)
        mp.mp.dps = 60 + int(2 * np.log10(1.0 + norm))
        exact = exact_propagator(rates, t)
        frequency = np.sqrt(rates.mobility)
        entries = (
            (over.z_z, exact[0, 0], 1.0),
            (over.z_v, exact[0, 1], 1.0 / frequency),
            (over.z_q, exact[0, 2], 1.0),
            (over.v_z, exact[1, 0], frequency),
            (over.v_v, exact[1, 1], 1.0),
            (over.v_q, exact[1, 2], frequency),
            (over.q_q, exact[2, 2], 1.0),
        )
        phase = 1.0 + (rates.spread * t if rates.oscillates else 0.0)
        for value, truth, unit in entries:
            assert abs(value - float(truth)) < tolerance * phase * unit


@pytest.mark.parametrize("seed", range(150))
def test_propagators_over_the_whole_range_of_groups(seed):
    rng = np.random.default_rng(seed)
    lightest = spread(rng, 1e-6, 0.5)
    groups = linear(
        LINEAR,
        damping_ratio=float(rng.choice([0.0, spread(rng, 1e-4, 1e4)])),
        deborah=spread(rng, 1e-6, 1e6),
        foot_mass_fraction=float(rng.choice([lightest, 1.0 - lightest])),
    )
    assert_propagates(groups, int(rng.choice([STUCK, FORWARD])), spread(rng, 1e-6, 1e4))


def near(rng, value):
    """`value`, or a little beside it."""
    return value * (1.0 + float(rng.choice([0.0, 1e-16, -1e-15, 1e-12, -1e-8, 1e-4, -1e-2])))


@pytest.mark.parametrize("which", ["critical", "slow", "fast", "critical and resonant"])
@pytest.mark.parametrize("seed", range(40))
def test_propagators_where_rates_coincide(which, seed):
    rng = np.random.default_rng(seed)
    r = spread(rng, 1e-6, 0.9)
    frequency = 1.0 / np.sqrt(1.0 - r)
    critical = "critical" in which
    damping = near(rng, 1.0 / frequency) if critical else spread(rng, 1.0, 1e4)
    body = rates_of(coefficients_of(linear(LINEAR, damping_ratio=damping, foot_mass_fraction=r), Scene()), STUCK)
    resonant = {"critical": spread(rng, 1e-6, 1e6), "critical and resonant": body.mean}
    lag = near(rng, resonant[which] if critical else getattr(body, which))
    groups = linear(LINEAR, damping_ratio=damping, foot_mass_fraction=r, deborah=1.0 / lag)
    t = spread(rng, 1e-3, 30.0) / float(rng.choice([body.slow, body.fast, lag]))
    assert_propagates(groups, STUCK, t)


def test_over_no_time_nothing_changes_and_over_a_long_one_everything_fades():
    for groups in (linear(LINEAR, damping_ratio=d, deborah=b) for d in (0.1, 1e4) for b in (1e-6, 1.0)):
        rates = rates_of(coefficients_of(groups, Scene()), STUCK)
        assert propagator(rates, 0.0) == (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0)
        assert not any(propagator(rates, 1e300))


# Trajectories


@pytest.mark.parametrize("scene", SCENES, ids=str)
@pytest.mark.parametrize("judge_of", [judge, decimal_judge, modal_judge])
def test_agrees_with_the_judges(scene, judge_of):
    done = run(LINEAR, WORD, 1.0, scene=scene, samples_per_hold=3)
    assert "closed form" in done.model
    verdict = judge_of(LINEAR, WORD, 1.0, scene=scene, samples_per_hold=3)
    assert_agrees(done, verdict, atol=1e-9 if judge_of is judge else 1e-13)
    if judge_of is judge:
        for name in ("work", "viscous_loss", "friction_loss"):
            assert getattr(done, name) == pytest.approx(getattr(verdict, name), abs=1e-9)


@pytest.mark.parametrize("seed", range(80))
def test_agrees_with_taylor(seed):
    rng = np.random.default_rng(seed)
    groups, valve, hold, options = random_crawler(rng, anchored=seed % 8 == 0)
    # A frictionless foot touches rest wherever rounding has it, and one without drag or damping returns exactly to the
    # threshold: neither has a sequence of events to agree on.
    groups = linear(groups, static_friction=max(groups.static_friction, 0.01))
    groups = replace(groups, kinetic_friction=max(groups.kinetic_friction, 0.001), damping_ratio=0.001)
    options["scene"] = replace(options["scene"], slope=float(rng.choice([0.0, rng.normal()])))
    done = run(groups, valve, hold, **options)
    other = simulate(groups, valve, hold, **options, solver="taylor", tolerance=1e-15)
    scale = 1.0 + np.abs(other.foot).max() + np.abs(other.foot_velocity).max()
    for name in ("deformation", "velocity", "pressure", "foot", "foot_velocity"):
        np.testing.assert_allclose(getattr(done, name), getattr(other, name), rtol=0, atol=1e-11 * scale, err_msg=name)
    assert done.events["mode"].tolist() == other.events["mode"].tolist()
    np.testing.assert_allclose(done.events["time"], other.events["time"], rtol=0, atol=1e-11 * scale)
    assert done.slips == other.slips
    for name in ("work", "viscous_loss", "friction_loss"):
        assert getattr(done, name) == pytest.approx(getattr(other, name), abs=1e-11 * scale**2)


EXTREMES = [
    {"damping_ratio": 1e4},
    {"deborah": 1e-6},
    {"deborah": 1e6},
    {"foot_mass_fraction": 1e-6, "damping_ratio": 0.5},
    {"foot_mass_fraction": 1.0 - 1e-6, "damping_ratio": 0.05},
    {"damping_ratio": 1e4, "deborah": 1e-6, "foot_mass_fraction": 1e-6},
    {"damping_ratio": 1e4, "deborah": 1e-6, "foot_mass_fraction": 1.0 - 1e-6},
    {"damping_ratio": 100.0, "deborah": 1e-3},
    {"damping_ratio": 100.0, "deborah": 200.0},  # resonant with the slow rate, to rounding
    {"damping_ratio": 0.8366600265340756, "deborah": 0.8366600265340756},  # critical, and resonant too
]


@pytest.mark.parametrize("changes", EXTREMES, ids=str)
@pytest.mark.parametrize("friction", [(0.3, 0.2), (0.05, 0.05)])
@pytest.mark.parametrize("ratchet", [True, False])
def test_the_extremes(changes, friction, ratchet):
    groups, scene = (
        linear(LINEAR, **changes, static_friction=friction[0], kinetic_friction=friction[1]),
        Scene(ratchet=ratchet),
    )
    valve = [1, 1, 0, 1, 0, 0]
    done = run(groups, valve, 1.0, scene=scene)
    verdict = modal_judge(groups, valve, 1.0, scene=scene)
    assert_agrees(done, verdict, atol=1e-11)
    assert abs(done.energy_residual) < 1e-13


@pytest.mark.parametrize("hold", [1e-6, 1e4])
@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_very_short_and_very_long_holds(hold, scene):
    groups = linear(LINEAR, damping_ratio=0.3)
    valve = [1] if hold > 1.0 else [1] * 8
    initial = State(deformation=0.5, velocity=0.1)
    done = run(groups, valve, hold, scene=scene, initial=initial)
    verdict = modal_judge(groups, valve, hold, scene=scene, initial=initial)
    if np.abs(verdict.foot).max() < 1e3:  # on a slope it may run away
        assert_agrees(done, verdict, atol=1e-11)
    else:
        np.testing.assert_allclose(done.foot, verdict.foot, rtol=1e-13)


def test_many_samples_in_a_hold():
    many = run(LINEAR, WORD, 1.0, samples_per_hold=5000)
    few = run(LINEAR, WORD, 1.0, samples_per_hold=5)
    for name in ("deformation", "velocity", "pressure", "foot", "foot_velocity"):
        np.testing.assert_array_equal(getattr(many, name)[999::1000], getattr(few, name))


def test_a_million_holds_lose_nothing():
    valve = np.random.default_rng(0).integers(0, 2, 1_000_000)
    done = simulate(LINEAR, valve, 0.3)
    assert abs(done.energy_residual) < 1e-13 * done.work * 10.0
    assert done.slips > 10_000


@settings(HUNT, max_examples=10)
@given(
    damping=st.floats(0.0, 10.0),
    deborah=st.floats(0.01, 10.0),
    mass=st.floats(0.01, 0.99),
    static=st.floats(0.01, 0.8),
    ratio=st.sampled_from([0.1, 0.9, 1.0]),
    valve=schedules,
    hold=st.floats(0.05, 5.0),
    scene=st.builds(Scene, ratchet=st.booleans(), slope=st.sampled_from([0.0, 0.3, -0.3])),
    initial=starts,
)
def test_any_linear_crawler_is_the_judges(damping, deborah, mass, static, ratio, valve, hold, scene, initial):
    groups = Groups(0.0, damping, deborah, 0.0, mass, static, ratio * static)
    done = run(groups, valve, hold, scene=scene, initial=initial)
    verdict = modal_judge(groups, valve, hold, scene=scene, initial=initial)
    assume(verdict.clearance > 1e-9)
    # A root is as ill-conditioned as it is near a graze.
    assert_agrees(done, verdict, atol=max(1e-11, 1e-15 / verdict.clearance), free=is_free(groups, scene))


# Events at the edge

GRAZERS = [
    {},
    {"damping_ratio": 0.0},
    {"damping_ratio": 0.4},
    {"deborah": 1e-3},
    {"foot_mass_fraction": 0.99},
]


@pytest.mark.parametrize("changes", GRAZERS, ids=str)
@pytest.mark.parametrize("miss", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_graze_slips_only_where_it_passes_the_threshold(changes, miss):
    base = linear(LINEAR, **changes, static_friction=0.0, kinetic_friction=0.0)
    initial, hold = State(deformation=-0.2, velocity=0.9, pressure=0.4), 2.6
    with mp.workdps(50):
        smooth = LinearMotion(base, Scene(), STUCK, *initial[:3], 0)
        times = [hold * mp.mpf(i) / 400 for i in range(1, 400)]
        lowest = min(times, key=smooth.force)
        lowest = mp.findroot(lambda t: mp.diff(smooth.force, t), lowest)
        assert 0 < lowest < hold
        depth = -float(smooth.force(lowest))
    for miss_by in (miss, -miss):
        groups = replace(base, static_friction=depth + miss_by, kinetic_friction=0.5 * depth)
        done = run(groups, [0], hold, initial=initial)
        assert (done.slips > 0) == (miss_by < 0)
        if done.slips:
            assert abs(done.events["time"][0] - float(lowest)) < 10.0 * np.sqrt(miss)


@pytest.mark.parametrize("apart", [1e-6, 1e-9, 1e-11, 1e-13])
def test_two_events_very_close_together(apart):
    # Sliding forward it comes to rest, and is pushed backward over the threshold `apart` later.
    groups, initial = linear(LINEAR, kinetic_friction=0.1), State(-0.6, -0.4, 0.0, 0.0, 0.05)
    first = run(groups, [1], 3.0, scene=SYMMETRIC, initial=initial).events[0]["time"]
    there = simulate(groups, [1], first, scene=SYMMETRIC, initial=initial)
    with mp.workdps(40):
        z, v, p = (float(getattr(there, name)[-1]) for name in ("deformation", "velocity", "pressure"))
        resting = LinearMotion(groups, SYMMETRIC, STUCK, z, v, p, 1)
        force, rise = float(resting.force(0)), float(mp.diff(resting.force, 0))
    assert rise > 0.1
    close = replace(groups, static_friction=force + rise * apart)
    done = run(close, [1], 3.0, scene=SYMMETRIC, initial=initial)
    assert done.events["mode"].tolist()[:2] == [0, -1]
    assert np.diff(done.events["time"])[0] == pytest.approx(apart, rel=1e-3, abs=2e-15 / rise)


# The interface


def test_the_model_is_named():
    assert simulate(LINEAR, [1], 1.0).model == "on the ground, closed form"
    assert simulate(LINEAR, [1], 1.0, scene=Scene(anchored=True)).model == "anchored, closed form"
    assert simulate(LINEAR, [1], 1.0, solver="taylor").model == "on the ground, taylor"
    assert simulate(Groups(), [1], 1.0).model == "on the ground, taylor"
    mixed = simulate([LINEAR, Groups()], [1], 1.0)
    assert mixed.model == "on the ground, closed form; on the ground, taylor"
    all_three = simulate([Groups(damping_ratio=1e4), Groups(), LINEAR, Groups()], [1], 1.0).model
    assert all_three == "on the ground, closed form; on the ground, radau; on the ground, taylor"
    assert mixed.foot[0] == simulate(LINEAR, [1], 1.0, solver="closed_form").foot


@pytest.mark.parametrize(("name", "value"), [("duffing", 0.5), ("radial_coupling", 1e-9)])
def test_the_nonlinear_are_refused(name, value):
    groups = replace(LINEAR, **{name: value})
    with pytest.raises(ValueError, match=f"'closed_form' needs {name} to be 0, got {value}"):
        simulate(groups, [1], 1.0, solver="closed_form")
    with pytest.raises(ValueError, match=name):
        simulate([LINEAR, groups], [1], 1.0, solver="closed_form")


def test_the_tolerance_changes_nothing():
    loose, tight = (run(LINEAR, WORD * 3, 1.0, tolerance=tolerance) for tolerance in (1e-2, 1e-15))
    np.testing.assert_array_equal(loose.foot, tight.foot)
    np.testing.assert_array_equal(loose.events, tight.events)


def test_the_step_budget_is_kept():
    samples, coefficients = np.empty((5, 1)), coefficients_of(LINEAR, Scene())
    body = Body(1.5, 0.0, 0.0, 0.0, 0.0, STUCK, 0)
    for budget in range(60):
        outcome = advance(
            body,
            NOTHING_YET,
            coefficients,
            Hold(0.0, 20.0, 0.0, 20.0, 0.0),
            SOLVERS["closed_form"].options(1e-9, max_steps=budget),
            Recording(samples, np.empty((0, 2))),
            tabulate(coefficients, 20.0, 1),
        )
        if outcome.status != OUT_OF_STEPS:
            break
        assert outcome.elapsed < 20.0
    assert budget > 10


def test_a_body_from_beyond_all_bounds_is_said_to_diverge():
    with pytest.raises(SolverError, match="diverged"):
        simulate(LINEAR, [1], 1.0, initial=State(deformation=1e200))


@pytest.mark.parametrize("budget", [1, 5, 50])
def test_a_refusal_names_the_budget_that_was_given_and_no_tolerance(budget):
    with pytest.raises(SolverError, match=rf"step budget of {budget} was spent .* take a larger max_steps") as refusal:
        simulate(Groups(duffing=0.0, radial_coupling=0.0), WORD * 2, 1.0, solver="closed_form", max_steps=budget)
    assert "looser" not in str(refusal.value)
