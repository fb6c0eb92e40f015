"""The chain of segments: against Newton's law for each mass, the crawler, normal modes and the continuous rod."""

from dataclasses import replace

import numpy as np
import pytest
from cases import assert_agrees, BOUNCER, crawlers, HUNT, is_free, run, schedules, starts, WORD
from chain_judge import chain_judge
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from stickslip.crawler import Actuator, ChainState, Groups, Scene, simulate, SolverError, State

SCENES = [
    Scene(),
    Scene(ratchet=False),
    Scene(anchored=True),
    Scene(slope=0.2),
    Scene(slope=-0.2, ratchet=False),
]
FREE = {"static_friction": 0.0, "kinetic_friction": 0.0}
SAMPLED = ("deformation", "velocity", "pressure", "foot", "foot_velocity")
# Below this, the judge's own rounding may decide whether an event happens.
UNDECIDED = 1e-7


def assert_judged(done, judged, *, atol, free=False):
    verdict, stretch, rate = judged
    assert_agrees(done, verdict, atol=atol, free=free)
    np.testing.assert_allclose(done.segment_deformation, stretch, rtol=0, atol=atol)
    np.testing.assert_allclose(done.segment_velocity, rate, rtol=0, atol=10.0 * atol)
    for energy in ("work", "viscous_loss", "friction_loss"):
        assert getattr(done, energy) == pytest.approx(getattr(verdict, energy), abs=atol)


# Against Newton's second law


@pytest.mark.parametrize("scene", SCENES, ids=str)
@pytest.mark.parametrize("segments", [1, 2, 3, 8])
@pytest.mark.parametrize("tube_mass", [0.4, 4.0])
def test_agrees_with_newton(scene, segments, tube_mass):
    options = {"scene": replace(scene, segments=segments, tube_mass=tube_mass), "samples_per_hold": 2}
    done = run(Groups(), WORD, 1.0, tolerance=1e-13, **options)
    judged = chain_judge(Groups(), WORD, 1.0, **options)
    assert judged[0].clearance > 1e-4
    assert_judged(done, judged, atol=1e-10)


@pytest.mark.parametrize("scene", [Scene(), Scene(ratchet=False)], ids=str)
@pytest.mark.parametrize("segments", [1, 2])
def test_agrees_with_newton_where_the_tube_weighs_little(scene, segments):
    options = {"scene": replace(scene, segments=segments, tube_mass=0.01)}
    done = run(Groups(), WORD, 1.0, tolerance=1e-13, **options)
    assert_judged(done, chain_judge(Groups(), WORD, 1.0, **options), atol=1e-10)


@pytest.mark.parametrize("foot_velocity", [0.0, 0.6, -0.6])
def test_agrees_with_newton_from_uneven_stretches(foot_velocity):
    groups = Groups(duffing=3.0, radial_coupling=0.6, static_friction=0.1, kinetic_friction=0.05)
    initial = ChainState([0.5, -0.2, 0.1], [-0.3, 0.0, 0.4], 0.7, 2.0, foot_velocity)
    options = {"scene": Scene(ratchet=False, segments=3, tube_mass=0.7), "initial": initial, "samples_per_hold": 3}
    done = simulate(groups, [0, 1, 0], 2.0, tolerance=1e-13, **options)
    assert done.slips > 1
    assert_judged(done, chain_judge(groups, [0, 1, 0], 2.0, **options), atol=1e-10)
    assert abs(done.energy_residual) < 1e-12


def test_a_slip_forward_may_turn_at_once_into_a_slip_backward():
    groups = Groups(**BOUNCER, static_friction=0.05, kinetic_friction=0.05)
    options = {"scene": Scene(ratchet=False, segments=4, tube_mass=0.5), "initial": State(deformation=1.0)}
    done = run(groups, [0], 6.0, tolerance=1e-13, **options)
    assert done.events["mode"].tolist()[:3] == [1, -1, 1]
    assert_judged(done, chain_judge(groups, [0], 6.0, **options), atol=1e-9)


@pytest.mark.parametrize("event", range(3))
def test_an_event_exactly_at_a_holds_end(event):
    groups = Groups(static_friction=0.1, kinetic_friction=0.05)
    options = {"scene": Scene(segments=3, tube_mass=0.5), "initial": State(deformation=1.2), "tolerance": 1e-15}
    moment = float(run(groups, [0], 20.0, **options).events["time"][event])
    for ulps in range(-4, 5):
        hold = moment + ulps * np.spacing(moment) if moment else 1.0
        cut, whole = run(groups, [0] * 4, hold, **options), run(groups, [0], 4 * hold, **options)
        # Whether the last instant is still before an event is for rounding to decide.
        kinds = cut.events["mode"].tolist()
        assert kinds[:-1] == whole.events["mode"].tolist()[: len(kinds) - 1]
        assert cut.foot[-1] == pytest.approx(whole.foot[-1], abs=1e-12)


@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_a_thousand_segments_are_integrated(slope):
    # Heavy and undamped, so that the fastest motion is not too fast; the tube's own weight stretches it unevenly.
    groups = Groups(damping_ratio=0.0)
    scene = Scene(segments=1000, tube_mass=100.0, slope=slope)
    done = run(groups, [1], 1.0, scene=scene, tolerance=1e-6)
    assert done.segment_deformation.shape == (1000, 1)
    few = run(groups, [1], 1.0, scene=replace(scene, segments=100), tolerance=1e-6)
    assert done.deformation[-1] == pytest.approx(few.deformation[-1], rel=1e-2)


@settings(HUNT, max_examples=15)
@given(
    groups=crawlers,
    valve=schedules,
    hold=st.floats(0.05, 2.0),
    initial=starts,
    scene=st.builds(
        Scene,
        ratchet=st.booleans(),
        slope=st.sampled_from([0.0, 0.3, -0.3]),
        segments=st.integers(1, 4),
        tube_mass=st.floats(0.3, 5.0),
    ),
)
def test_agrees_with_newton_over_random_chains(groups, valve, hold, initial, scene):
    options = {"scene": scene, "initial": initial, "samples_per_hold": 2}
    done = run(groups, valve, hold, tolerance=1e-13, **options)
    judged = chain_judge(groups, valve, hold, **options)
    assume(judged[0].clearance > UNDECIDED)
    assert_judged(done, judged, atol=1e-7, free=is_free(groups, scene))


# Against the crawler


@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_massless_segments_are_the_crawler_bit_for_bit(scene):
    start = State(0.4, -0.1, 0.3, 1.0)
    plain = simulate(Groups(), WORD, 1.0, scene=scene, initial=start)
    assert plain.segment_deformation.shape == (1, 8)
    np.testing.assert_array_equal(plain.segment_velocity[0], plain.velocity)
    for segments in (2, 7):
        done = simulate(Groups(), WORD, 1.0, scene=replace(scene, segments=segments), initial=start)
        assert done.model == f"{segments} massless segments as one, {plain.model}"
        for name in (*SAMPLED, "events", "work", "stored", "viscous_loss", "friction_loss", "slips"):
            np.testing.assert_array_equal(getattr(done, name), getattr(plain, name))
        for whole, part in ((done.deformation, done.segment_deformation), (done.velocity, done.segment_velocity)):
            assert part.shape == (segments, 8)
            np.testing.assert_array_equal(part, np.tile(whole / segments, (segments, 1)))


@pytest.mark.parametrize("segments", [1, 3])
def test_a_lighter_tube_tends_to_none_in_proportion_to_its_mass(segments):
    massless = simulate(Groups(), WORD, 1.0, tolerance=1e-10)
    errors = []
    for tube_mass in (1e-2, 1e-3):
        scene = Scene(segments=segments, tube_mass=tube_mass)
        done = simulate(Groups(), WORD, 1.0, scene=scene, tolerance=1e-10)
        assert done.slips == massless.slips
        errors.append(np.abs(done.foot - massless.foot).max())
    assert errors[0] < 1e-2
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)


def test_one_heavy_segment_has_half_the_tube_at_each_end():
    # Twice the mass everywhere is the same crawler, in its own unit of time.
    r, mass = 0.3, 2.0
    tube = 2.0 * (mass * r - r)  # so that the foot, r + tube / 2, weighs twice as much; payload (1 - r) + tube / 2
    payload = 1.0 - r + 0.5 * tube
    own = Groups(foot_mass_fraction=mass * r / (mass * r + payload))
    unit = np.sqrt(1.0 + tube)
    heavy = simulate(
        replace(Groups(), damping_ratio=own.damping_ratio * unit, deborah=own.deborah * unit),
        WORD,
        1.0 * unit,
        scene=Scene(tube_mass=tube, slope=0.1 / (1.0 + tube)),
        tolerance=1e-13,
    )
    plain = simulate(own, WORD, 1.0, scene=Scene(slope=0.1), tolerance=1e-13)
    assert heavy.model == f"half the tube's mass at each end, {plain.model}"
    np.testing.assert_allclose(heavy.foot, plain.foot, rtol=0, atol=1e-11)
    np.testing.assert_allclose(heavy.velocity, plain.velocity / unit, rtol=0, atol=1e-11)
    np.testing.assert_allclose(heavy.events["time"], plain.events["time"] * unit, rtol=1e-11)
    assert heavy.work == pytest.approx(plain.work, abs=1e-12)


# Against closed forms


def mode(segments, tube_mass, payload, number):
    """Frequency and node displacements of a normal mode of masses on equal springs, clamped behind.

    Displacement sin(j theta) with omega^2 = 4 (k / m) sin^2(theta / 2), and the payload's own equation for theta.
    """
    stiffness, mass, end = segments, tube_mass / segments, payload + 0.5 * tube_mass / segments

    def payload_equation(theta):
        square = 4.0 * stiffness / mass * np.sin(0.5 * theta) ** 2
        pull = np.sin(segments * theta) - np.sin((segments - 1) * theta)
        return end * square * np.sin(segments * theta) - stiffness * pull

    # sin(N theta) has one sign between its zeros, in which the ratio of the two terms passes 1 once.
    theta = brentq(
        payload_equation, (number + 1e-9) * np.pi / segments, (number + 1 - 1e-9) * np.pi / segments, xtol=1e-15
    )
    return 2.0 * np.sqrt(stiffness / mass) * np.sin(0.5 * theta), np.sin(np.arange(segments + 1) * theta)


@pytest.mark.parametrize("segments", [2, 3, 8, 32])
@pytest.mark.parametrize("tube_mass", [0.1, 3.0])
@pytest.mark.parametrize("number", [0, 1, -1])
def test_a_linear_anchored_chain_swings_in_its_normal_modes(segments, tube_mass, number):
    groups = Groups(**BOUNCER)
    payload = 1.0 - groups.foot_mass_fraction
    frequency, shape = mode(segments, tube_mass, payload, number % segments)
    initial = ChainState(np.diff(shape), np.zeros(segments))
    scene = Scene(anchored=True, segments=segments, tube_mass=tube_mass)
    done = simulate(groups, [0] * 4, 5.0 / frequency, scene=scene, initial=initial, samples_per_hold=3, tolerance=1e-13)
    swing = np.cos(frequency * done.time)
    np.testing.assert_allclose(done.segment_deformation, np.diff(shape)[:, None] * swing, rtol=0, atol=1e-11)
    np.testing.assert_allclose(done.deformation, shape[-1] * swing, rtol=0, atol=1e-11)


@pytest.mark.parametrize("tube_mass", [0.3, 2.0])
def test_converges_to_the_continuous_rod_with_the_square_of_the_number_of_segments(tube_mass):
    # m u_tt = u_xx on (0, 1), u = 0 behind and M u_tt = -u_x at the payload: u = sin(kappa x) with
    # kappa tan(kappa) = m / M and omega = kappa / sqrt(m).
    groups = Groups(**BOUNCER)
    ratio = tube_mass / (1.0 - groups.foot_mass_fraction)
    kappa = brentq(lambda k: k * np.sin(k) - ratio * np.cos(k), 0.0, 0.5 * np.pi)
    errors = []
    for segments in (4, 8, 16, 32):
        stretch = np.diff(np.sin(kappa * np.linspace(0.0, 1.0, segments + 1)))
        scene = Scene(anchored=True, segments=segments, tube_mass=tube_mass)
        done = simulate(groups, [0] * 10, 1.0, scene=scene, initial=ChainState(stretch, 0.0 * stretch), tolerance=1e-12)
        swing = np.sin(kappa) * np.cos(kappa / np.sqrt(tube_mass) * done.time)
        errors.append(np.abs(done.deformation - swing).max())
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4.0, rtol=0.1)


def test_the_driven_crawler_converges_with_the_number_of_segments():
    feet = [
        simulate(Groups(), WORD, 1.0, scene=Scene(segments=n, tube_mass=0.5), tolerance=1e-10).foot[-1]
        for n in (2, 4, 8, 16)
    ]
    steps = np.abs(np.diff(feet))
    assert (steps[1:] < 0.5 * steps[:-1]).all()


# Conservation


@pytest.mark.parametrize("segments", [2, 5, 20])
@pytest.mark.parametrize("mass", [0.01, 0.3])
def test_without_friction_the_momentum_is_conserved(segments, mass):
    groups, tube_mass = Groups(**FREE, foot_mass_fraction=mass), 0.4
    scene = Scene(ratchet=False, segments=segments, tube_mass=tube_mass)
    rng = np.random.default_rng(segments)
    start = ChainState(rng.uniform(-0.1, 0.1, segments), rng.uniform(-0.1, 0.1, segments), 0.2, 0.0, 30.0)
    done = simulate(groups, WORD, 1.0, scene=scene, initial=start, tolerance=1e-9)
    assert done.slips == 0

    def centre(foot, stretch):
        places = np.vstack([foot, foot + np.cumsum(stretch, axis=0)])
        masses = np.array([mass, *[0.0] * (segments - 1), 1.0 - mass]) + tube_mass / segments
        masses[[0, -1]] -= 0.5 * tube_mass / segments
        return masses @ places

    def column(values):
        return np.asarray(values)[:, None]

    momentum = centre(np.array([30.0]), column(start.segment_velocity))[0]
    np.testing.assert_allclose(centre(done.foot_velocity, done.segment_velocity), momentum, rtol=1e-13)
    where = centre(np.zeros(1), column(start.segment_deformation))[0] + momentum * done.time
    np.testing.assert_allclose(centre(done.foot, done.segment_deformation), where, rtol=1e-13)


@pytest.mark.parametrize("scene", SCENES, ids=str)
@pytest.mark.parametrize("segments", [2, 6])
def test_the_balance_closes_to_the_tolerance(scene, segments):
    scene = replace(scene, segments=segments, tube_mass=0.5)
    for tolerance in 10.0 ** np.arange(-14, -3, 2):
        done = run(Groups(), [0, 1, 0, 1], 4.16, scene=scene, tolerance=tolerance)
        assert abs(done.energy_residual) < 3.0 * tolerance + 1e-13


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6, 1e-12])
def test_a_motion_fainter_than_the_tolerance_does_not_grow_to_it(tolerance):
    # Neighbours against each other is the fastest motion of all; no error bound sees it until it has grown.
    segments, faint = 16, 1e-14
    stretch = faint * (-1.0) ** np.arange(segments)
    scene = Scene(anchored=True, segments=segments, tube_mass=0.1)
    groups = Groups(**BOUNCER)
    done = simulate(groups, [0] * 20, 5.0, scene=scene, initial=ChainState(stretch, 0.0 * stretch), tolerance=tolerance)
    assert np.abs(done.segment_deformation).max() < 10.0 * faint


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("segments", [2, 8])
@pytest.mark.parametrize("duffing", [0.0, 8.0, 300.0])
def test_the_error_is_of_the_order_of_the_tolerance(tolerance, segments, duffing):
    groups = Groups(duffing=duffing, radial_coupling=0.0)
    scene = Scene(anchored=True, segments=segments, tube_mass=0.3)
    done, exact = (simulate(groups, [1, 0, 1], 3.0, scene=scene, tolerance=t) for t in (tolerance, 1e-14))
    assert np.abs(done.deformation - exact.deformation).max() < 100.0 * tolerance
    assert np.abs(done.segment_deformation - exact.segment_deformation).max() < 100.0 * tolerance


# What is returned


CHAIN = Scene(segments=4, tube_mass=0.5)


def test_segments_sum_to_the_body():
    done = run(Groups(), WORD, 1.0, scene=CHAIN, samples_per_hold=3)
    assert done.model == "chain of 4 segments, on the ground, taylor"
    assert simulate(Groups(), [1], 1.0, scene=replace(CHAIN, anchored=True)).model.endswith("anchored, taylor")
    assert done.segment_deformation.shape == done.segment_velocity.shape == (4, 24)
    np.testing.assert_allclose(done.segment_deformation.sum(axis=0), done.deformation, rtol=0, atol=1e-14)
    np.testing.assert_allclose(done.segment_velocity.sum(axis=0), done.velocity, rtol=0, atol=1e-14)
    # The tube's own weight tells: the segment behind pulls more than the one in front.
    assert np.ptp(done.segment_deformation, axis=0).max() > 0.01


def test_sampling_more_often_changes_nothing():
    once, often = (run(Groups(), WORD, 1.0, scene=CHAIN, samples_per_hold=n) for n in (2, 10))
    for name in (*SAMPLED, "segment_deformation", "segment_velocity"):
        np.testing.assert_array_equal(getattr(once, name), getattr(often, name)[..., 4::5])
    np.testing.assert_array_equal(once.events, often.events)
    assert once.work == often.work


def test_batch_rows_are_single_runs():
    members, valves = [Groups(), Groups(deborah=2.0, duffing=3.0)], [WORD, WORD[::-1]]
    batch = simulate(members, valves, 0.8, scene=CHAIN, samples_per_hold=2)
    assert batch.segment_deformation.shape == (2, 4, 16)
    for row, (groups, valve) in enumerate(zip(members, valves, strict=True)):
        alone = simulate(groups, valve, 0.8, scene=CHAIN, samples_per_hold=2)
        for name in (*SAMPLED, "segment_deformation", "segment_velocity", "work", "stored", "slips"):
            np.testing.assert_array_equal(getattr(batch, name)[row], getattr(alone, name))
        np.testing.assert_array_equal(batch.events["time"][batch.events["crawler"] == row], alone.events["time"])


@pytest.mark.parametrize("scene", [CHAIN, Scene(segments=3), Scene(tube_mass=0.5), Scene()], ids=str)
def test_a_simulation_continues_from_its_final_state(scene):
    whole = run(Groups(), WORD * 2, 1.0, scene=scene, tolerance=1e-14)
    first = run(Groups(), WORD, 1.0, scene=scene, tolerance=1e-14)
    assert isinstance(first.final_state, ChainState if scene.segments > 1 else State)
    second = simulate(Groups(), WORD, 1.0, scene=scene, tolerance=1e-14, initial=first.final_state)
    np.testing.assert_allclose(second.foot, whole.foot[8:], rtol=0, atol=1e-12)
    np.testing.assert_allclose(second.segment_deformation, whole.segment_deformation[:, 8:], rtol=0, atol=1e-12)


def test_si_scales_the_segments():
    actuator = Actuator.ecoflex()
    done = simulate(actuator.groups, WORD, 1.0, scene=CHAIN)
    si, scales = done.in_si(actuator), actuator.scales
    np.testing.assert_allclose(si.segment_deformation, done.segment_deformation * scales.length, rtol=1e-15)
    np.testing.assert_allclose(si.segment_velocity, done.segment_velocity * scales.length / scales.time, rtol=1e-15)


# Refusals


@pytest.mark.parametrize(
    ("fields", "error", "says"),
    [
        *[({"segments": bad}, ValueError, r"segments must be a whole number in \[1, 1000\]") for bad in (0, -2, 1001)],
        *[({"segments": bad}, TypeError, r"segments must be a whole number") for bad in (2.0, "2", None, True)],
        *[({"tube_mass": bad}, ValueError, r"tube_mass must be in \[0, inf\)") for bad in (-0.1, np.inf, np.nan)],
        *[({"tube_mass": bad}, TypeError, r"tube_mass must be a number") for bad in ("1", None, True)],
    ],
)
def test_a_scene_refuses_what_is_no_tube(fields, error, says):
    with pytest.raises(error, match=says):
        Scene(**fields)


EVEN = [0.1] * 4


@pytest.mark.parametrize(
    ("scene", "initial", "error", "says"),
    [
        (CHAIN, ChainState([0.1] * 3, EVEN), ValueError, "segment_deformation must have segments = 4 values, got 3"),
        (CHAIN, ChainState(EVEN, [0.1] * 5), ValueError, "segment_velocity must have segments = 4 values, got 5"),
        (CHAIN, ChainState([EVEN], EVEN), ValueError, "segment_deformation must be 1-dimensional"),
        (CHAIN, ChainState([0.1, 0.1, np.nan, 0.1], EVEN), ValueError, "segment_deformation must be finite"),
        (CHAIN, ChainState("long", EVEN), TypeError, "segment_deformation must be an array"),
        (CHAIN, ChainState(EVEN, EVEN, pressure=2.0), ValueError, r"initial pressure must be in \[0, 1\]"),
        (CHAIN, ChainState(EVEN, EVEN, foot_velocity=-1.0), ValueError, "initial foot_velocity"),
        (CHAIN, (0.0, 0.0), TypeError, "initial must be a State or a ChainState"),
        (Scene(segments=2), ChainState([0.1, 0.2], [0.0, 0.0]), ValueError, "same for all .* where tube_mass is 0"),
    ],
)
def test_refuses_an_initial_state_that_is_no_chain_of_the_scene(scene, initial, error, says):
    with pytest.raises(error, match=says):
        simulate(Groups(), [1], 1.0, scene=scene, initial=initial)


def test_a_chain_too_light_for_its_segments_is_refused_with_a_remedy():
    # A million steps and a thousand for the hold, over a hundred: the budget is one of work.
    says = r"^the step budget of 10010 was spent at .*; take fewer segments than 1000, more tube_mass than 1e-06, a"
    with pytest.raises(SolverError, match=says):
        simulate(Groups(), [1], 1.0, scene=Scene(segments=1000, tube_mass=1e-6), tolerance=1e-2)


def test_a_chain_that_nothing_bounds_is_said_to_diverge():
    groups = Groups(duffing=0.0, radial_coupling=2.0)
    with pytest.raises(SolverError, match=r"diverged at time \d.*radial_coupling > 1 needs duffing > 0"):
        simulate(groups, [1] * 100, 10.0, scene=CHAIN)
