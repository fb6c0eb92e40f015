"""Motions at the edge between two sequences of events, each with a truth of its own."""

import numpy as np
import pytest
from cases import assert_agrees, BOUNCER, run, WORD
from decimal_judge import decimal_judge
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from stickslip.crawler import Groups, Scene, simulate, State
from stickslip.crawler.loop import advance
from stickslip.crawler.model.state import Body, coefficients_of, FORWARD, NOTHING_YET, STUCK
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import FINISHED, Hold, Recording
from stickslip.crawler.steps.workspace import ROWS, WIDTH

SYMMETRIC = Scene(ratchet=False)


def kinds(done):
    return done.events["mode"].tolist()


# Equal frictions, and none


@pytest.mark.parametrize("friction", [0.01, 0.2, 0.6])
@pytest.mark.parametrize("ratchet", [True, False])
def test_equal_frictions_neither_hang_nor_lose_a_slip(friction, ratchet):
    groups, scene = Groups(static_friction=friction, kinetic_friction=friction), Scene(ratchet=ratchet)
    done = run(groups, WORD * 4, 1.0, scene=scene, tolerance=1e-14)
    verdict = decimal_judge(groups, WORD * 4, 1.0, scene=scene)
    assert verdict.slips >= 4
    assert_agrees(done, verdict, atol=1e-10)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12, 1e-15])
@pytest.mark.parametrize("ratchet", [True, False])
def test_equal_frictions_end_at_every_tolerance(tolerance, ratchet):
    for friction in np.linspace(0.0, 0.9, 19):
        groups = Groups(static_friction=friction, kinetic_friction=friction)
        done = run(groups, WORD * 4, 1.0, scene=Scene(ratchet=ratchet), tolerance=tolerance)
        assert done.slips <= 32, "a body of this frequency has no time for more"


def test_without_friction_the_centre_of_mass_keeps_its_speed():
    r, speed = 0.3, 0.7
    groups = Groups(static_friction=0.0, kinetic_friction=0.0, foot_mass_fraction=r)
    initial = State(velocity=0.2, foot=0.4, foot_velocity=speed)
    done = run(groups, [1, 0, 1, 1], 0.1, initial=initial, samples_per_hold=5, tolerance=1e-14)
    assert len(done.events) == 0
    centre = r * done.foot + (1.0 - r) * done.payload
    drift = r * speed + (1.0 - r) * (speed + 0.2)
    np.testing.assert_allclose(centre, 0.4 + drift * done.time, rtol=0, atol=1e-13)


def test_without_friction_or_diode_the_crawler_gets_nowhere():
    groups = Groups(static_friction=0.0, kinetic_friction=0.0)
    done = run(groups, WORD * 3, 1.0, scene=SYMMETRIC, samples_per_hold=3, tolerance=1e-14)
    centre = groups.foot_mass_fraction * done.foot + (1.0 - groups.foot_mass_fraction) * done.payload
    np.testing.assert_allclose(centre, 0.0, rtol=0, atol=1e-12)
    assert done.friction_loss == 0.0


def test_without_friction_the_diode_still_makes_it_crawl():
    groups = Groups(static_friction=0.0, kinetic_friction=0.0)
    done = run(groups, WORD * 3, 1.0, tolerance=1e-14, samples_per_hold=2)
    assert_agrees(done, decimal_judge(groups, WORD * 3, 1.0, samples_per_hold=2), atol=1e-10)
    assert done.foot[-1] > 1.0


def test_a_closed_valve_at_rest_stays_at_rest_even_without_friction():
    for scene in (Scene(), SYMMETRIC, Scene(anchored=True)):
        done = run(Groups(static_friction=0.0, kinetic_friction=0.0), [0, 0, 0], 7.0, scene=scene)
        assert done.slips == 0
        assert not done.deformation.any()
        assert not done.foot.any()


# Starting at the threshold. With no pressure F = -z - 2 Pi2 v, exactly -s where z = s and v = 0.


@pytest.mark.parametrize("scene", [Scene(), SYMMETRIC], ids=str)
@pytest.mark.parametrize("kinetic", [0.25, 0.1, 0.0])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-9, 1e-15])
def test_at_the_threshold_with_a_falling_force_it_slips_at_once(scene, kinetic, tolerance):
    groups = Groups(**BOUNCER, static_friction=0.25, kinetic_friction=kinetic)
    done = run(groups, [0], 1.0, scene=scene, initial=State(0.25, 0.1), tolerance=tolerance)
    assert kinds(done)[0] == FORWARD
    assert done.events["time"][0] == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("scene", [Scene(), SYMMETRIC], ids=str)
@pytest.mark.parametrize("kinetic", [0.25, 0.1, 0.0])
@pytest.mark.parametrize("velocity", [0.0, -0.1])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-9, 1e-15])
def test_at_the_threshold_with_a_rising_force_it_sticks(scene, kinetic, velocity, tolerance):
    # At v = 0 the payload is drawn back, so the force rises too, from a slope of zero.
    groups = Groups(**BOUNCER, static_friction=0.25, kinetic_friction=kinetic)
    done = run(groups, [0], 1.0, scene=scene, initial=State(0.25, velocity), tolerance=tolerance)
    assert done.slips == 0


@pytest.mark.parametrize("tolerance", [1e-3, 1e-9, 1e-15])
def test_beyond_the_threshold_it_slips_at_time_zero(tolerance):
    done = run(Groups(), [0], 1.0, initial=State(deformation=0.8), tolerance=tolerance)
    assert done.events[0].tolist() == (0.0, FORWARD, 0)


def test_backward_beyond_the_threshold_only_without_the_diode():
    initial = State(deformation=-0.8)
    assert kinds(run(Groups(), [0], 0.3, initial=initial)) == []
    assert kinds(run(Groups(), [0], 0.3, initial=initial, scene=SYMMETRIC)) == [-1]


# A grazing contact. Linear, undamped, no pressure, from z = -amplitude at rest: the pull on the foot is greatest,
# and equal to the amplitude, half a period pi sqrt(1 - r) later.


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12, 1e-15])
@pytest.mark.parametrize("ratio", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("hold", [0.3, 6.0])
def test_a_contact_that_grazes_from_either_side(tolerance, ratio, hold):
    static = 0.4
    groups = Groups(**BOUNCER, foot_mass_fraction=0.3, static_friction=static, kinetic_friction=ratio * static)
    # An error of the size of the tolerance shifts the graze; well beyond it the count is exact.
    miss = max(100.0 * tolerance, 1e-13)
    valve = [0] * round(4.0 / min(hold, 4.0))
    below = run(groups, valve, hold, initial=State(-(static - miss)), tolerance=tolerance)
    above = run(groups, valve, hold, initial=State(-(static + miss)), tolerance=tolerance)
    moment = np.pi * np.sqrt(0.7)
    assert below.slips == 0
    assert above.slips == 1
    assert above.events["time"][0] == pytest.approx(moment, abs=3.0 * np.sqrt(miss) + 1e-7)


def test_a_graze_of_a_nonlinear_crawler_found_by_bisection():
    base = {"kinetic_friction": 0.1, "damping_ratio": 0.02}
    valve = [1, 1, 0]

    def pull(static):
        verdict = decimal_judge(Groups(static_friction=static, **base), valve, 1.5)
        return verdict.slips

    low, high = 0.5, 5.0
    assert pull(low) > 0
    assert pull(high) == 0
    for _ in range(36):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if pull(middle) else (low, middle)
    for static in (low - 1e-9, low - 1e-10, high + 1e-10, high + 1e-9):
        groups = Groups(static_friction=static, **base)
        done = run(groups, valve, 1.5, tolerance=1e-15)
        assert done.slips == pull(static) == int(static < low)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-10])
@pytest.mark.parametrize("ratio", [0.0, 0.9, 1.0])
@pytest.mark.parametrize("seed", range(6))
def test_every_friction_about_a_graze_can_be_simulated(tolerance, ratio, seed):
    rng = np.random.default_rng(seed)
    base = {"duffing": float(rng.choice([0.0, 0.5, 10.0])), "foot_mass_fraction": float(rng.uniform(0.1, 0.9))}
    base["radial_coupling"] = float(rng.choice([0.0, 0.2]))
    valve, scene = [1, *rng.integers(0, 2, 16)], Scene(ratchet=bool(rng.random() < 0.6))

    def events_with(static):
        groups = Groups(static_friction=static, kinetic_friction=ratio * static, **base)
        return len(run(groups, valve, 0.3, scene=scene, tolerance=tolerance).events)

    low, high = 0.01, 1.5
    rare = events_with(high)
    for _ in range(60):  # past the last float between the two
        middle = 0.5 * (low + high)
        low, high = (low, middle) if events_with(middle) == rare else (middle, high)
    for miss in 10.0 ** np.arange(-16, -4):
        assert events_with(low - miss) < 40
        assert events_with(high + miss) < 40


# Grazes at which the force at the two ends of the interval that holds the root is equal to rounding.
FLAT = [
    (1e-10, 0.9682480411201321, 1.0, 0.05, 0.6895471677181331, "1000010001010001100001110"),
    (1e-9, 1.087749665655891, 0.0, 0.05, 0.6428721050130449, "110010011110101101001100"),
]


@pytest.mark.parametrize(("tolerance", "static", "ratio", "damping", "mass", "word"), FLAT)
def test_a_graze_too_flat_for_its_root_to_be_bracketed(tolerance, static, ratio, damping, mass, word):
    groups = Groups(10.0, damping, 0.5, 0.0, mass, static, ratio * static)
    valve = [int(letter) for letter in word]
    done = run(groups, valve, 0.3, tolerance=tolerance)
    exact = decimal_judge(groups, valve, 0.3)
    np.testing.assert_allclose(done.deformation[-1], exact.deformation[-1], rtol=0, atol=1e-4)


# Sliding at the start, events close together, events at a hold's end


@pytest.mark.parametrize("direction", [1, -1])
def test_starting_while_sliding(direction):
    groups, scene = Groups(), Scene(ratchet=direction == 1)
    initial = State(0.1, -0.3, 0.6, 2.0, direction * 0.5)
    done = run(groups, [1, 0, 0], 1.0, scene=scene, initial=initial, tolerance=1e-14, samples_per_hold=4)
    assert_agrees(
        done, decimal_judge(groups, [1, 0, 0], 1.0, scene=scene, initial=initial, samples_per_hold=4), atol=1e-11
    )
    assert kinds(done)[0] != direction, "the slip that was under way is not counted"


def test_a_foot_stops_under_kinetic_friction_alone():
    # With the spring at rest and a light payload moving along, the foot is braked by k / r, the payload by nothing.
    groups = Groups(**BOUNCER, foot_mass_fraction=1.0 - 1e-9, static_friction=0.5, kinetic_friction=0.5)
    done = run(groups, [0], 0.1, initial=State(0.0, 0.0, 0.0, 0.0, 0.01), tolerance=1e-13)
    assert done.events["time"][0] == pytest.approx(0.01 / 0.5, rel=1e-6)
    assert done.foot[-1] == pytest.approx(0.5 * 0.01**2 / 0.5, rel=1e-6)


@pytest.mark.parametrize("gap", [1e-3, 1e-5, 1e-7])
def test_two_events_very_close_together(gap):
    # Equal frictions, a force that dips below the threshold for a time of about `gap`.
    groups = Groups(**BOUNCER, foot_mass_fraction=0.3, static_friction=0.4, kinetic_friction=0.4)
    initial = State(-(0.4 + gap**2))
    done = run(groups, [0], 4.0, initial=initial, tolerance=1e-15)
    verdict = decimal_judge(groups, [0], 4.0, initial=initial)
    assert kinds(done) == [motion for _, motion in verdict.events] == [FORWARD, STUCK]
    near = 5e-14 / gap  # the root of a graze is as ill-conditioned as its gap is small
    np.testing.assert_allclose(done.events["time"], [float(t) for t, _ in verdict.events], rtol=0, atol=near)
    assert 0.5 * gap < np.diff(done.events["time"])[0] < 20.0 * gap


@pytest.mark.parametrize(
    ("ratchet", "event"), [(ratchet, event) for ratchet, count in ((True, 4), (False, 6)) for event in range(count)]
)
def test_an_event_exactly_at_a_holds_end(ratchet, event):
    groups, options = Groups(static_friction=0.1, kinetic_friction=0.05), {"scene": Scene(ratchet=ratchet)}
    options |= {"initial": State(deformation=1.2), "tolerance": 1e-15}
    moment = float(run(groups, [0], 20.0, **options).events["time"][event])
    for ulps in range(-12, 13):
        hold = moment + ulps * np.spacing(moment) if moment else 1.0
        cut = run(groups, [0] * 4, hold, **options)
        whole = run(groups, [0], 4 * hold, **options)
        # Whether the last instant is still before an event is for rounding to decide.
        assert kinds(cut)[:-1] == kinds(whole)[: len(cut.events) - 1]
        assert cut.foot[-1] == pytest.approx(whole.foot[-1], abs=1e-12)


def test_a_slip_that_rounding_brings_to_rest_at_a_holds_end_does_not_start_again():
    # Just before its stop the foot's velocity may round to exactly zero. The pull is then below kinetic friction,
    # and all the foot can do is stay where it is.
    groups = Groups()
    body = Body(0.0, 0.0, 0.0, 0.0, 0.0, STUCK, 0)
    rng = np.random.default_rng(4)
    missed = 0
    for _ in range(60):
        initial = State(deformation=float(rng.uniform(0.5, 1.5)))
        stops = [e for e in simulate(groups, [0], 5.0, initial=initial, tolerance=1e-15).events if e["mode"] == 0]
        moment = float(stops[0]["time"])
        for ulps in range(-12, 1):
            hold = moment + ulps * np.spacing(moment)
            first = _advanced(groups, body._replace(deformation=initial.deformation), hold)
            if first.body.mode != FORWARD:
                continue
            missed += 1
            second = _advanced(groups, first.body, 1e-3)
            assert second.body.mode == STUCK
            assert second.body.foot_velocity == 0.0
            assert second.body.foot == pytest.approx(first.body.foot, abs=1e-15)
    assert missed > 100


def _advanced(groups, body, hold):
    outcome = advance(
        body,
        NOTHING_YET,
        coefficients_of(groups, Scene()),
        Hold(0.0, hold, 0.0, hold, 0.0),
        SOLVERS["taylor"].options(1e-15),
        Recording(np.empty((5, 0)), np.empty((0, 2))),
        np.empty((ROWS, WIDTH)),
    )
    assert outcome.status == FINISHED
    return outcome


# Symmetric friction


def test_a_slip_forward_may_turn_at_once_into_a_slip_backward():
    groups = Groups(**BOUNCER, foot_mass_fraction=0.3, static_friction=0.05, kinetic_friction=0.05)
    initial = State(deformation=1.0)
    done = run(groups, [0], 6.0, scene=SYMMETRIC, initial=initial, tolerance=1e-14)
    verdict = decimal_judge(groups, [0], 6.0, scene=SYMMETRIC, initial=initial)
    assert kinds(done)[:3] == [1, -1, 1]
    assert done.slips >= 3
    assert_agrees(done, verdict, atol=1e-11)


def test_symmetric_friction_has_no_preferred_direction():
    # Mirrored in everything, a linear body without pressure does the mirrored thing.
    groups = Groups(damping_ratio=0.02, static_friction=0.1, kinetic_friction=0.05)
    there, back = (
        run(groups, [0] * 4, 1.0, scene=SYMMETRIC, initial=State(sign * 0.9, sign * 0.4), samples_per_hold=3)
        for sign in (1.0, -1.0)
    )
    np.testing.assert_array_equal(there.foot, -back.foot)
    np.testing.assert_array_equal(there.deformation, -back.deformation)
    np.testing.assert_array_equal(there.events["mode"], -back.events["mode"])


# The linear body against its closed form


def closed_form(groups, valve, hold, mass, samples_per_hold):
    """Samples of (z, v) of mass v' = p - z - 2 Pi2 v with Pi4 p' = u - p, from rest, by matrix exponentials."""
    rates = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-1.0 / mass, -2.0 * groups.damping_ratio / mass, 1.0 / mass, 0.0],
            [0.0, 0.0, -1.0 / groups.deborah, 1.0 / groups.deborah],
            [0.0, 0.0, 0.0, 0.0],
        ]
    )
    step = expm(rates * hold / samples_per_hold)
    state, rows = np.zeros(4), []
    for u in valve:
        state[3] = u
        for _ in range(samples_per_hold):
            state = step @ state
            rows.append(state[:2])
    return np.array(rows).T


@pytest.mark.parametrize("damping", [0.0, 0.05, 3.0])
@pytest.mark.parametrize("deborah", [0.05, 0.5, 5.0])
def test_anchored_and_linear_is_a_driven_oscillator(damping, deborah):
    groups = Groups(**BOUNCER | {"damping_ratio": damping, "deborah": deborah})
    valve = [*WORD, 1, 0, 1, 1, 0]
    done = run(groups, valve, 0.7, scene=Scene(anchored=True), samples_per_hold=3, tolerance=1e-14)
    z, v = closed_form(groups, valve, 0.7, 1.0 - groups.foot_mass_fraction, 3)
    np.testing.assert_allclose(done.deformation, z, rtol=0, atol=1e-12)
    np.testing.assert_allclose(done.velocity, v, rtol=0, atol=1e-12)


def test_sliding_and_linear_is_a_driven_oscillator_of_the_reduced_mass():
    groups = Groups(**BOUNCER, static_friction=0.0, kinetic_friction=0.0)
    r = groups.foot_mass_fraction
    # Fast enough never to stop, and without friction: only the reduced mass tells it from the anchored body.
    done = run(groups, WORD, 0.7, initial=State(foot_velocity=50.0), samples_per_hold=2, tolerance=1e-14)
    z, v = closed_form(groups, WORD, 0.7, r * (1.0 - r), 2)
    np.testing.assert_allclose(done.deformation, z, rtol=0, atol=1e-12)
    np.testing.assert_allclose(done.velocity, v, rtol=0, atol=1e-12)


@given(start=st.floats(0.0, 1.0), deborah=st.floats(0.01, 10.0))
def test_anchored_the_foot_never_moves(start, deborah):
    done = run(Groups(deborah=deborah), [1, 0], 0.5, scene=Scene(anchored=True), initial=State(0.3, 0.1, start, 1.5))
    assert (done.foot == 1.5).all()
    assert done.friction_loss == 0.0


def test_a_graze_that_only_the_truncated_series_crosses_is_no_slip():
    static = 0.5781409623827235
    groups = Groups(
        damping_ratio=0.5,
        foot_mass_fraction=0.43761223317172154,
        static_friction=static,
        kinetic_friction=0.786743609184651 * static,
    )
    for tolerance in (1e-4, 1e-12):
        done = run(groups, [1, 0], 2.5, tolerance=tolerance, samples_per_hold=40)
        assert done.slips == 0
        assert not done.foot.any()


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12, 1e-15])
def test_without_friction_a_foot_free_both_ways_breaks_loose_once(tolerance):
    # It touches rest wherever the force vanishes, and rounding decides how often: turning round is no slip.
    groups = Groups(
        duffing=153.15,
        damping_ratio=1.517,
        deborah=0.01558,
        radial_coupling=0.2739,
        foot_mass_fraction=0.07686,
        static_friction=0.0,
        kinetic_friction=0.0,
    )
    word = [int(letter) for letter in "1001100101000111111101110111111001011011"]
    assert run(groups, word, 3.0, scene=SYMMETRIC, tolerance=tolerance).slips == 1


# Forces whose rounding is larger than any absolute bound


def test_a_far_stretched_body_breaks_loose_where_its_rounded_force_says():
    # The cubic spring pulls with 3e6, whose rounding is 4e-10, and turns through the threshold of 538 at great speed.
    friction = 538.0031369674285
    groups = Groups(
        duffing=0.019015475488087526,
        damping_ratio=0.053210139905580316,
        deborah=5.871338440954477,
        radial_coupling=1.021791429786325,
        foot_mass_fraction=0.010630829956680592,
        static_friction=friction,
        kinetic_friction=friction,
    )
    start = State(friction, 0.37108459528124343, 0.0, -0.792461257929815, 0.17885615155793597)
    _assert_every_tolerance_finds_the_events(
        groups, [1, 1, 1, 0, 0, 1, 0], 0.07943560337623534, Scene(slope=50607.82075903098), start
    )


def test_heavy_friction_both_ways_is_met_at_every_tolerance():
    groups = Groups(static_friction=1e5, kinetic_friction=1e5)
    _assert_every_tolerance_finds_the_events(groups, [1, 0, 1, 0], 2.0, SYMMETRIC, State(-2.1 * 2e5 ** (1 / 3)))


def _assert_every_tolerance_finds_the_events(groups, word, hold, scene, start):
    verdict = decimal_judge(groups, word, hold, scene=scene, initial=start)
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        done = simulate(groups, word, hold, scene=scene, initial=start, solver="taylor", tolerance=tolerance)
        assert kinds(done) == [motion for _, motion in verdict.events]
        np.testing.assert_allclose(done.foot[-1], verdict.foot[-1], rtol=1e-7)
        np.testing.assert_allclose(done.events["time"], [float(time) for time, _ in verdict.events], rtol=1e-7)


@pytest.mark.parametrize("solver", ["taylor", "radau", "closed_form"])
def test_a_foot_with_hardly_any_speed_stops_no_later_than_its_drag_has_it(solver):
    # Over a whole step drag would take a speed of 1e5, whose rounding is as large as what there is to take.
    groups = Groups(0.0, 0.0, 5.4, 0.0, 2.8e-6, 253.0, 166.0)
    start = State(2.6, 0.8, 1.0, 0.0, 2e-11)
    arguments = {"scene": SYMMETRIC, "initial": start}
    done = simulate(groups, [1], 0.3, solver=solver, tolerance=1e-15, **arguments)
    verdict = decimal_judge(groups, [1], 0.3, **arguments)
    assert_agrees(done, verdict, atol=1e-13)
    np.testing.assert_allclose(done.events["time"], [float(time) for time, _ in verdict.events], rtol=1e-5)


# Without friction or damping every swing of a heavy foot grazes rest: the descent search meets near-double roots.


@pytest.mark.parametrize("solver", ["taylor", "radau"])
@pytest.mark.parametrize("tolerance", [1e-9, 1e-12])
def test_a_foot_that_grazes_rest_at_every_swing_does_not_hang(solver, tolerance):
    groups = Groups(
        duffing=0.9407036290740752,
        damping_ratio=0.0,
        deborah=0.004225826282863232,
        radial_coupling=0.1441836807054404,
        foot_mass_fraction=0.8776317530796933,
        static_friction=0.0,
        kinetic_friction=0.0,
    )
    done = run(groups, [1], 455.0, solver=solver, tolerance=tolerance)
    assert done.foot[-1] == pytest.approx(148.27141107, abs=1e4 * tolerance)
