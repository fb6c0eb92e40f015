"""What "auto" chooses, judged by steps counted and by what `benchmarks/solver_choice.py` found a step to take."""

import json
import math
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from stickslip.crawler import cost, Groups, Scene, simulate
from stickslip.crawler.cost import predicted_cost, predicted_steps
from stickslip.crawler.model.groups import PRESETS
from stickslip.crawler.model.state import coefficients_of, FORWARD, STUCK
from stickslip.crawler.solvers import AUTO, choose, SOLVERS, solvers_for
from stickslip.crawler.steps.options import STEPS_A_HOLD
from stickslip.crawler.steps.radau import stages_for
from stickslip.crawler.steps.taylor import order_for

MEASURED = Path(__file__).parents[2] / "benchmarks" / "results" / "solver_choice.json"
CRAWLERS = 150
MOST_STEPS = 20_000
WORD = np.array([1, 1, 1, 1, 0, 0, 0, 0] * 2, np.int8)
STIFF = {"duffing": 1e6, "damping_ratio": 1e4, "deborah": 1e-6, "foot_mass_fraction": 1e-6}
FAST = {"damping_ratio": 0.0, "foot_mass_fraction": 1.0 - 1e-4}


@pytest.fixture(scope="module")
def benchmark():
    return import_module("solver_choice")


@pytest.fixture(scope="module")
def step_cost():
    table = json.loads(MEASURED.read_text(encoding="utf-8"))["microseconds of a step by order"]
    return lambda name, tolerance: table[name][str(SOLVERS[name].order_for(tolerance))]


def counted(benchmark, drawn):
    """Steps a unit of time by each solver that can take the crawler; of a run broken off, until then."""
    runs = {name: benchmark.run(drawn, name, MOST_STEPS) for name in solvers_for(drawn.groups, drawn.scene)}
    return {name: done.steps / done.reached for name, done in runs.items()}


@pytest.fixture(scope="module")
def counts(benchmark):
    # Another seed than the one by which the constants were judged.
    return [(drawn, counted(benchmark, drawn)) for drawn in benchmark.random_crawlers(CRAWLERS, seed=2024)]


def test_auto_costs_at_most_half_more_in_the_median_and_thrice_in_the_worst_tenth(counts, step_cost):
    ratios = []
    for drawn, steps in counts:
        cost = {name: count * step_cost(name, drawn.tolerance) for name, count in steps.items()}
        ratios.append(cost[choose(AUTO, *drawn[:4]).name] / min(cost.values()))
    assert np.median(ratios) <= 1.5
    assert np.percentile(ratios, 90) <= 3.0


def test_no_solver_alone_would_do(counts, step_cost):
    """The same bound is missed by whoever keeps to one solver: the choice is worth making."""
    for name in ("taylor", "radau"):
        ratios = []
        for drawn, steps in counts:
            cost = {each: count * step_cost(each, drawn.tolerance) for each, count in steps.items()}
            ratios.append(cost[name] / min(cost.values()))
        assert np.percentile(ratios, 90) > 3.0


@pytest.mark.parametrize("name", ["taylor", "radau", "closed_form"])
def test_steps_are_predicted_within_a_factor_of_three_in_four_of_five(counts, name):
    ratios = [predicted_steps(name, *drawn[:4]) / steps[name] for drawn, steps in counts if name in steps]
    low, high = np.percentile(ratios, [10, 90])
    assert low > 1 / 3
    assert high < 3.0


def test_taylor_is_not_chosen_where_it_would_spend_the_budget_and_another_would_not(counts):
    spent = 0
    for drawn, steps in counts:
        each = {name: drawn.hold * count for name, count in steps.items()}
        if each["taylor"] > STEPS_A_HOLD and min(each.values()) < STEPS_A_HOLD / 5:
            spent += 1
            assert choose(AUTO, *drawn[:4]).name != "taylor", drawn
    assert spent > 10


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize(
    ("groups", "expected"),
    [
        (Groups(), "taylor"),
        (PRESETS["linear"], "closed_form"),
        (PRESETS["high-damping"], "taylor"),
        (Groups(damping_ratio=1e4), "radau"),
        (Groups(foot_mass_fraction=1e-6), "radau"),
        (Groups(foot_mass_fraction=1.0 - 1e-6), "radau"),
        (Groups(**STIFF), "radau"),
        (Groups(deborah=1e-6), "taylor"),
        (Groups(duffing=1e6), "taylor"),
        (Groups(**FAST), "taylor"),
    ],
    ids=["default", "linear", "damped", "Pi2", "light foot", "light payload", "four stiff", "Pi4", "Pi1", "undamped"],
)
def test_named_crawlers_get_the_solver_that_is_cheapest(benchmark, step_cost, groups, expected, tolerance):
    drawn = benchmark.Drawn(groups, Scene(), 1.0, tolerance, WORD)
    cost = {name: count * step_cost(name, tolerance) for name, count in counted(benchmark, drawn).items()}
    assert choose(AUTO, *drawn[:4]).name == expected
    assert cost[expected] <= 1.5 * min(cost.values())


def test_a_heavy_segment_costs_what_its_crawler_does():
    # Twice the mass: its unit of time is longer by the root of two, and the unit that cost is counted in is not.
    heavy, unit = Groups(damping_ratio=1e3), np.sqrt(2.0)
    alike = Groups(damping_ratio=1e3 / unit, deborah=heavy.deborah / unit, foot_mass_fraction=(0.3 + 0.5) / 2.0)
    for name in ("taylor", "radau"):
        cost = predicted_cost(name, heavy, Scene(tube_mass=1.0), 1.0, 1e-6)
        assert cost == pytest.approx(predicted_cost(name, alike, Scene(), 1.0 / unit, 1e-6) / unit)


def test_a_chain_is_left_to_the_only_solver_that_can_take_it():
    assert choose(AUTO, Groups(damping_ratio=1e4), Scene(segments=3, tube_mass=1.0), 1.0, 1e-6).name == "taylor"


@pytest.mark.parametrize("extreme", [5e-324, 1e-30, 1e300])
def test_a_prediction_is_a_number_however_extreme_the_groups(extreme):
    for groups in (
        Groups(duffing=extreme, radial_coupling=5.0),
        Groups(damping_ratio=extreme),
        Groups(deborah=extreme),
        Groups(radial_coupling=extreme, duffing=0.0),
        Groups(foot_mass_fraction=min(extreme, 0.5)),
    ):
        for hold in (1e-6, 1e4):
            assert predicted_cost("taylor", groups, Scene(), hold, 1e-9) > 0.0
            assert predicted_cost("radau", groups, Scene(), hold, 1e-9) > 0.0


def test_a_stiff_run_by_auto_finishes_where_taylor_would_not():
    done = simulate(Groups(**STIFF), WORD, 1.0, tolerance=1e-6)
    assert done.model == "on the ground, radau"


# The prediction's parts, each against what its page says it is


def method_of(solver, tolerance):
    return cost._method(cost.PREDICTED.index(solver), order_for(tolerance), stages_for(tolerance), tolerance)


def steps_by_quadrature(mode, span, tolerance, method):
    """The integral of 1 / h over the time that the mode is followed, and what it costs once it is dead."""
    order, size = method.order, mode.acceleration
    if method.stiff:
        size *= max(1.0 / mode.mobility, 1.0 / mode.rate, 1.0 / mode.rate**2)

    def pace(t):
        h = method.reach * (math.factorial(order) * tolerance / size) ** (1.0 / order) / mode.rate
        h *= math.exp(mode.decay * t / order)
        longest = method.longest / mode.rate
        dead = 0.0 if method.stiff or not mode.lasting else 1.0 / longest
        return 1.0 / h if h < longest else dead

    parts = 4000
    return span / parts * sum(pace(span * (i + 0.5) / parts) for i in range(parts))


@pytest.mark.parametrize("solver", ["taylor", "radau"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-9])
@pytest.mark.parametrize(
    ("rate", "decay", "acceleration", "lasting"),
    [
        (2.0, 0.0, 1.0, True),
        (2.0, 0.5, 1.0, True),
        (30.0, 30.0, 5.0, True),
        (30.0, 30.0, 5.0, False),
        (3.0, 1.0, 1e-4, True),
    ],
)
def test_steps_through_a_transient_are_the_integral_of_their_density(
    solver, tolerance, rate, decay, acceleration, lasting
):
    mode = cost.Transient(rate, decay, acceleration, 2.0, lasting)
    method = method_of(solver, tolerance)
    expected = steps_by_quadrature(mode, 8.0, tolerance, method)
    assert cost._steps_through(mode, 8.0, method) == pytest.approx(expected, rel=5e-3, abs=1e-6)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_method_is_its_order_and_the_steps_that_it_may_take(tolerance):
    taylor, radau = method_of("taylor", tolerance), method_of("radau", tolerance)
    assert (taylor.order, taylor.stiff, radau.stiff) == (order_for(tolerance), False, True)
    assert taylor.longest == 0.5 * taylor.order
    assert radau.order == stages_for(tolerance)
    assert radau.longest == pytest.approx(2.0 * math.factorial(radau.order) ** (1.0 / radau.order))
    assert (taylor.reach, radau.reach) == (1.2, 2.5)


@pytest.mark.parametrize("duffing", [0.0, 1e-6, 0.5, 30.0, 1e6])
@pytest.mark.parametrize("coupling", [0.0, 0.2, 0.99, 1.0, 3.0])
def test_the_pressure_holds_the_body_where_its_forces_balance(duffing, coupling):
    z = cost._held_stretch(coefficients_of(Groups(duffing=duffing, radial_coupling=coupling), Scene()))
    if duffing == 0.0 and coupling >= 1.0:
        assert z == 1.0
    else:
        # Scaled by the largest of its terms.
        terms = np.array([duffing * z**3, (1.0 - coupling) * z, -1.0])
        assert abs(terms.sum()) < 1e-9 * np.abs(terms).max()
        assert z > 0.0


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.9, 20.0])
@pytest.mark.parametrize("motion", [STUCK, FORWARD])
def test_transients_of_the_body_are_roots_of_its_characteristic_equation(damping, motion):
    groups = Groups(damping_ratio=damping, duffing=2.0)
    z, r = 0.7, groups.foot_mass_fraction
    mass = 1.0 - r if motion == STUCK else r * (1.0 - r)
    roots = np.roots([mass, 2.0 * damping, 1.0 + 3.0 * 2.0 * z**2])
    modes = cost._body_transients(coefficients_of(groups, Scene()), motion, z, 1.3, 0.1)
    if roots.imag.any():
        only, none = modes
        assert none.rate == 0.0
        assert (only.rate, only.decay) == pytest.approx((abs(roots[0]), -roots[0].real), rel=1e-12)
    else:
        assert [mode.rate for mode in modes] == pytest.approx(sorted(-roots.real, reverse=True), rel=1e-9)
        assert [mode.decay for mode in modes] == pytest.approx([mode.rate for mode in modes])
    fast = modes[0]
    assert fast.mobility == pytest.approx(1.0 / mass)
    # The pressure pushes within its lag; what breaks loose is pushed at once.
    push = max(1.3 / (1.0 + fast.rate * groups.deborah), 0.1)
    assert fast.acceleration == pytest.approx(push / mass)


def test_the_fastest_rate_is_the_largest_of_all():
    r = 0.3
    about = {
        Groups(deborah=1e-3): ("the lag of the fluid (deborah)", 1e3, 1e3),
        Groups(damping_ratio=9.0): (
            "the damping over a sliding foot (damping_ratio, foot_mass_fraction)",
            18.0 / (r * (1.0 - r)),
            18.0 / (r * (1.0 - r)),
        ),
        Groups(duffing=500.0): (
            "the spring over a sliding foot (duffing, foot_mass_fraction)",
            math.sqrt((1.0 + 1500.0 * 0.25) / (r * (1.0 - r))),
            0.05 / (r * (1.0 - r)),
        ),
    }
    for groups, (name, rate, decay) in about.items():
        found = cost.fastest_rate(groups, Scene(), 0.5)
        assert found == (name, pytest.approx(rate), pytest.approx(decay))
        anchored = cost.fastest_rate(groups, Scene(anchored=True), 0.5)
        assert "sliding" not in anchored.name
        if "lag" not in name:
            share = r if "damping" in name else math.sqrt(r)
            assert anchored.rate == pytest.approx(share * rate)


@pytest.mark.parametrize("anchored", [False, True])
@pytest.mark.parametrize("segments", [2, 7])
def test_the_fastest_rate_of_a_chain_is_that_of_its_masses_and_springs(anchored, segments):
    groups, scene = Groups(duffing=0.7, damping_ratio=0.01), Scene(segments=segments, tube_mass=0.3, anchored=anchored)
    masses = np.full(segments + 1, 0.3 / segments)
    masses[[0, -1]] = 0.5 * masses[0] + [groups.foot_mass_fraction, 1.0 - groups.foot_mass_fraction]
    ends = np.diff(np.eye(segments + 1), axis=0)
    springs = segments * (1.0 + 3.0 * 0.7 * 0.5**2) * ends.T @ ends
    moving = slice(1, None) if anchored else slice(None)
    squares = scipy.linalg.eigvals(springs[moving, moving] / masses[moving, None]).real
    phase = "resting" if anchored else "sliding"
    found = cost.fastest_rate(groups, scene, 0.5)
    assert found.name == f"the spring of the segments over a {phase} foot (duffing, segments, tube_mass)"
    assert found.rate == pytest.approx(math.sqrt(squares.max()))
    damping = groups.damping_ratio * squares.max() / (1.0 + 3.0 * 0.7 * 0.5**2)
    assert found.decay == pytest.approx(damping)
    dampened = cost.fastest_rate(Groups(duffing=0.7, damping_ratio=9.0), scene, 0.5)
    assert dampened.name == f"the damping of the segments over a {phase} foot (damping_ratio, segments, tube_mass)"
    assert dampened.rate == pytest.approx(2.0 * damping * 9.0 / groups.damping_ratio)


def test_predicted_steps_add_up():
    """Of an anchored linear body: one for the hold, those of the fluid and those of the body, over the hold."""
    groups, scene, hold, tolerance = PRESETS["linear"], Scene(anchored=True), 3.0, 1e-6
    coefficients = coefficients_of(groups, scene)
    mobility = 1.0 / 0.7
    for solver in ("taylor", "radau"):
        method = method_of(solver, tolerance)
        fluid = cost.Transient(2.0, 2.0, mobility, mobility, lasting=False)
        modes = [fluid, *cost._body_transients(coefficients, STUCK, 1.0, 1.0, 0.0)]
        expected = 1.0 + sum(cost._steps_through(mode, hold, method) for mode in modes)
        assert predicted_steps(solver, groups, scene, hold, tolerance) == pytest.approx(expected / hold)
    assert predicted_steps("closed_form", groups, scene, hold, tolerance) == 1.0 / hold


@pytest.mark.parametrize("ratchet", [True, False])
def test_looks_are_predicted_by_the_oscillations_that_are_alive(ratchet):
    """A grip forward, and without a ratchet one backward; then looks for as long as the swing lives."""
    heavy = Groups(duffing=0.0, radial_coupling=0.0, static_friction=9.0)
    scene = Scene(ratchet=ratchet)
    assert predicted_steps("closed_form", heavy, scene, 2.0, 1e-9) == (2.0 if ratchet else 3.0) / 2.0
    loose = PRESETS["linear"]
    swinging = math.sqrt(1.0 / 0.7), math.sqrt(1.0 / 0.21)
    for hold in (0.5, 500.0):
        decays = 0.05 / 0.7, 0.05 / 0.21
        looks = [1.5 * rate * min(hold, 3.0 / decay) for rate, decay in zip(swinging, decays, strict=True)]
        expected = (2.0 if ratchet else 3.0) + 0.5 * sum(looks)
        assert predicted_steps("closed_form", loose, scene, hold, 1e-9) == pytest.approx(expected / hold)


def test_a_cost_is_steps_times_what_each_takes():
    case = PRESETS["linear"], Scene(), 1.0, 1e-6
    each = {name: predicted_cost(name, *case) / predicted_steps(name, *case) for name in SOLVERS}
    # Microseconds: a Taylor step of order 12, a Radau step of 7 stages, a look.
    assert each == pytest.approx({"taylor": 0.25 + 12 * 0.012, "radau": 7 * 0.3, "closed_form": 0.13})


def test_a_solver_that_would_spend_the_budget_is_taken_only_where_no_other_is_left():
    # By Taylor this takes 1,300 steps a hold at the least; by Radau a few dozen. Of a hold a tenth as long, neither.
    groups = Groups(damping_ratio=200.0)
    steps = {name: 10.0 * predicted_steps(name, groups, Scene(), 10.0, 1e-2) for name in ("taylor", "radau")}
    assert steps["taylor"] > STEPS_A_HOLD > 20.0 * steps["radau"]
    assert choose(AUTO, groups, Scene(), 10.0, 1e-2).name == "radau"


@pytest.mark.parametrize(
    ("groups", "scene", "hold", "tolerance", "expected"),
    [
        # Radau would take a third of a hold's budget, and twice that at the worst.
        (Groups(duffing=2000.0, damping_ratio=0.01, deborah=2e-5), Scene(), 400.0, 1e-2, "radau"),
        # It would take nine tenths, and so might spend it all as well.
        (Groups(duffing=300.0, damping_ratio=0.0, deborah=2.0), Scene(anchored=True), 700.0, 1e-2, "taylor"),
    ],
)
def test_rather_dear_than_not_finished_where_another_surely_finishes(groups, scene, hold, tolerance, expected):
    case = groups, scene, hold, tolerance
    steps = {name: hold * predicted_steps(name, *case) for name in ("taylor", "radau")}
    assert predicted_cost("taylor", *case) < predicted_cost("radau", *case)
    assert steps["taylor"] > STEPS_A_HOLD > steps["radau"]
    assert (2.0 * steps["radau"] < STEPS_A_HOLD) == (expected == "radau")
    assert choose(AUTO, *case).name == expected
