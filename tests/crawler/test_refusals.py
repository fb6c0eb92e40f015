"""What `simulate` refuses, and how it says so."""

import re
import warnings

import numpy as np
import pytest

from stickslip.crawler import batch_simulation, Groups, Scene, simulate, SlipWarning, SolverError, State
from stickslip.crawler.loop import advance
from stickslip.crawler.model.state import Body, coefficients_of, NOTHING_YET, STUCK
from stickslip.crawler.refusals import solver_error
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import DIVERGED, FINISHED, Hold, LOG_FULL, OUT_OF_STEPS, Recording
from stickslip.crawler.steps.workspace import ROWS, WIDTH

REFUSED = [
    ("valve", {"valve": [0, 2]}, ValueError, r"valve must hold only numbers in \[0, 1\]"),
    ("valve", {"valve": [1.0 + 1e-15]}, ValueError, r"valve must hold only numbers in \[0, 1\]"),
    ("valve", {"valve": [np.inf]}, ValueError, r"valve must hold only numbers in \[0, 1\]"),
    ("valve", {"valve": [np.nan]}, ValueError, r"valve must hold only numbers in \[0, 1\]"),
    ("valve", {"valve": [-1]}, ValueError, r"valve must hold only numbers in \[0, 1\]"),
    ("valve", {"valve": ["1"]}, ValueError, r"valve must hold only numbers in \[0, 1\]"),
    ("valve", {"valve": [None]}, ValueError, r"valve must hold only numbers in \[0, 1\]"),
    ("valve", {"valve": [1j]}, ValueError, r"valve must hold only numbers in \[0, 1\]"),
    ("valve", {"valve": []}, ValueError, r"\(holds,\) or \(batch, holds\).*\(0,\)"),
    ("valve", {"valve": [[]]}, ValueError, r"\(holds,\) or \(batch, holds\).*\(1, 0\)"),
    ("valve", {"valve": 1}, ValueError, r"\(holds,\) or \(batch, holds\)"),
    ("valve", {"valve": np.zeros((2, 2, 2))}, ValueError, r"\(holds,\) or \(batch, holds\).*\(2, 2, 2\)"),
    ("valve", {"valve": [[0, 1], [1]]}, ValueError, r"valve must have shape .*, got rows of different length$"),
    *[("hold", {"hold": bad}, ValueError, r"\(0, inf\), got ") for bad in (0, 0.0, -1.0, np.inf, np.nan)],
    ("hold", {"hold": "long"}, TypeError, r"\(0, inf\), or a text of one and its unit .*, got 'long'"),
    ("hold", {"hold": None}, TypeError, r"\(0, inf\), got None"),
    *[
        ("tolerance", {"tolerance": bad}, ValueError, r"\[1e-15, 1e-2\], got ")
        for bad in (0.0, -1e-9, 9e-16, 0.011, np.nan, np.inf)
    ],
    ("tolerance", {"tolerance": "fine"}, TypeError, r"\[1e-15, 1e-2\], got 'fine'"),
    ("solver", {"solver": "rk4"}, ValueError, r"'auto', 'closed_form', 'taylor', 'radau'.*got 'rk4'"),
    *[
        (
            "solver",
            {"solver": solver, "scene": {"segments": 2, "tube_mass": 0.5}},
            ValueError,
            rf"^solver must be one of \['auto', 'taylor'\] for a chain of heavy segments, got '{solver}'$",
        )
        for solver in ("radau", "closed_form")
    ],
    ("solver", {"solver": ["taylor"]}, ValueError, r"'auto', 'closed_form', 'taylor', 'radau'.*got \['taylor'\]$"),
    ("hold", {"hold": [10**400]}, ValueError, r"^hold must be finite, got "),
    ("solver", {"solver": None}, ValueError, r"'auto', 'closed_form', 'taylor', 'radau'.*got None"),
    *[("samples_per_hold", {"samples_per_hold": bad}, ValueError, r">= 1, got ") for bad in (0, -3)],
    *[("samples_per_hold", {"samples_per_hold": bad}, TypeError, r">= 1, got ") for bad in (True, 1.0, "2", None)],
    ("groups", {"groups": []}, TypeError, r"Groups"),
    ("groups", {"groups": [Groups(), 3]}, TypeError, r"Groups"),
    ("groups", {"groups": [Groups()] * 3, "valve": [[0], [1]]}, ValueError, r"valve.*3 and 2"),
    ("scene", {"scene": "anchored"}, TypeError, r"got 'anchored'"),
    ("scene", {"scene": {"slope": float("nan")}}, ValueError, r"slope.*\(-inf, inf\), got nan"),
    ("scene", {"scene": {"tilt": 1.0}}, ValueError, r"'tilt'.*anchored"),
]


@pytest.mark.parametrize(("name", "change", "error", "says"), REFUSED)
def test_refuses_in_one_line_that_names_the_argument(name, change, error, says):
    arguments = {"groups": Groups(), "valve": [1, 0], "hold": 1.0} | change
    with pytest.raises(error, match=says) as caught:
        simulate(arguments.pop("groups"), arguments.pop("valve"), arguments.pop("hold"), **arguments)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("field", State._fields)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_refuses_an_initial_state_that_is_not_finite(field, bad):
    with pytest.raises(ValueError, match=rf"initial {field} must be in"):
        simulate(Groups(), [1], 1.0, initial=State(**{field: bad}))


@pytest.mark.parametrize("bad", [-1e-9, 1.0 + 1e-9])
def test_refuses_an_initial_pressure_out_of_range(bad):
    with pytest.raises(ValueError, match=r"initial pressure must be in \[0, 1\]"):
        simulate(Groups(), [1], 1.0, initial=State(pressure=bad))


@pytest.mark.parametrize(
    ("scene", "speed"), [(Scene(), -0.1), (Scene(anchored=True), 0.1), (Scene(anchored=True, ratchet=False), -0.1)]
)
def test_refuses_a_foot_that_moves_where_it_cannot(scene, speed):
    with pytest.raises(ValueError, match="initial foot_velocity must be in"):
        simulate(Groups(), [1], 1.0, scene=scene, initial=State(foot_velocity=speed))


@pytest.mark.parametrize("valve", [[True, False], [1.0, 0.0], np.array([1, 0], np.uint8), (1, 0)])
def test_takes_any_array_of_zeros_and_ones(valve):
    np.testing.assert_array_equal(simulate(Groups(), valve, 1.0).valve, [1, 0])


@pytest.mark.parametrize("tolerance", [1e-15, 1e-2])
def test_takes_the_ends_of_the_tolerance_range(tolerance):
    assert np.isfinite(simulate(Groups(), [1, 0], 1.0, tolerance=tolerance).foot).all()


def test_a_batch_that_fails_raises_rather_than_return_garbage():
    with pytest.raises(SolverError, match=r"radial_coupling=2\.0"):
        simulate([Groups(), Groups(duffing=0.0, radial_coupling=2.0)], [1], 1e3)


def test_the_row_of_a_batch_that_fails_is_named():
    batch = [{}, {"damping_ratio": 1e4}]
    arguments = {"solver": "taylor", "max_steps": 3000}
    alone = refusal(batch[1], [1, 0], 1000.0, **arguments)
    assert alone.startswith("the step budget of 3000 was spent")
    assert refusal(batch, [1, 0], 1000.0, **arguments) == f"crawler 1: {alone}"
    # So it is in a batch of schedules, and of one row.
    assert refusal(batch[1], [[0, 0], [1, 0]], 0.9, **arguments | {"max_steps": 300}).startswith("crawler 1: ")
    assert refusal(batch[1:], [1, 0], 1000.0, **arguments) == f"crawler 0: {alone}"


# What the kernel reports


def kernel(groups, hold, *, events=8, body=None, **options):
    return advance(
        body or Body(0.0, 0.0, 0.0, 0.0, 0.0, STUCK, 0),
        NOTHING_YET,
        coefficients_of(groups, Scene()),
        Hold(1.0, hold, 0.0, hold, 0.0),
        SOLVERS["taylor"].options(1e-9, **options),
        Recording(np.empty((5, 1)), np.empty((events, 2))),
        np.empty((ROWS, WIDTH)),
    )


def test_a_spent_step_budget_is_reported_with_time_and_remedy():
    outcome = kernel(Groups(), 100.0, max_steps=5)
    assert outcome.status == OUT_OF_STEPS
    assert 0.0 < outcome.elapsed < 100.0
    error = solver_error(
        outcome.status, outcome.elapsed, outcome.body.deformation, 5, Groups(), Scene(), 1e-9, "taylor"
    )
    for part in (f"{outcome.elapsed:.6g}", "step budget of 5", "Groups(", "1e-09", "max_steps", "looser tolerance"):
        assert part in str(error)


def test_a_budget_just_large_enough_is_enough():
    steps = next(n for n in range(1, 10_000) if kernel(Groups(), 10.0, max_steps=n).status == FINISHED)
    assert steps > 1
    assert kernel(Groups(), 10.0, max_steps=steps - 1).status == OUT_OF_STEPS


def test_a_log_that_is_full_is_reported_and_none_needed_without_log():
    pulled = Body(1.0, 0.0, 0.0, 0.0, 0.0, STUCK, 0)
    assert kernel(Groups(), 10.0, body=pulled, log=True, events=0).status == LOG_FULL
    assert kernel(Groups(), 10.0, body=pulled, log=False, events=0).status == FINISHED


def test_keeping_the_books_does_not_change_the_motion():
    plain, kept = kernel(Groups(), 7.0), kernel(Groups(), 7.0, energy=True, log=True, events=64)
    assert plain.body == kept.body
    assert plain.ledger == NOTHING_YET
    assert kept.ledger.work > 0.0


def test_divergence_is_a_status_of_its_own():
    groups = Groups(duffing=0.0, radial_coupling=2.0)
    assert kernel(groups, 1e4).status == DIVERGED


def test_a_simulation_with_more_events_than_any_first_guess():
    # A light foot on hardly any friction slips and stops a thousand times in one hold.
    groups = Groups(
        duffing=0.0,
        damping_ratio=0.0,
        radial_coupling=0.0,
        foot_mass_fraction=0.01,
        static_friction=0.01,
        kinetic_friction=0.0001,
    )
    done = simulate(groups, [1], 400.0, scene=Scene(ratchet=False), initial=State(deformation=5.0))
    assert len(done.events) > 200
    assert done.slips == np.count_nonzero(done.events["mode"])
    pieces = simulate(groups, [1] * 400, 1.0, scene=Scene(ratchet=False), initial=State(deformation=5.0))
    np.testing.assert_array_equal(pieces.events["mode"], done.events["mode"])


def refusal(groups, valve, hold, **options):
    with pytest.raises(SolverError) as caught:
        simulate(groups, valve, hold, **options)
    return str(caught.value)


@pytest.mark.parametrize("solver", ["taylor", "radau"])
def test_an_undamped_spring_that_swings_on_is_not_called_stiff(solver):
    groups = Groups(damping_ratio=0.0, foot_mass_fraction=1.0 - 1e-6)
    says = refusal(groups, [1], 1000.0, max_steps=20_000, solver=solver)
    assert re.search(
        r"the spring over a .*real swings so far.* take a larger max_steps, a looser tolerance, or a shorter", says
    )
    assert "solver='radau'" not in says


def test_damping_that_is_too_stiff_for_a_series_is_left_to_radau():
    says = refusal(Groups(damping_ratio=1e4), [1], 100.0, max_steps=20_000, solver="taylor")
    assert re.search(r"the damping over a .* too stiff for this solver; take solver='radau', a larger max_steps", says)
    assert "too stiff" not in refusal(Groups(damping_ratio=1e4), [1], 100.0, max_steps=5, solver="radau")


@pytest.mark.parametrize("rows", [1, 2])
def test_a_budget_beyond_all_whole_numbers_of_the_machine_is_no_bound(rows):
    found = simulate([{}] * rows, [1, 0], 1.0, solver="taylor", max_steps=10**30)
    np.testing.assert_array_equal(found.foot[0], simulate({}, [1, 0], 1.0, solver="taylor").foot)


def test_a_chain_is_not_told_to_take_a_solver_that_refuses_it():
    chain = Scene(segments=7, tube_mass=0.3)
    says = refusal(Groups(damping_ratio=100.0), [1], 10.0, max_steps=20, scene=chain, tolerance=1e-12)
    assert "too stiff for this solver; take fewer segments than 7, more tube_mass than 0.3, a larger max_steps" in says
    assert "radau" not in says


CREEPING = Groups(damping_ratio=1e4, static_friction=2e-5, kinetic_friction=1e-5)
# Those of the stiff judge, and of any solver at a tolerance below the friction.
SLIPS_OF_CREEPING = 1


@pytest.mark.parametrize(
    ("solver", "tolerance", "told"),
    [("taylor", 1e-3, True), ("taylor", 1e-6, False), ("radau", 1e-3, False)],
)
def test_slips_that_a_tolerance_does_not_resolve_are_told(solver, tolerance, told):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        done = simulate([Groups(), CREEPING], [1, 1, 1, 1, 0, 0, 0, 0], 1.0, solver=solver, tolerance=tolerance)
    assert (done.slips[1] == SLIPS_OF_CREEPING) != told
    assert [each.category for each in caught] == [SlipWarning] * told
    for each in caught:
        says = (
            rf"crawler 1: the foot broke loose {done.slips[1]} times, for \S+ on .* than the tolerance 0.001: .*'radau'"
        )
        assert re.match(says, str(each.message))
        assert each.filename == __file__


@pytest.mark.parametrize("samples", [10**17, 10**30])
@pytest.mark.parametrize(
    ("groups", "rows"), [({}, "3 holds"), ([{}, {}], "2 schedules of 3 holds")], ids=["one", "batch"]
)
def test_samples_that_no_memory_holds_are_refused(groups, rows, samples):
    says = f"samples_per_hold must leave the samples of {rows} room in memory, got {samples}"
    with pytest.raises(ValueError, match=says):
        simulate(groups, [1, 0, 1], 1.0, samples_per_hold=samples)


def test_slips_that_accumulate_are_told_by_their_number():
    error = solver_error(OUT_OF_STEPS, 1.0, 0.5, 100_000, Groups(), Scene(), 1e-6, "radau", 40_000)
    assert re.search(r"40000 slips have accumulated, \d+.* in the time of a swing", str(error))
    assert "another static_friction" in str(error)
    # Two slips a swing, of thousands, are a motion.
    swings = Groups(damping_ratio=0.0, foot_mass_fraction=1.0 - 1e-6)
    assert "accumulated" not in str(
        solver_error(OUT_OF_STEPS, 1e3, 0.5, 10**6, swings, Scene(), 1e-6, "taylor", 300_000)
    )


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("duffing", 1e300),
        ("damping_ratio", 1e300),
        ("radial_coupling", 1e300),
        ("radial_coupling", 1e30),
        ("deborah", 1e-300),
        ("deborah", 1e-30),
        ("foot_mass_fraction", 1e-300),
        ("duffing", 1e100),
        ("foot_mass_fraction", 1e-30),
    ],
)
def test_an_absurd_group_is_named(name, value):
    says = refusal(Groups(**{name: value}), [1, 1, 0], 1.0, max_steps=20_000)
    assert f"{name} = {value!r} " in says
    assert "began too far" not in says
    assert "radau'," not in says


def test_an_absurd_drag_and_an_absurd_slope_are_named():
    rough = Groups(static_friction=1e300, kinetic_friction=1e299)
    assert "kinetic_friction = 1e+299" in refusal(rough, [1], 1.0, initial=State(foot_velocity=1.0))
    assert "slope = 1e+300" in refusal(Groups(), [1], 1.0, scene=Scene(slope=1e300))


def test_a_start_beyond_all_bounds_is_named():
    assert "began too far or too fast" in refusal(Groups(), [1], 1.0, initial=State(1e11))


def test_a_grip_beyond_measure_is_not_blamed_for_what_it_does_not_do():
    with pytest.raises(SolverError, match=r"too stiff for this solver; take solver='radau'"):
        simulate({"static_friction": 1e20, "damping_ratio": 1e4}, [1, 0], 1000.0, solver="taylor", max_steps=400)


# What is said of a spent budget, word by word


TOLD = re.compile(
    r"the step budget of (?P<budget>\d+) was spent at time (?P<time>[-+.\de]+) \(z = (?P<z>[-+.\de]+)\) by solver "
    r"'(?P<solver>\w+)' at tolerance (?P<tolerance>[-+.\de]+): (?P<cause>.*); take (?P<remedies>.*); "
    r"with (?P<groups>.*)"
)
STIFF = ", which is too stiff for this solver"
STIFF_REMEDIES = "solver='radau', a larger max_steps, a looser tolerance, or less of that"
SWING_REMEDIES = "a larger max_steps, a looser tolerance, or a shorter schedule"
DAMPED, UNDAMPED = {"damping_ratio": 1e4}, {"damping_ratio": 0.0, "foot_mass_fraction": 1.0 - 1e-6}
# Groups, schedule, hold, options, what is fastest and over which foot, the end of the cause, and the remedies.
SPENT = {
    "damping": (DAMPED, [1], 100.0, {"max_steps": 2000, "solver": "taylor"}, "damping sliding", STIFF, STIFF_REMEDIES),
    "damping, L-stable": (
        DAMPED,
        [1],
        100.0,
        {"max_steps": 5, "solver": "radau", "tolerance": 1e-6},
        "damping sliding",
        "",
        "a larger max_steps, a looser tolerance, or less of that",
    ),
    "damping, anchored": (
        DAMPED,
        [1, 0],
        100.0,
        {"max_steps": 2000, "solver": "taylor", "scene": {"anchored": True}},
        "damping resting",
        STIFF,
        STIFF_REMEDIES,
    ),
    "swings": (
        UNDAMPED,
        [1, 0],
        9.0,
        {"max_steps": 20_000, "solver": "taylor"},
        "spring sliding",
        "swings",
        SWING_REMEDIES,
    ),
    "swings, L-stable": (
        UNDAMPED,
        [1],
        1000.0,
        {"max_steps": 2000, "solver": "radau"},
        "spring sliding",
        "swings",
        SWING_REMEDIES,
    ),
    "swings, anchored": (
        {"duffing": 1e5},
        [1, 0] * 4,
        20.0,
        {"max_steps": 500, "scene": {"anchored": True}},
        "spring resting",
        "swings",
        SWING_REMEDIES,
    ),
    "closed form": (
        "linear",
        [1, 0] * 4,
        2.0,
        {"max_steps": 50},
        "spring sliding",
        "swings",
        "a larger max_steps, or a shorter schedule",
    ),
    "lag": ({"deborah": 1e-5}, [1, 0] * 99, 2.0, {"max_steps": 500}, "lag", STIFF, STIFF_REMEDIES),
    "too few": (
        {"damping_ratio": 0.0},
        [1],
        3.0,
        {"max_steps": 2},
        "spring sliding",
        "",
        "a larger max_steps, a looser tolerance, or less of that",
    ),
    "chain": (
        {"damping_ratio": 0.0},
        [1, 0] * 4,
        20.0,
        {"max_steps": 50, "scene": {"segments": 3, "tube_mass": 0.25}},
        "chain sliding",
        "swings",
        f"fewer segments than 3, more tube_mass than 0.25, {SWING_REMEDIES}",
    ),
}


def fastest_mode(masses):
    """Square of the fastest rate of masses with springs of one between them."""
    ends = np.diff(np.eye(len(masses)), axis=0)
    return np.linalg.eigvals(ends.T @ ends / np.array(masses)[:, None]).real.max()


def fastest(kind, groups, z):
    """Name and rate of the body's fastest motion about a stretch, by the equations of motion."""
    name, _, foot = kind.partition(" ")
    r = groups.foot_mass_fraction
    mass = 1.0 - r if foot == "resting" else r * (1.0 - r)
    # A chain of three springs, each thrice as stiff, whose mass of a quarter their ends bear.
    masses = [r + 1 / 24, 1 / 12, 1 / 12, 1.0 - r + 1 / 24]
    return {
        "lag": ("the lag of the fluid (deborah)", 1.0 / groups.deborah),
        "damping": (
            f"the damping over a {foot} foot (damping_ratio, foot_mass_fraction)",
            2 * groups.damping_ratio / mass,
        ),
        "spring": (
            f"the spring over a {foot} foot (duffing, foot_mass_fraction)",
            np.sqrt((1.0 + 3.0 * groups.duffing * z**2) / mass),
        ),
        "chain": (
            f"the spring of the segments over a {foot} foot (duffing, segments, tube_mass)",
            np.sqrt(3.0 * (1.0 + 3.0 * groups.duffing * z**2) * fastest_mode(masses)),
        ),
    }[name]


@pytest.mark.parametrize("name", SPENT)
def test_a_spent_budget_word_by_word(name):
    choice, valve, hold, options, kind, cause, remedies = SPENT[name]
    groups = Groups.of(choice)
    told = TOLD.fullmatch(refusal(choice, valve, hold, **options))
    assert int(told["budget"]) == options["max_steps"]
    assert float(told["tolerance"]) == options.get("tolerance", 1e-9)
    assert told["solver"] == options.get("solver", "closed_form" if choice == "linear" else "taylor")
    assert told["remedies"] == remedies
    assert told["groups"] == str(groups)
    time, z = float(told["time"]), float(told["z"])
    assert 0.0 < time < hold * len(valve)
    # Where the body was then, by a run that may take as long as it needs.
    holds, rest = divmod(time, hold)
    arguments = {key: value for key, value in options.items() if key in ("scene", "tolerance")}
    state = None
    if holds:
        state = simulate(choice, valve[: int(holds)], hold, solver="auto", **arguments).final_state
    if rest:
        there = simulate(choice, [valve[int(holds)]], rest, solver="auto", initial=state, **arguments)
        state = there.final_state
        assert there.deformation[-1] == pytest.approx(z, abs=2e-3)
    called, rate = fastest(kind, groups, z)
    said = re.fullmatch(r"(.*) acts at a rate of ([-+.\de]+) per unit of time(.*)", told["cause"])
    assert said[1] == called
    assert float(said[2]) == pytest.approx(rate, rel=1e-2)
    if cause == "swings":
        swings = re.fullmatch(r": ([-+.\de]+) real swings so far, which no solver may skip", said[3])
        assert float(swings[1]) == pytest.approx(rate * time / (2.0 * np.pi), rel=1e-2)
    else:
        assert said[3] == cause


@pytest.mark.parametrize(("factor", "blamed"), [(0.5, False), (0.97, False), (1.03, True), (2.0, True)])
def test_slips_are_many_where_they_are_ten_a_swing(factor, blamed):
    span = 30.0
    _, rate = fastest("spring sliding", Groups(damping_ratio=0.0), 0.5)
    swings = rate * span / (2.0 * np.pi)
    error = solver_error(
        OUT_OF_STEPS,
        time=100.0 + span,
        deformation=0.5,
        steps=10**6,
        groups=Groups(damping_ratio=0.0),
        scene=Scene(),
        tolerance=1e-6,
        solver="taylor",
        slips=int(factor * 10.0 * (1.0 + swings)),
        began=100.0,
    )
    assert ("slips have accumulated" in str(error)) == blamed
    if blamed:
        assert f"{int(factor * 10.0 * (1.0 + swings)) / (1.0 + swings):.3g} in the time of a swing" in str(error)


@pytest.mark.parametrize("name", ["deborah", "foot_mass_fraction", "damping_ratio", "duffing"])
@pytest.mark.parametrize(("decades", "absurd"), [(14.5, False), (15.5, True)])
def test_a_group_is_absurd_fifteen_decades_from_one(name, decades, absurd):
    value = 10.0 ** (-decades if name in ("deborah", "foot_mass_fraction") else decades)
    groups = Groups(**{name: value})
    error = solver_error(OUT_OF_STEPS, 1.0, 0.5, 100, groups, Scene(), 1e-6, "taylor")
    assert (f"{name} = {value!r} makes it faster than any solver follows" in str(error)) == absurd
    assert str(error).endswith(f"with {groups}")
    diverged = solver_error(DIVERGED, 1.0, 0.5, 100, groups, Scene(), 1e-6, "taylor")
    assert (f"{name} = {value!r} leaves floating-point numbers no digits for the rest" in str(diverged)) == absurd


def test_a_divergence_word_by_word():
    says = refusal({"duffing": 0.0, "radial_coupling": 2.0}, [1], 1e3)
    told = re.fullmatch(
        r"the motion diverged at time ([.\d]+) \(z = ([.\de+]+)\): a body with radial_coupling > 1 needs duffing > 0, "
        r"with (Groups\(.*\))",
        says,
    )
    # Resting, it grows as e^(a t) with (1 - r) a^2 + 2 Pi2 a = 1: in some 12 ln 10 / a units of time to 1e12.
    assert 1e9 < float(told[2]) < 1e12
    assert 20.0 < float(told[1]) < 35.0
    assert told[3] == str(Groups(duffing=0.0, radial_coupling=2.0))
    fast = refusal({"static_friction": 0.0, "kinetic_friction": 0.0}, [1], 1.0, initial=State(0.0, 1e13))
    assert fast == (
        "the motion diverged at time 0 (z = 0): it began too far or too fast, and left the 1e+12 natural units within "
        f"which a body is followed, with {Groups(static_friction=0.0, kinetic_friction=0.0)}"
    )


def test_a_spring_that_bounds_the_body_is_not_asked_for():
    bounded = Groups(duffing=1e-3, radial_coupling=2.0)
    assert "began too far or too fast" in refusal(bounded, [1], 1.0, initial=State(velocity=1e13))


@pytest.mark.parametrize("solver", ["closed_form", "taylor", "radau"])
def test_a_body_is_followed_up_to_1e12_units(solver):
    """Anchored, linear and undamped it swings with z^2 + (1 - r) v^2 constant."""
    groups = {"duffing": 0.0, "radial_coupling": 0.0, "damping_ratio": 0.0, "foot_mass_fraction": 0.5}
    arguments = {"scene": {"anchored": True}, "solver": solver, "tolerance": 1e-3}
    far = simulate(groups, [0], 0.25, initial=State(3e11), **arguments)
    assert far.deformation[-1] == pytest.approx(3e11 * np.cos(0.25 * np.sqrt(2.0)), rel=1e-9)
    with pytest.raises(SolverError, match=r"^the motion diverged at time 0 "):
        simulate(groups, [0], 0.25, initial=State(3e12), **arguments)


def test_slips_of_the_run_are_told(monkeypatch):
    honest = batch_simulation.run_crawler

    def spent(*given):
        outcome, *more = honest(*given)
        return outcome._replace(status=OUT_OF_STEPS, body=outcome.body._replace(slips=40_000)), *more

    monkeypatch.setattr(batch_simulation, "run_crawler", spent)
    assert re.search(r": 40000 slips have accumulated, ", refusal({}, [1, 0], 1.0))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-9])
@pytest.mark.parametrize(("share", "alive"), [(0.9, True), (1.1, False)])
def test_a_swing_is_alive_until_it_has_decayed_to_the_tolerance(tolerance, share, alive):
    # The anchored body decays as e^(-Pi2 t / (1 - r)).
    span = share * -np.log(tolerance) * 0.7 / 0.05
    error = solver_error(OUT_OF_STEPS, span, 0.5, 10**6, Groups(deborah=9.0), Scene(anchored=True), tolerance, "taylor")
    assert ("real swings so far, which no solver may skip" in str(error)) == alive
    assert ("too stiff for this solver" in str(error)) == (not alive)
