"""The solver at the edges of the ranges, against the stored references of the stiff judge; and that judge."""

from decimal import Decimal

import mpmath
import numpy as np
import pytest
from cases import crawlers, HUNT, is_free, random_crawler, run, schedules, WORD
from decimal_judge import as_written, decimal_judge
from extreme_rows import LIGHT, ROWS, stored
from hypothesis import given, settings
from hypothesis import strategies as st
from stiff_judge import reference, SAMPLED, stiff_judge, stiff_run

from stickslip.crawler import Groups, Scene, simulate, SolverError, State
from stickslip.crawler.solvers import AUTO, solvers_for

SOLVERS = {name: (AUTO, *solvers_for(row.groups, Scene())) for name, row in ROWS.items()}
# An explicit method would take more than a million steps for a unit of time, and says so.
REFUSED = {("four stiff, slippery", "taylor"), ("linear, four stiff", "taylor")}
REFERENCE = stored()
EXACT = Decimal("1e-20")
# Nearer than this to another sequence of events, the tolerance may decide which it is.
UNDECIDED = 1e-6


CASES = [
    pytest.param(name, solver, tolerance, id=f"{name}, {solver}, {tolerance:g}")
    for name, solvers in SOLVERS.items()
    for solver in solvers
    if (name, solver) not in REFUSED
    for tolerance in ROWS[name].tolerances
]


@pytest.mark.parametrize(("name", "solver", "tolerance"), CASES)
def test_an_extreme_crawler_moves_as_the_judge_says(name, solver, tolerance):
    row, exact = ROWS[name], REFERENCE[name]
    done = run(row.groups, row.schedule, row.hold, tolerance=tolerance, solver=solver, **row.options)
    assert done.slips == exact["slips"]
    assert done.events["mode"].tolist() == [motion for _, motion in exact["events"]]
    allowed = 10.0 * tolerance
    moments = [float(time) for time, _ in exact["events"]]
    np.testing.assert_allclose(done.events["time"], moments, rtol=0, atol=allowed)
    for sampled in SAMPLED:
        expected = np.array(exact["samples"][sampled], dtype=float)
        np.testing.assert_allclose(getattr(done, sampled), expected, rtol=0, atol=allowed, err_msg=sampled)


@pytest.mark.parametrize(("name", "solver"), sorted(REFUSED))
def test_what_would_take_for_ever_is_refused_with_where_and_why_and_what_to_change(name, solver):
    row = ROWS[name]
    says = r"step budget of 1008000 .* at time \d.*solver 'taylor'.*damping over a sliding foot.*rate of 2e\+10.*radau"
    with pytest.raises(SolverError, match=says):
        simulate(row.groups, [int(u) for u in row.schedule], row.hold, tolerance=1e-6, solver=solver, **row.options)


def test_references_are_those_of_the_rows():
    assert list(REFERENCE) == list(ROWS)
    for name, row in ROWS.items():
        assert {key: REFERENCE[name][key] for key in row.inputs()} == row.inputs()


@pytest.mark.parametrize("name", ["Pi2 = 1", "linear, four stiff", "stop and slip within 1e-12"])
def test_a_stored_reference_is_found_again_with_other_nodes(name):
    row, exact = ROWS[name], REFERENCE[name]
    found = stiff_run(row.groups, row.schedule, row.hold, nodes=21, **row.options)
    _assert_same(zip(*found.samples, strict=True), exact["samples"].values())
    _assert_same([[moment for moment, _ in found.events]], [[moment for moment, _ in exact["events"]]])
    assert [motion for _, motion in found.events] == [motion for _, motion in exact["events"]]


@pytest.mark.slow
@pytest.mark.parametrize("name", ROWS)
def test_every_stored_reference_is_found_again(name):
    found, exact = reference(ROWS[name]), REFERENCE[name]
    _assert_same(found["samples"].values(), exact["samples"].values())
    _assert_same([[moment for moment, _ in found["events"]]], [[moment for moment, _ in exact["events"]]])
    assert [motion for _, motion in found["events"]] == [motion for _, motion in exact["events"]]
    assert found["condition"] == pytest.approx(exact["condition"], rel=0.05)


def _assert_same(found, expected):
    """Rows of numbers to twenty digits."""
    for values, others in zip(found, expected, strict=True):
        for value, other in zip(values, others, strict=True):
            assert abs(Decimal(value) - Decimal(other)) < EXACT * max(1, abs(Decimal(other)))


# The judge


@pytest.mark.slow
def test_stiff_judge_meets_the_check_value():
    verdict = stiff_judge(Groups(), WORD * 25, 1.0, number=as_written)
    assert abs(verdict.last_foot - Decimal("32.03368882790800707974502")) < Decimal("1e-23")
    assert verdict.slips == 50


@pytest.mark.parametrize("seed", [0, 1, 2, 5, 7, 9, 10, 12])
def test_judges_agree_to_twenty_digits_where_nothing_is_stiff(seed):
    groups, valve, hold, options = random_crawler(np.random.default_rng(seed), anchored=seed % 10 == 0)
    hold, valve = min(hold, 2.0), valve[:4]
    ours, other = (judge(groups, valve, hold, **options) for judge in (stiff_judge, decimal_judge))
    if not is_free(groups, options["scene"]):
        assert [motion for _, motion in ours.events] == [motion for _, motion in other.events]
        assert all(abs(a - b) < EXACT for (a, _), (b, _) in zip(ours.events, other.events, strict=True))
    assert abs(ours.last_foot - other.last_foot) < EXACT
    np.testing.assert_allclose(ours.deformation, other.deformation, rtol=0, atol=1e-15)


LINEAR = [name for name, row in ROWS.items() if row.groups.duffing == row.groups.radial_coupling == 0.0]


@pytest.mark.parametrize("name", LINEAR)
def test_a_linear_reference_satisfies_its_closed_form(name):
    row, exact = ROWS[name], REFERENCE[name]
    holds = len(row.schedule)
    with mpmath.workdps(70):
        # X_p, X_f, their rates, the pressure and a constant 1, propagated by matrix exponentials.
        z, v, p, x, w = (mpmath.mpf(value) for value in row.initial)
        state, now = mpmath.matrix([x + z, x, v + w, w, p, 1]), mpmath.mpf(0)
        motion = int(mpmath.sign(w))
        hold = mpmath.mpf(row.hold)
        ticks = [
            (k * hold + hold * (j + 1) / row.samples_per_hold, None)
            for k in range(holds)
            for j in range(row.samples_per_hold)
        ]
        events = [(mpmath.mpf(time), following) for time, following in exact["events"]]
        samples = iter(zip(*(exact["samples"][sampled] for sampled in SAMPLED), strict=True))
        for moment, following in sorted(ticks + events, key=lambda stop: stop[0]):
            command = row.schedule[min(int(now / hold + mpmath.mpf("1e-12")), holds - 1)]
            rates = _rates(row.groups, motion, command)
            state = mpmath.expm(rates * (moment - now)) * state
            now = moment
            if following is None:
                z, v = state[0] - state[1], state[2] - state[3]
                for value, expected in zip((z, v, state[4], state[1], state[3]), next(samples), strict=True):
                    assert abs(value - mpmath.mpf(expected)) < mpmath.mpf("1e-20") * max(1, abs(value))
                continue
            force = (rates[2, :] * state)[0] * (1 - mpmath.mpf(row.groups.foot_mass_fraction))
            if motion:
                assert abs(state[3]) < 1e-18
                state[3] = 0
            elif now > 0:
                assert abs(row.groups.static_friction + following * force) < 1e-18
            motion = following


def _rates(groups, motion, command):
    """The linear crawler's matrix: equations 2 and 7 to 9 with Pi1 = Pi5 = 0."""
    g = {name: mpmath.mpf(value) for name, value in groups.to_dict().items()}
    r, b = g["foot_mass_fraction"], 2 * g["damping_ratio"]
    force = mpmath.matrix([[-1, 1, -b, b, 1, 0]])
    rates = mpmath.zeros(6)
    rates[0, 2] = 1
    rates[2, :] = force / (1 - r)
    if motion:
        rates[1, 3] = 1
        rates[3, :] = -force / r
        rates[3, 5] = -motion * g["kinetic_friction"] / r
    rates[4, 4], rates[4, 5] = -1 / g["deborah"], command / g["deborah"]
    return rates


# What no reference is needed for


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_a_slip_shallower_than_rounding_may_go_unseen_but_moves_nothing(tolerance):
    # Pulled too hard by 1e-14, ever less so: the foot would slide by some 1e-40.
    groups = Groups(0.0, 0.0, 0.5, 0.0, 0.3, 0.25, 0.25)
    initial = State(0.25 + 1e-14, -0.1)
    exact = stiff_judge(groups, WORD[:2], 1.0, initial=initial)
    assert exact.slips == 1
    done = run(groups, WORD[:2], 1.0, initial=initial, tolerance=tolerance)
    assert done.slips <= 1
    np.testing.assert_allclose(done.deformation, exact.deformation, rtol=0, atol=10.0 * tolerance)
    assert abs(done.foot).max() < 1e-15


@pytest.mark.parametrize("radial_coupling", [1.5, 5.0])
def test_a_body_that_nothing_bounds_is_refused(radial_coupling):
    with pytest.raises(SolverError, match=r"diverged at time .* needs duffing > 0"):
        simulate(Groups(duffing=0.0, radial_coupling=radial_coupling), [1], 1e4, tolerance=1e-6)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_a_million_holds_do_not_drift_in_the_balance_of_energy(tolerance):
    valve = np.random.default_rng(0).integers(0, 2, 1_000_000)
    for holds in (100_000, 1_000_000):
        done = simulate(Groups(), valve[:holds], 0.1, tolerance=tolerance)
        # Each hold is charged with its own defect, and a sum of so many terms with their rounding.
        rounding = np.finfo(float).eps * done.work * np.sqrt(holds)
        assert abs(done.energy_residual) <= 0.01 * tolerance * done.work + rounding
    assert done.slips > 10_000


@pytest.mark.parametrize("extreme", ["Pi1 = 1e6", "Pi2 = 1e2", "Pi4 = 1e-6", "r = 1e-6", "r = 1 - 1e-6, undamped"])
@pytest.mark.parametrize("place", [0, 2])
def test_an_extreme_crawler_in_a_batch_changes_no_other(extreme, place):
    others = [Groups(), Groups(deborah=2.0), Groups(duffing=5.0)]
    mixed = [*others[:place], ROWS[extreme].groups, *others[place:]]
    batch = simulate(mixed, WORD * 2, 0.5, samples_per_hold=2)
    for member, groups in enumerate(mixed):
        alone = simulate(groups, WORD * 2, 0.5, samples_per_hold=2)
        for name in (*SAMPLED, "slips", "work", "stored", "viscous_loss", "friction_loss"):
            np.testing.assert_array_equal(getattr(batch, name)[member], getattr(alone, name))
        mine = batch.events[batch.events["crawler"] == member]
        np.testing.assert_array_equal(mine[["time", "mode"]], alone.events[["time", "mode"]])


# The whole box


def _decades(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda exponent: float(10.0**exponent))


box = st.builds(
    lambda ratio, **groups: Groups(kinetic_friction=ratio * groups["static_friction"], **groups),
    ratio=st.sampled_from([0.0, 0.5, 1.0 - 1e-6, 1.0]),
    duffing=st.just(0.0) | _decades(1e-6, 1e6),
    damping_ratio=st.just(0.0) | _decades(1e-6, 1e4),
    deborah=_decades(1e-6, 1e6),
    radial_coupling=st.just(0.0) | st.floats(0.0, 5.0),
    foot_mass_fraction=_decades(LIGHT, 0.5) | _decades(LIGHT, 0.5).map(lambda light: 1.0 - light),
    static_friction=st.just(0.0) | _decades(1e-6, 1e3),
)
states = st.none() | st.builds(
    State,
    deformation=st.floats(-3.0, 3.0),
    velocity=st.floats(-3.0, 3.0),
    pressure=st.floats(0.0, 1.0),
    foot=st.just(0.0),
    foot_velocity=st.just(0.0) | _decades(1e-6, 3.0),
)


def _slips_or_refusal(groups, valve, hold, tolerance, options):
    try:
        done = run(groups, valve, hold, tolerance=tolerance, **options)
    except SolverError as error:
        return str(error)
    assert all(np.isfinite(getattr(done, name)).all() for name in SAMPLED)
    return done.slips


def _check_everywhere(groups, valve, hold, ratchet, initial):
    options = {"scene": Scene(ratchet=ratchet), "initial": initial, "samples_per_hold": 2}
    loose, tight = (_slips_or_refusal(groups, valve, hold, tolerance, options) for tolerance in (1e-9, 1e-12))
    for refusal in (loose, tight):
        if isinstance(refusal, str):
            unbounded = groups.duffing == 0.0 and groups.radial_coupling > 1.0
            assert "step budget" in refusal or ("diverged" in refusal and unbounded)
            return
    if loose != tight and not is_free(groups, options["scene"]):
        verdict = stiff_judge(groups, valve, hold, **options)
        assert verdict.clearance < UNDECIDED, f"{loose} and {tight} slips, {verdict.slips} by the judge"


@HUNT
@given(groups=box, valve=schedules, hold=_decades(1e-6, 2.0), ratchet=st.booleans(), initial=states)
def test_everywhere_in_the_box_the_laws_hold_or_the_refusal_is_clear(groups, valve, hold, ratchet, initial):
    _check_everywhere(groups, valve[:3], hold, ratchet, initial)


@pytest.mark.slow
@settings(HUNT, max_examples=100)
@given(groups=box, valve=schedules, hold=_decades(1e-6, 1e4), ratchet=st.booleans(), initial=states)
def test_everywhere_in_the_box_at_length(groups, valve, hold, ratchet, initial):
    _check_everywhere(groups, valve[:3], hold, ratchet, initial)


@HUNT
@given(groups=crawlers, valve=schedules, hold=_decades(1e-6, 2.0), ratchet=st.booleans())
def test_slips_are_those_of_the_judge_over_random_groups(groups, valve, hold, ratchet):
    scene = Scene(ratchet=ratchet)
    exact = stiff_judge(groups, valve[:3], hold, scene=scene)
    done = run(groups, valve[:3], hold, scene=scene, tolerance=1e-9)
    if exact.clearance > UNDECIDED and not is_free(groups, scene):
        assert done.slips == exact.slips
    np.testing.assert_allclose(done.foot, exact.foot, rtol=0, atol=1e-6)


def test_the_stiff_judge_refuses_what_it_does_not_know():
    with pytest.raises(ValueError, match="level ground"):
        stiff_judge(Groups(), [1], 1.0, scene=Scene(slope=0.1))
