"""Radau IIA: its tables against mpmath, its motions against the judges and the Taylor series."""

import mpmath
import numpy as np
import pytest
from cases import assert_agrees, BOUNCER, crawlers, HUNT, is_free, random_crawler, run, schedules, starts, WORD
from decimal_judge import decimal_judge
from hypothesis import assume, given
from hypothesis import strategies as st
from judge import judge

from stickslip.compiling.roots import horner, horner_derivative
from stickslip.crawler import Groups, Scene, simulate, State
from stickslip.crawler.model.equations import acceleration_at_no_force, force, mobility_of, pressure_after
from stickslip.crawler.model.state import Body, coefficients_of, FORWARD, STUCK
from stickslip.crawler.steps.options import AFRESH, Pace
from stickslip.crawler.steps.radau import collocate, refine_event_step, stages_for
from stickslip.crawler.steps.radau_table import CHECKS, STAGES, TABLES
from stickslip.crawler.steps.workspace import FORCE, P, ROWS, V, WIDTH, Z

FOOT = 32.03368882790800707974502  # default groups, hold 1, from rest, after WORD x 25
UNDECIDED = 1e-7
SCENES = [Scene(), Scene(ratchet=False), Scene(anchored=True), Scene(slope=0.1), Scene(slope=-0.2, ratchet=False)]
METHODS = list(enumerate(STAGES))
ALL_FOUR = {"duffing": 1e6, "damping_ratio": 1e4, "deborah": 1e-6, "foot_mass_fraction": 1e-6}
STIFF = {
    "damping": {"damping_ratio": 100.0},
    "damping and a quick fluid": {"damping_ratio": 100.0, "deborah": 1e-3},
    "extreme damping": {"damping_ratio": 1e4},
    "quick fluid": {"deborah": 1e-6},
    "light foot": {"foot_mass_fraction": 1e-6},
    "light payload": {"foot_mass_fraction": 1.0 - 1e-6},
    "cubic spring": {"duffing": 1e6},
    "three": {"duffing": 1e6, "deborah": 1e-6, "foot_mass_fraction": 1e-6},
}


def exact_method(stages):
    """Butcher's A and c in the working precision of mpmath, from the definition."""
    # The zeros of P_s - P_(s-1) on [-1, 1], the last of them 1; guesses from the table, which a test compares.
    guesses = TABLES.nodes[STAGES.index(stages), 1 : stages + 1]

    def radau(t):
        return mpmath.legendre(stages, 2 * t - 1) - mpmath.legendre(stages - 1, 2 * t - 1)

    nodes = [mpmath.findroot(radau, mpmath.mpf(guess)) for guess in guesses]
    # C(s) determines A: sum_j a_ij c_j^(k-1) = c_i^k / k.
    powers = mpmath.matrix([[c**k for c in nodes] for k in range(stages)])
    moments = mpmath.matrix([[c ** (k + 1) / (k + 1) for c in nodes] for k in range(stages)])
    return (mpmath.inverse(powers) * moments).T, nodes


def floats(matrix):
    return np.array(matrix.tolist(), dtype=float)


# The tables


@pytest.mark.parametrize(("m", "stages"), METHODS)
def test_nodes_and_coefficients_are_those_of_forty_digits(m, stages):
    with mpmath.workdps(40):
        matrix, nodes = exact_method(stages)
        np.testing.assert_array_equal(TABLES.nodes[m, : stages + 1], [0.0, *map(float, nodes)])
        np.testing.assert_allclose(TABLES.integral[m, :stages, :stages], floats(matrix), rtol=1e-15, atol=1e-30)
        np.testing.assert_allclose(TABLES.twice[m, :stages, :stages], floats(matrix * matrix), rtol=1e-15, atol=1e-30)


@pytest.mark.parametrize(("m", "stages"), METHODS)
def test_order_conditions(m, stages):
    nodes, matrix = TABLES.nodes[m, 1 : stages + 1], TABLES.integral[m, :stages, :stages]
    weights = matrix[-1]  # stiffly accurate: the step's end is its last stage
    assert nodes[-1] == 1.0
    for k in range(1, 2 * stages):
        assert weights @ nodes ** (k - 1) == pytest.approx(1.0 / k, abs=1e-15), "B(2 s - 1)"
    assert weights @ nodes ** (2 * stages - 1) != pytest.approx(1.0 / (2 * stages), abs=1e-13), "and no further"
    for k in range(1, stages + 1):
        np.testing.assert_allclose(matrix @ nodes ** (k - 1), nodes**k / k, rtol=0, atol=1e-15, err_msg="C(s)")


@pytest.mark.parametrize(("m", "stages"), METHODS)
def test_l_stability(m, stages):
    matrix = TABLES.integral[m, :stages, :stages]
    ones = np.ones(stages)
    for frequency in np.geomspace(1e-3, 1e6, 300):
        x = 1j * frequency
        amplification = 1.0 + x * matrix[-1] @ np.linalg.solve(np.eye(stages) - x * matrix, ones)
        assert abs(amplification) <= 1.0 + 1e-12
    assert np.linalg.eigvals(matrix).real.min() > 0.0, "no pole in the left half-plane"
    with mpmath.workdps(40):
        exact, _ = exact_method(stages)
        at_infinity = 1 - (exact[stages - 1, :] * mpmath.inverse(exact) * mpmath.ones(stages, 1))[0]
        assert abs(at_infinity) < 1e-30


@pytest.mark.parametrize(("m", "stages"), METHODS)
@pytest.mark.parametrize(("damping", "stiffness"), [(0.0, 1.0), (3.0, 0.2), (1e5, 1e2), (1e10, 1e10)])
def test_eigenvectors_solve_the_stages_equations(m, stages, damping, stiffness):
    matrix = TABLES.integral[m, :stages, :stages]
    parts = TABLES.left[m, :stages, :stages].astype(complex)
    eigenvalues = TABLES.eigenvalues[m, : stages // 2 + 1]
    quotients = 1.0 / (1.0 + damping * eigenvalues + stiffness * eigenvalues**2)
    solved = np.empty((stages, stages))
    solved[0] = quotients[0].real * parts[0].real
    for k in range(1, stages // 2 + 1):
        pair = quotients[k] * (parts[2 * k - 1] + 1j * parts[2 * k])
        solved[2 * k - 1], solved[2 * k] = pair.real, pair.imag
    inverse = TABLES.right[m, :stages, :stages] @ solved
    system = np.eye(stages) + damping * matrix + stiffness * matrix @ matrix
    np.testing.assert_allclose(system @ inverse, np.eye(stages), rtol=0, atol=1e-7)


@pytest.mark.parametrize(("m", "stages"), METHODS)
def test_values_between_the_nodes(m, stages):
    nodes = TABLES.nodes[m, : stages + 1]
    for degree in range(stages + 1):
        there = TABLES.between[m, :, : stages + 1] @ nodes**degree
        np.testing.assert_allclose(there, TABLES.checks[m] ** degree, rtol=0, atol=1e-14)
        if degree < stages:
            backward = TABLES.backward[m, :stages] @ nodes[1:] ** degree
            assert backward == pytest.approx(float(degree == 0), abs=1e-13)


@pytest.mark.parametrize(("m", "stages"), METHODS)
def test_the_checks_are_where_the_polynomials_err_most(m, stages):
    everywhere = np.linspace(0.0, 1.0, 20_001)
    nodes = TABLES.nodes[m, 1 : stages + 1]
    monic = np.prod(everywhere[:, None] - nodes, axis=1)
    np.testing.assert_allclose(np.polynomial.polynomial.polyval(0.3, TABLES.monic[m]), np.prod(0.3 - nodes))
    height = abs(everywhere * monic)
    assert TABLES.check_product[m] == pytest.approx(height.max(), rel=1e-6)
    peaks = np.sort(height[1:-1][(height[1:-1] > height[:-2]) & (height[1:-1] > height[2:])])[::-1]
    at_checks = abs(TABLES.checks[m] * np.prod(TABLES.checks[m][:, None] - nodes, axis=1))
    np.testing.assert_allclose(at_checks, peaks[:CHECKS], rtol=1e-6)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (monic[1:] + monic[:-1]) * np.diff(everywhere))])
    assert TABLES.dense[m] == pytest.approx(abs(integral).max() / abs(monic[0]), rel=1e-4)


# One step


@pytest.mark.parametrize("stages", STAGES)
@pytest.mark.parametrize("motion", [STUCK, FORWARD])
@pytest.mark.parametrize("special", [{}, STIFF["extreme damping"], STIFF["light foot"]])
def test_a_step_obeys_the_equations_at_its_nodes(stages, motion, special):
    coefficients = coefficients_of(Groups(**special), Scene())
    body = Body(0.3, 1e-5, 0.9, 0.0, 0.1 if motion else 0.0, motion, 0)
    series = np.full((ROWS, WIDTH), np.nan)
    tolerance = 1e-9
    length, pace = collocate(body, coefficients, 0.0, 0.3, stages, tolerance, AFRESH._replace(length=1e-3), series)
    assert 0.0 < length <= 0.3
    assert pace.span == pace.begin == length
    assert 0.0 <= pace.error <= 1.0
    assert series[Z, 0] == body.deformation
    assert series[V, 0] == body.velocity
    mobility = mobility_of(coefficients, motion)
    for node in TABLES.nodes[STAGES.index(stages), : stages + 1]:
        t = node * length
        z, v = (horner(series[row], stages + 1, t) for row in (Z, V))
        p = pressure_after(body, coefficients, 0.0, t)
        assert horner(series[P], stages, t) == pytest.approx(p, abs=1e-14)
        pull = force(coefficients, z, v, p)
        assert horner(series[FORCE], stages, t) == pytest.approx(pull, abs=1e-12)
        if node > 0.0:
            assert horner_derivative(series[Z], stages, t) == pytest.approx(v, abs=1e-12)
            acceleration = horner_derivative(series[V], stages, t)
            expected = mobility * pull + acceleration_at_no_force(coefficients, motion)
            assert acceleration == pytest.approx(expected, abs=0.1 * tolerance * mobility / length)


def test_a_step_of_an_unsolvable_body_is_refused():
    body = Body(np.nan, 0.0, 0.0, 0.0, 0.0, STUCK, 0)
    series = np.zeros((ROWS, WIDTH))
    length, _ = collocate(
        body, coefficients_of(Groups(), Scene()), 0.0, 1.0, 5, 1e-6, AFRESH._replace(length=0.1), series
    )
    assert np.isnan(length)


def test_an_unstable_body_is_not_held_by_the_method():
    # From z = v = 1e-9 on the top of the potential z grows as exp(t): much fainter than the tolerance at first.
    groups = Groups(**BOUNCER | {"radial_coupling": 2.0}, foot_mass_fraction=0.5, deborah=1e6)
    rate = np.sqrt(2.0)
    # p = 1, so that 0.5 v' = 1 + z: z + 1 is a hyperbolic motion about z = -1, and starts beside its foot.
    initial = State(-1.0 + 1e-9, rate * 1e-9, 1.0)
    done = run(groups, [1], 12.0, scene=Scene(anchored=True), initial=initial, solver="radau", tolerance=1e-6)
    assert done.deformation[0] == pytest.approx(-1.0 + 1e-9 * np.exp(12.0 * rate), rel=1e-2)


def test_a_step_is_repeated_for_an_event_early_in_it_or_faint():
    coefficients = coefficients_of(Groups(), Scene())
    pace = Pace(2.0, 1.0, 1.0, 0.3, 1e-3)

    def repeated(moment, pace=pace, speed=1.0):
        body = Body(0.0, 0.0, 0.0, 0.0, speed, FORWARD, 1)
        return refine_event_step(body, coefficients, 1e-3, pace, moment)

    assert repeated(0.5) == Pace(pytest.approx(0.55), 1.0, 0.0, 0.3, 0.0)
    assert repeated(0.9) == AFRESH
    assert repeated(0.0) == AFRESH
    assert repeated(0.9, speed=0.1) == Pace(0.5, 1.0, 0.0, 0.3, 0.0)
    assert repeated(0.5, pace=pace._replace(error=0.0)) == AFRESH, "a Taylor series"


def first_step(length, stages=5, tolerance=1e-6, friction=0.5, start=0.3):
    """A step of a sliding body that is tried with the length, and what it leaves."""
    coefficients = coefficients_of(Groups(static_friction=friction, kinetic_friction=0.8 * friction), Scene())
    series, pace = np.zeros((ROWS, WIDTH)), AFRESH._replace(length=length)
    return collocate(
        Body(start, 0.1, 0.9, 0.0, 1.0, FORWARD, 1), coefficients, 0.0, 1e9, stages, tolerance, pace, series
    )


@pytest.mark.parametrize("stages", STAGES)
def test_the_next_step_is_as_long_as_the_error_of_this_one_allows(stages):
    tolerance = {5: 1e-6, 7: 1e-8, 9: 1e-11, 11: 1e-13}[stages]
    lengths = np.geomspace(0.01, 0.25, 30)
    steps = [(length, *first_step(length, stages, tolerance)) for length in lengths]
    at_once = [(taken, pace) for length, taken, pace in steps if taken == length and pace.error > 0.0]
    assert len(at_once) > 3
    for taken, pace in at_once:
        factor = min(0.9 * max(pace.error, 1e-12) ** (-1.0 / (stages + 1)), 10.0)
        assert pace.length == pytest.approx(taken * factor, rel=1e-12)
        assert (pace.span, pace.begin, pace.doubt) == (taken, taken, pace.error * tolerance)
    # After a step that had to be shortened the next one is no longer.
    again = [(taken, pace) for length, taken, pace in steps if taken < length]
    assert all(0.89 * taken < pace.length <= taken for taken, pace in again)


def test_a_step_that_errs_by_far_is_tried_again_with_a_tenth_and_one_without_solution_with_a_quarter():
    for length in (8.5, 12.0, 20.0, 60.0):
        assert first_step(length)[0] == first_step(0.1 * length)[0] != first_step(0.2 * length)[0]
    for length in (2.5, 10.0, 40.0):
        quarter, half = (first_step(share * length, 11, 1e-13)[0] for share in (0.25, 0.5))
        assert first_step(length, 11, 1e-13)[0] == quarter != half


def test_without_friction_a_step_is_no_surer_than_the_rounding_of_the_forces_terms():
    terms = 1.0 + 0.3 + 0.5 * 0.3**3 + 2.0 * 0.05 * 0.1  # pressure, springs and damping
    _, pace = first_step(1e-6, friction=0.0)
    assert (pace.error, pace.doubt) == (0.0, pytest.approx(1e-13 * terms, rel=1e-3))
    assert first_step(1e-6)[1].doubt == 0.0
    assert first_step(1e-6, friction=0.0, start=300.0)[1].doubt == 1e-6  # of 1e7 no digits are left beyond


def test_no_step_is_so_short_that_its_powers_leave_the_range_of_floats():
    """Its coefficients are divided by them: of a step shorter by four decades some are no numbers."""
    coefficients = coefficients_of(Groups(), Scene())
    body = Body(0.3, 0.1, 0.9, 0.0, 1.0, FORWARD, 1)
    pace = Pace(2.0, 1.0, 1.0, 0.3, 1e-3)
    assert refine_event_step(body, coefficients, 1e-3, pace, 0.99e-25) == AFRESH
    assert refine_event_step(body, coefficients, 1e-3, pace, 1.01e-25) == Pace(pytest.approx(1.111e-25), 1, 0, 0.3, 0)
    for length, finite in ((1e-25, True), (1e-29, False)):
        series = np.zeros((ROWS, WIDTH))
        with np.errstate(over="ignore", invalid="ignore"):
            taken, _ = collocate(
                body, coefficients, 0.0, 1.0, STAGES[-1], 1e-15, AFRESH._replace(length=length), series
            )
        assert taken == length
        assert np.isfinite(series[[Z, V, P, FORCE], : STAGES[-1] + 1]).all() == finite


def test_stages_grow_with_the_digits_asked_for():
    stages = [stages_for(10.0**-digits) for digits in range(2, 16)]
    assert stages == sorted(stages)
    assert set(stages) == set(STAGES)


# Ordinary scenes


def test_check_value_is_met_and_errors_fall_with_the_tolerance():
    for digits in range(3, 16):
        done = run(Groups(), WORD * 25, 1.0, tolerance=10.0**-digits, solver="radau")
        assert done.slips == 50
        assert done.foot[-1] == pytest.approx(FOOT, abs=10.0**-digits + 2e-13)


@pytest.mark.parametrize("scene", SCENES, ids=str)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_agrees_with_decimal_arithmetic_in_every_scene(scene, tolerance):
    done = run(Groups(), WORD, 1.0, scene=scene, samples_per_hold=3, tolerance=tolerance, solver="radau")
    verdict = decimal_judge(Groups(), WORD, 1.0, scene=scene, samples_per_hold=3)
    assert_agrees(done, verdict, atol=10.0 * tolerance)


def test_energies_are_those_of_the_judge():
    done = run(Groups(), WORD * 2, 1.0, tolerance=1e-13, solver="radau")
    verdict = judge(Groups(), WORD * 2, 1.0)
    for energy in ("work", "viscous_loss", "friction_loss"):
        assert getattr(done, energy) == pytest.approx(getattr(verdict, energy), abs=1e-10)


@pytest.mark.parametrize("seed", range(40))
def test_agrees_with_the_taylor_series_from_anywhere_in_the_ranges(seed):
    groups, valve, hold, options = random_crawler(np.random.default_rng(30_000 + seed), anchored=seed % 10 == 0)
    exact = run(groups, valve, hold, tolerance=1e-15, **options)
    for tolerance in (1e-6, 1e-10):
        done = run(groups, valve, hold, tolerance=tolerance, solver="radau", **options)
        for name in ("deformation", "velocity", "foot", "foot_velocity"):
            np.testing.assert_allclose(
                getattr(done, name), getattr(exact, name), rtol=0, atol=100.0 * tolerance, err_msg=name
            )
        if not is_free(groups, options["scene"]) and groups.static_friction > 1e-3:
            assert done.slips == exact.slips


@HUNT
@given(groups=crawlers, valve=schedules, hold=st.floats(0.05, 4.0), initial=starts, scene=st.sampled_from(SCENES[:2]))
def test_agrees_with_scipy_over_random_groups(groups, valve, hold, initial, scene):
    options = {"scene": scene, "initial": initial, "samples_per_hold": 2}
    done = run(groups, valve, hold, tolerance=1e-12, solver="radau", **options)
    verdict = judge(groups, valve, hold, **options)
    assume(verdict.clearance > UNDECIDED)
    try:
        assert_agrees(done, verdict, atol=1e-7, free=is_free(groups, scene))
    except AssertionError:
        # SciPy looks for events between its own steps and can miss a short slip: 50 digits decide who did.
        assert_agrees(done, decimal_judge(groups, valve, hold, **options), atol=1e-7, free=is_free(groups, scene))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-10])
@pytest.mark.parametrize("ratchet", [True, False])
def test_equal_frictions_neither_hang_nor_chatter(tolerance, ratchet):
    for friction in np.linspace(0.0, 0.9, 7):
        groups = Groups(static_friction=friction, kinetic_friction=friction)
        done = run(groups, WORD * 4, 1.0, scene=Scene(ratchet=ratchet), tolerance=tolerance, solver="radau")
        assert done.slips <= 32, "a body of this frequency has no time for more"


# Stiff scenes


@pytest.mark.parametrize("name", STIFF)
@pytest.mark.parametrize("ratchet", [True, False])
def test_stiff_scenes_are_those_of_the_taylor_series(name, ratchet):
    groups, scene = Groups(**STIFF[name]), Scene(ratchet=ratchet)
    exact = simulate(groups, WORD, 1.0, scene=scene, tolerance=1e-13, solver="taylor", samples_per_hold=3)
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        done = run(groups, WORD, 1.0, scene=scene, tolerance=tolerance, solver="radau", samples_per_hold=3)
        assert done.events["mode"].tolist() == exact.events["mode"].tolist()
        for name in ("deformation", "velocity", "foot", "foot_velocity"):
            atol = 10.0 * tolerance
            np.testing.assert_allclose(getattr(done, name), getattr(exact, name), rtol=0, atol=atol, err_msg=name)


@pytest.mark.parametrize("ratchet", [True, False])
def test_all_four_stiff_at_once(ratchet):
    groups, scene = Groups(**ALL_FOUR), Scene(ratchet=ratchet)
    exact = simulate(groups, [1, 0], 1.0, scene=scene, tolerance=1e-6, solver="taylor", max_steps=10**7)
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        done = run(groups, [1, 0], 1.0, scene=scene, tolerance=tolerance, solver="radau")
        assert done.events["mode"].tolist() == exact.events["mode"].tolist()
        assert done.slips == (1 if ratchet else 2)
        np.testing.assert_allclose(done.events["time"], exact.events["time"], rtol=0, atol=10.0 * tolerance + 1e-9)
        np.testing.assert_allclose(done.foot, exact.foot, rtol=0, atol=1e-12)


def test_no_slip_of_a_stiff_gait_is_lost():
    # Every valve opening is a slip, over in a hundredth of the hold; exponential integrators lose all of them.
    groups = Groups(damping_ratio=100.0, deborah=1e-3)
    for tolerance in (1e-2, 1e-4, 1e-8):
        done = run(groups, WORD * 10, 1.0, tolerance=tolerance, solver="radau")
        assert done.slips == 10


@pytest.mark.parametrize("deformation", [0.3, 1.0])
def test_a_slip_inside_a_layer_against_decimal_arithmetic(deformation):
    # All four stiff: the layers of velocity and pressure after a hold begins, from a state far from both.
    groups = Groups(**ALL_FOUR)
    initial = State(deformation=deformation * 0.01, velocity=-1e-5, pressure=0.2)
    for hold in (1e-10, 1e-8):
        done = run(groups, [0, 1], hold, initial=initial, tolerance=1e-12, solver="radau", samples_per_hold=2)
        verdict = decimal_judge(groups, [0, 1], hold, initial=initial, samples_per_hold=2)
        assert_agrees(done, verdict, atol=1e-11)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
def test_a_motion_far_fainter_than_the_tolerance_does_not_chatter(tolerance):
    # Without friction the foot follows every turn of a body that moves by 1e-10.
    groups = Groups(0.06, 2140.0, 5700.0, 0.0, 0.05, 0.0, 0.0)
    valve = [1, 1, 0, 1, 1, 0, 1, 0]
    done = run(groups, valve, 0.0131, tolerance=tolerance, solver="radau")
    assert run(groups, valve, 0.0131, tolerance=1e-15, solver="taylor").slips == 3
    assert done.slips <= 3
    np.testing.assert_allclose(done.deformation, done.deformation.clip(0.0, 1e-9))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_a_damped_slip_that_starts_softly_does_not_chatter(tolerance):
    groups = Groups(0.0, 4.144, 8.758, 0.0176, 0.0369, 0.0, 0.0)
    valve = [0, 1, 0, 0, 0, 1, 0, 1, 0]
    assert run(groups, valve, 1.078, tolerance=tolerance, solver="radau").slips == 3


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_a_quiet_stiff_body_takes_long_steps(tolerance):
    # Relaxing at a rate of 1 / 2 Pi2 for ten time constants: an explicit method would need 4e8 steps.
    groups = Groups(**BOUNCER | {"damping_ratio": 1e4}, static_friction=10.0)
    done = run(groups, [0], 2e5, initial=State(deformation=1.0), tolerance=tolerance, solver="radau")
    rate = 1e4 - np.sqrt(1e8 - 0.7)
    expected = np.exp(-rate / 0.7 * 2e5)
    assert done.deformation[0] == pytest.approx(expected, abs=10.0 * tolerance)


def test_drag_far_above_the_internal_force_leaves_the_finest_tolerance_within_reach():
    groups = Groups(duffing=0.66, foot_mass_fraction=0.22, static_friction=620.0, kinetic_friction=620.0)
    arguments = {"scene": Scene(slope=0.03), "initial": State(foot_velocity=0.14), "tolerance": 1e-15}
    stiff = simulate(groups, [1, 0, 0], 0.2, solver="radau", **arguments)
    other = simulate(groups, [1, 0, 0], 0.2, solver="taylor", **arguments)
    assert stiff.slips == other.slips
    for name in ("foot", "deformation", "velocity"):
        np.testing.assert_allclose(getattr(stiff, name), getattr(other, name), rtol=0, atol=1e-11)


def test_the_pressure_does_not_gather_rounding_over_many_steps():
    # Found by search: hundreds of steps, each of a part of the fluid's time constant.
    groups = Groups(0.0, 1.0, 1e5, 2.0, 0.1, 0.0, 0.0)
    done = simulate(groups, [1], 1e4, scene=Scene(ratchet=False), solver="radau", samples_per_hold=2)
    np.testing.assert_allclose(done.pressure, -np.expm1(-np.array([0.05, 0.1])), rtol=1e-14)


@pytest.mark.parametrize(("lag", "static"), [(5.0, 1e-5), (50.0, 1e-5), (5.0, 1e-4)])
def test_an_oscillation_fainter_than_the_tolerance_is_not_damped_away(lag, static):
    # Its pull swings by 1e-4 or less and breaks the grip at every turn.
    groups = Groups(
        damping_ratio=0.0,
        deborah=lag,
        foot_mass_fraction=1.0 - 1e-6,
        static_friction=static,
        kinetic_friction=0.5 * static,
    )
    expected = simulate(groups, [1], 10.0, solver="taylor").slips
    assert expected > 500
    assert simulate(groups, [1], 10.0, solver="radau", tolerance=1e-3).slips == pytest.approx(expected, abs=2)


@pytest.mark.parametrize("special", [{}, {"duffing": 0.0, "radial_coupling": 0.0}, {"damping_ratio": 60.0}])
def test_a_share_of_nothing_is_not_asked_for(special):
    """At rest without friction the foot is at its threshold, and no error is small beside that, nor is rounding."""
    groups, scene = Groups(static_friction=0.0, kinetic_friction=0.0, **special), Scene()
    for tolerance in (1e-5, 1e-9, 1e-15):
        rest = run(groups, [0, 0], 30.0, tolerance=tolerance, solver="radau")
        assert not rest.deformation.any()
        assert not rest.foot.any()
        exact = simulate(groups, [0, 0, 1, 0], 3.0, scene=scene, tolerance=1e-14, solver="taylor")
        done = run(groups, [0, 0, 1, 0], 3.0, tolerance=tolerance, solver="radau")
        np.testing.assert_allclose(done.deformation, exact.deformation, rtol=0, atol=10.0 * tolerance + 1e-13)
