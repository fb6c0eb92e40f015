"""Lyapunov exponents against closed forms, finite differences in 50 digits, SciPy, and two motions under one input."""

import math
import warnings
from decimal import Decimal

import numpy as np
import pytest
from cases import WORD
from decimal_judge import decimal_judge
from scipy.integrate import solve_ivp

from stickslip import lyapunov_spectrum
from stickslip.crawler import Groups, REST, Scene, simulate, SolverError, State
from stickslip.crawler.motion import progress

ANCHORED = Scene(anchored=True)
BITS = np.random.default_rng(11).integers(0, 2, (3, 600))
LINEAR = {"duffing": 0.0, "radial_coupling": 0.0}
# Far above the digits of the judge, far below what the curvature of the motion would show.
NUDGE = Decimal("1e-14")


def measure(groups, change):
    """Size of a change of (z, v) or (z, v, momentum), in which a linear body at rest forgets without swinging."""
    stiffness = 1.0 / (1.0 - groups.foot_mass_fraction)
    decay = groups.damping_ratio * stiffness
    z, v, *momentum = change
    return math.sqrt((v + decay * z) ** 2 + (stiffness - decay**2) * z**2 + sum(m**2 for m in momentum))


@pytest.mark.parametrize("groups", [LINEAR, {"duffing": 200.0, "radial_coupling": 0.3}, {"damping_ratio": 2.0}])
def test_exponents_of_an_anchored_body_sum_to_the_damping(groups):
    found = lyapunov_spectrum(groups, BITS[0], 0.5, scene=ANCHORED)
    groups = Groups.of(groups)
    damping = -2.0 * groups.damping_ratio / (1.0 - groups.foot_mass_fraction)
    assert found.exponents.sum() == pytest.approx(damping, rel=1e-12)
    assert found.divergence == pytest.approx(damping, rel=1e-12)
    assert found.exponents[0] >= found.exponents[1]
    assert found.lag_exponent == -1.0 / groups.deborah
    assert math.isnan(found.foot_exponent)
    assert found.stops == 0


@pytest.mark.parametrize(("damping", "hold"), [(0.02, 0.5), (0.8, 0.5), (0.05, 3e4)])
def test_both_exponents_of_a_linear_body_that_swings_are_half_the_damping(damping, hold):
    found = lyapunov_spectrum({**LINEAR, "damping_ratio": damping}, BITS[0], hold, scene=ANCHORED)
    np.testing.assert_allclose(found.exponents, -damping / 0.7, rtol=1e-9)
    assert found.verdict == "contracting"


@pytest.mark.parametrize("solver", ["closed_form", "radau"])
def test_exponents_of_an_overdamped_body_are_its_rates_however_far_apart(solver):
    groups = Groups(**LINEAR, damping_ratio=1e3)
    found = lyapunov_spectrum(groups, BITS[0], 0.5, scene=ANCHORED, solver=solver)
    fast = (groups.damping_ratio + math.sqrt(groups.damping_ratio**2 - 0.7)) / 0.7
    np.testing.assert_allclose(found.exponents, [-1.0 / (0.7 * fast), -fast], rtol=1e-6)
    assert found.verdict == "contracting"


def test_exponents_are_per_natural_time_of_the_groups_where_the_tube_has_mass():
    scene = {"anchored": True, "tube_mass": 0.5}
    found = lyapunov_spectrum({**LINEAR, "damping_ratio": 0.1}, BITS[0], 0.5, scene=scene)
    # Half of the tube goes with either end; the damper stays as it is.
    np.testing.assert_allclose(found.exponents, -0.1 / (0.7 + 0.25), rtol=1e-9)


CASES = {
    "slips and stops": (Groups(), WORD * 2, 1.0, {}),
    "equal frictions": (Groups(kinetic_friction=0.3), WORD, 1.0, {}),
    "reversals": (
        Groups(foot_mass_fraction=0.8, static_friction=0.1, kinetic_friction=0.05),
        WORD,
        2.0,
        {"scene": Scene(ratchet=False)},
    ),
    "turning at once": (
        Groups(duffing=0.5, damping_ratio=0.01, static_friction=0.05, kinetic_friction=0.05),
        [0] * 4,
        3.0,
        {"initial": State(1.0, 0.0, 0.3), "scene": Scene(ratchet=False)},
    ),
    "downhill": (Groups(static_friction=0.6), WORD, 1.0, {"scene": Scene(slope=0.2)}),
    "uphill both ways": (Groups(static_friction=0.2), WORD[2:], 1.0, {"scene": Scene(ratchet=False, slope=0.3)}),
    "ratchet without friction": (Groups(static_friction=0.0, kinetic_friction=0.0), WORD, 1.0, {}),
}


@pytest.mark.parametrize("name", CASES)
def test_growth_through_events_is_what_finite_differences_in_fifty_digits_find(name):
    groups, valve, hold, options = CASES[name]
    initial, scene = options.get("initial", REST), options.get("scene")

    def end(start):
        z, v, _, w = decimal_judge(groups, valve, hold, scene=scene, initial=start).last
        return z, v, (w + (1 - Decimal(groups.foot_mass_fraction)) * v if w else Decimal(0))

    start = State(*map(Decimal, initial))
    here = end(start)
    moved = [start._replace(deformation=start.deformation + NUDGE), start._replace(velocity=start.velocity + NUDGE)]
    jacobian = np.array([[float((a - b) / NUDGE) for a, b in zip(end(one), here, strict=True)] for one in moved]).T
    vector = math.log(measure(groups, jacobian @ [1.0, 1.0]) / measure(groups, [1.0, 1.0]))
    area = math.log(np.linalg.norm(np.cross(*jacobian.T)))

    done = simulate(groups, valve, hold, tolerance=1e-13, **options)
    assert done.slips > 0
    found = lyapunov_spectrum(groups, valve, hold, tolerance=1e-13, washout=0, **options)
    exact = np.array(sorted([vector, area - vector], reverse=True))
    np.testing.assert_allclose(found.exponents, exact / found.time, rtol=0.0, atol=3e-8)
    modes = done.events["mode"].tolist()
    assert found.stops == modes.count(0)
    assert found.foot_exponent == (-math.inf if found.stops else 0.0)
    # The smooth motion's part of the sum, by the time that the foot slides.
    times = [0.0, *done.events["time"].tolist(), done.time[-1]]
    r = groups.foot_mass_fraction
    rates = [-2.0 * groups.damping_ratio / (1.0 - r) / (r if mode else 1.0) for mode in [0, *modes]]
    assert found.divergence * found.time == pytest.approx(np.dot(np.diff(times), rates), rel=1e-9)


def test_chaos_of_a_forced_duffing_body_is_what_scipy_finds():
    groups, hold = Groups(duffing=200.0, damping_ratio=0.02, radial_coupling=0.3), 0.5
    valve = BITS[0, :80]
    found = lyapunov_spectrum(groups, valve, hold, scene=ANCHORED, tolerance=1e-13, washout=0)
    start = np.array([1.0, 1.0]) / measure(groups, [1.0, 1.0])
    state = np.array([0.0, 0.0, 0.0, *start])
    total = 0.0

    def rates(_, y, u):
        z, v, p, dz, dv = y
        force = p * (1.0 + groups.radial_coupling * z) - z - groups.duffing * z**3 - 2.0 * groups.damping_ratio * v
        change = (p * groups.radial_coupling - 1.0 - 3.0 * groups.duffing * z**2) * dz - 2.0 * groups.damping_ratio * dv
        return [v, force / 0.7, (u - p) / groups.deborah, dv, change / 0.7]

    for u in valve:
        state = solve_ivp(rates, (0.0, hold), state, "DOP853", args=(u,), rtol=1e-12, atol=1e-13).y[:, -1]
        size = measure(groups, state[3:])
        total += math.log(size)
        state[3:] /= size
    assert found.exponents[0] == pytest.approx(total / found.time, abs=1e-7)
    assert total > 0.0


@pytest.mark.parametrize("scene", [Scene(), Scene(ratchet=False, slope=0.1)])
def test_two_motions_under_one_input_part_at_the_rate_of_the_exponent(scene):
    groups, valve, hold, apart = Groups(), BITS[1, :60], 0.5, 1e-6
    ends = [
        simulate(groups, valve, hold, scene=scene, tolerance=1e-15, initial=State(0.1 + d, 0.1 + d))
        for d in (-0.5 * apart, 0.5 * apart)
    ]
    assert ends[0].slips > 10
    change = [getattr(ends[1], name)[-1] - getattr(ends[0], name)[-1] for name in ("deformation", "velocity")]
    if ends[0].foot_velocity[-1] != 0.0:
        change.append(ends[1].foot_velocity[-1] - ends[0].foot_velocity[-1] + 0.7 * change[1])
    rate = math.log(measure(groups, change) / measure(groups, [apart, apart])) / (len(valve) * hold)
    found = lyapunov_spectrum(groups, valve, hold, scene=scene, initial=State(0.1, 0.1), washout=0)
    assert found.exponents[0] < 0.0
    assert found.exponents[0] == pytest.approx(rate, abs=1e-5)


def test_verdicts_tell_chaos_from_forgetting():
    chaotic = lyapunov_spectrum({"duffing": 200.0, "damping_ratio": 0.02}, BITS, 0.5, scene=ANCHORED)
    assert chaotic.verdict == "chaotic"
    assert chaotic.exponents[0] == pytest.approx(0.07, abs=0.03)
    ground = lyapunov_spectrum({"duffing": 200.0, "damping_ratio": 0.02}, BITS, 0.5)
    assert ground.verdict == "contracting"
    assert ground.foot_exponent == -math.inf
    assert ground.stops > 300
    few = lyapunov_spectrum({"duffing": 2.0, "damping_ratio": 0.02}, BITS, 0.5, scene=ANCHORED)
    assert few.verdict == "undecided"


def test_verdicts_tell_what_is_neutral():
    undamped = lyapunov_spectrum({**LINEAR, "damping_ratio": 0.0}, BITS[0], 0.5, scene=ANCHORED)
    np.testing.assert_allclose(undamped.exponents, 0.0, atol=1e-12)
    assert undamped.verdict == "neutral"
    # Without friction the momentum keeps every change; what is left of the body forgets, as one whose foot slides.
    free = lyapunov_spectrum(
        {**LINEAR, "static_friction": 0.0, "kinetic_friction": 0.0}, BITS[0], 0.5, scene={"ratchet": False}
    )
    assert (free.foot_exponent, free.stops, free.verdict) == (0.0, 0, "neutral")
    np.testing.assert_allclose(free.exponents, -0.05 / 0.21, atol=2.0 / free.time)
    assert free.exponents.sum() == pytest.approx(-0.1 / 0.21, rel=1e-9)
    stuck = lyapunov_spectrum({"static_friction": 9.0}, BITS[0], 0.5)
    assert math.isnan(stuck.foot_exponent)
    assert stuck.verdict == "contracting"


def test_verdicts_tell_two_motions_under_one_input():
    valve, starts = np.tile([0, 1], 150), [REST, State(2.0), State(-2.0, 1.0), State(1.0, -3.0)]
    several = lyapunov_spectrum({"duffing": 0.15}, valve, 2.0, scene=ANCHORED, initial=starts, washout=100)
    assert (several.attractors, several.verdict) == (2, "multistable")
    ends = [
        simulate({"duffing": 0.15}, valve, 2.0, scene=ANCHORED, initial=start).deformation[-1].round(6)
        for start in starts
    ]
    assert len(set(ends)) == 2
    one = lyapunov_spectrum({"duffing": 0.6}, valve, 2.0, scene=ANCHORED, initial=starts, washout=100)
    assert (one.attractors, one.verdict) == (1, "contracting")
    # What has had no time to come together is not told apart.
    short = lyapunov_spectrum({"duffing": 0.6}, valve[:20], 2.0, scene=ANCHORED, initial=starts, washout=0)
    assert short.attractors == 1
    alone = [lyapunov_spectrum({"duffing": 0.15}, valve, 2.0, scene=ANCHORED, initial=start) for start in starts[:2]]
    both = lyapunov_spectrum({"duffing": 0.15}, valve, 2.0, scene=ANCHORED, initial=starts[:2])
    assert both.exponents.sum() == pytest.approx(np.mean([each.exponents.sum() for each in alone]), rel=1e-9)
    rows = lyapunov_spectrum([{"duffing": 0.15}, {"duffing": 0.6}], valve, 2.0, scene=ANCHORED, initial=starts)
    assert rows.verdict.tolist() == ["multistable", "contracting"]
    assert rows[1].verdict == "contracting"


def test_rows_are_what_each_is_alone_and_inputs_are_averaged():
    rows = [Groups(), Groups(duffing=3.0)]
    alone = [
        lyapunov_spectrum(groups, BITS[:, :300], hold, scene=scene)
        for groups, hold, scene in zip(rows, [0.5, 1.0], [Scene(), ANCHORED], strict=True)
    ]
    together = lyapunov_spectrum(rows, BITS[np.newaxis, :, :300], [0.5, 1.0], scene=[Scene(), ANCHORED], threads=2)
    for name in ("exponents", "standard_error", "lag_exponent", "foot_exponent", "stops", "divergence", "time"):
        np.testing.assert_array_equal(getattr(together, name), [getattr(one, name) for one in alone])
    assert together.exponents.shape == (2, 2)
    assert together.verdict.tolist() == [one.verdict for one in alone]
    each = [lyapunov_spectrum(rows[0], one, 0.5) for one in BITS[:, :300]]
    assert alone[0].exponents.sum() == pytest.approx(np.mean([one.exponents.sum() for one in each]), rel=1e-12)
    assert alone[0].exponents[0] == pytest.approx(np.mean([one.exponents[0] for one in each]), rel=1e-12)
    own = lyapunov_spectrum(rows, BITS[:2, :300], 0.5)
    np.testing.assert_array_equal(own.exponents[0], each[0].exponents)
    shared = lyapunov_spectrum(rows, BITS[0, :300], 0.5)
    np.testing.assert_array_equal(shared.exponents[0], each[0].exponents)


def test_the_standard_error_is_that_of_the_blocks_and_covers_an_ensemble():
    groups = {"duffing": 50.0, "damping_ratio": 0.02}
    inputs = np.random.default_rng(3).integers(0, 2, (24, 800))
    one = lyapunov_spectrum(groups, inputs[0], 0.5, scene=ANCHORED)
    all_of_them = lyapunov_spectrum(groups, inputs, 0.5, scene=ANCHORED)
    for found, blocks in ((one, 20), (all_of_them, 24)):
        assert found.blocks.shape == (blocks, 2)
        np.testing.assert_allclose(found.blocks.mean(axis=0), found.exponents, rtol=1e-9)
        np.testing.assert_allclose(found.standard_error, found.blocks.std(axis=0, ddof=1) / math.sqrt(blocks))
    assert abs(one.exponents[0] - all_of_them.exponents[0]) < 4.0 * one.standard_error[0]
    ratio = one.standard_error[0] / all_of_them.standard_error[0]
    assert ratio == pytest.approx(math.sqrt(24), rel=0.5)


def test_duty_cycles_and_pauses_change_nothing(monkeypatch):
    whole = lyapunov_spectrum(Groups(), BITS[0, :60], 0.5, washout=10)
    as_duties = lyapunov_spectrum(Groups(), BITS[0, :60].astype(float), 0.5, washout=10)
    np.testing.assert_array_equal(whole.exponents, as_duties.exponents)
    halves = lyapunov_spectrum(Groups(), np.full(30, 0.5), 1.0, washout=5)
    pairs = lyapunov_spectrum(Groups(), np.tile([1, 0], 30), 0.5, washout=10)
    np.testing.assert_allclose(halves.exponents, pairs.exponents, rtol=1e-6)
    monkeypatch.setattr(progress, "PAUSE_AFTER", 7)
    np.testing.assert_array_equal(lyapunov_spectrum(Groups(), BITS[0, :60], 0.5, washout=10).exponents, whole.exponents)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"valve": [1]}, "valve must have at least 2 holds, got 1"),
        ({"valve": np.ones((1, 1, 1, 5))}, r"valve must have shape \(holds,\), \(inputs, holds\)"),
        ({"washout": 599}, r"washout must be a whole number in \[0, 598\], got 599"),
        ({"tolerance": 1.0}, r"tolerance must be in \[1e-15, 1e-2\], got 1.0"),
        ({"solver": "euler"}, "solver must be one of"),
        ({"groups": [Groups(), Groups()], "valve": BITS}, "groups and valve must have as many rows, got 2 and 3"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(arguments, message):
    given = {"groups": Groups(), "valve": BITS[0], "hold": 0.5, **arguments}
    with pytest.raises(ValueError, match=message):
        lyapunov_spectrum(**given)


@pytest.mark.parametrize("initial", [[], 3.0, (1.0, 2.0)])
def test_what_is_no_start_is_refused(initial):
    with pytest.raises(TypeError, match="initial must be a State"):
        lyapunov_spectrum(Groups(), BITS[0], 0.5, initial=initial)


WORD_OF_EIGHT = [0, 0, 0, 1, 1, 1, 0, 1] * 3


def test_a_direction_that_has_all_but_faded_is_a_direction():
    """Fluid and foot of a billionth: the change that is left of the washout has no square above 0."""
    groups = Groups(1e3, 1.0, 1e-9, 0.2, 1e-9, 0.3, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        faded, fading = (
            lyapunov_spectrum(groups, WORD_OF_EIGHT, hold, scene=Scene(slope=-0.1), washout=8) for hold in (10.0, 3.0)
        )
    np.testing.assert_allclose(faded.exponents, fading.exponents, rtol=0.05)


def test_an_exponent_that_floats_cannot_tell_is_not_told_in_silence():
    groups = Groups(1e3, 1e4, 1e4, 0.0, 1e-9, 0.0, 0.0)
    with pytest.warns(UserWarning, match="fade within one step by more than floats can tell"):
        found = lyapunov_spectrum(groups, [1, 0, 0, 0, 1, 0, 0, 0] * 3, 10.0, washout=8)
    assert found.exponents[0] == pytest.approx(-5e-5, rel=1e-4)  # of an overdamped spring: 1 / 2 damping
    assert np.isnan(found.exponents[1])


def test_defaults_are_those_of_the_page():
    word = [1, 0, 0, 1] * 60
    plain = lyapunov_spectrum({}, word, 1.0)
    written = lyapunov_spectrum(Groups(), word, 1.0, scene=Scene(), tolerance=1e-9, solver="auto", washout=200)
    np.testing.assert_array_equal(plain.exponents, written.exponents)
    for other in ({"tolerance": 1.001e-9}, {"washout": 199}):
        assert not np.array_equal(lyapunov_spectrum({}, word, 1.0, **other).exponents, plain.exponents)


def test_an_index_is_of_several():
    with pytest.raises(TypeError, match="an index is of one crawler of several, got one alone"):
        lyapunov_spectrum(Groups(), BITS[0, :60], 0.5, washout=10)[0]


def test_a_run_that_fails_names_its_row_and_input():
    with pytest.raises(SolverError, match=r"^crawler 0, input 1: the step budget of 20 was spent"):
        lyapunov_spectrum([{}, {}], [[[0] * 10, [1, 0] * 5]], 0.5, washout=0, max_steps=20, threads=1)
