"""How far an answer moves for a change of its start, against finite differences in 50 digits and closed forms."""

from decimal import Decimal

import numpy as np
import pytest
from cases import WORD
from decimal_judge import decimal_judge

from stickslip.crawler import Groups, REST, Scene, simulate, State

SOLVERS = ("taylor", "radau")
SYMMETRIC = Scene(ratchet=False)
# Far above the 38 digits of the judge, far below what the curvature of the motion would show.
NUDGE = Decimal("1e-22")
CHAOTIC = Groups(
    duffing=150.0,
    damping_ratio=0.0,
    deborah=0.03,
    foot_mass_fraction=0.99,
    static_friction=0.03,
    kinetic_friction=0.01,
)
ANY = np.random.default_rng(5).integers(0, 2, 200)


def judged(groups, valve, hold, *, scene=None, initial=REST):
    """Largest singular value of the derivative of the end by the start, by finite differences in 50 digits."""

    def end(start):
        return decimal_judge(groups, valve, hold, scene=scene, initial=start).last

    start = State(*(Decimal(value) for value in initial))
    changed = [start._replace(deformation=start.deformation + NUDGE), start._replace(velocity=start.velocity + NUDGE)]
    if initial.foot_velocity != 0.0:
        changed.append(start._replace(foot_velocity=start.foot_velocity + NUDGE))
    here = end(start)
    columns = [
        [float((moved - value) / NUDGE) for moved, value in zip(end(other), here, strict=True)] for other in changed
    ]
    return np.linalg.norm(np.transpose(columns), 2)


def condition(groups, valve, hold, *, solver="auto", tolerance=1e-12, **options):
    return simulate(groups, valve, hold, solver=solver, tolerance=tolerance, condition=True, **options).condition


CASES = {
    "slips and stops": (Groups(), WORD, 1.0, {}),
    "both ways": (
        Groups(foot_mass_fraction=0.8, static_friction=0.1, kinetic_friction=0.05),
        WORD,
        1.0,
        {"scene": SYMMETRIC},
    ),
    "contracting": (Groups(), WORD * 2, 4.0, {"scene": Scene(anchored=True)}),
    "neutral": (Groups(damping_ratio=0.0), WORD, 1.0, {"scene": Scene(anchored=True)}),
    "sliding at the start": (Groups(), WORD[:4], 0.5, {"initial": State(0.2, -0.3, 0.5, 0.1, 0.4)}),
    "downhill": (Groups(static_friction=0.6), WORD, 1.0, {"scene": Scene(slope=0.2)}),
    "without friction": (Groups(static_friction=0.0, kinetic_friction=0.0), WORD, 1.0, {}),
    "chaotic": (CHAOTIC, ANY[:4], 1.0, {}),
    "breaking loose at the very start": (Groups(), [0, 1], 1.0, {"initial": State(1.0, 0.2, 0.1)}),
    "uphill both ways": (Groups(static_friction=0.2), WORD[2:6], 1.0, {"scene": Scene(ratchet=False, slope=0.3)}),
    "turning at once": (
        Groups(duffing=0.5, damping_ratio=0.01, static_friction=0.05, kinetic_friction=0.05),
        [0],
        3.0,
        {"initial": State(1.0, 0.0, 0.3), "scene": SYMMETRIC},
    ),
}
# A number that is small, or large, is one of few digits.
ACCURACY = {"contracting": 2e-5, "chaotic": 1e-3}


@pytest.mark.parametrize("name", CASES)
def test_condition_is_what_finite_differences_in_fifty_digits_find(name):
    groups, valve, hold, options = CASES[name]
    exact = judged(groups, valve, hold, **options)
    for solver in SOLVERS:
        found = condition(groups, valve, hold, solver=solver, **options)
        assert found == pytest.approx(exact, rel=ACCURACY.get(name, 3e-6))


def test_the_cases_are_what_they_are_called():
    def events(name):
        groups, valve, hold, options = CASES[name]
        return simulate(groups, valve, hold, **options).events

    assert events("breaking loose at the very start")[0].item()[:2] == (0.0, 1)
    assert {-1, 1} <= set(events("both ways")["mode"].tolist())
    assert -1 in events("uphill both ways")["mode"]
    assert events("turning at once")["mode"].tolist()[:2] == [1, -1]


@pytest.mark.slow
@pytest.mark.parametrize(("valve", "hold", "initial"), [(ANY[:14], 1.0, REST), ([1], 12.0, State(1.0))])
def test_condition_of_a_chaotic_body_is_within_a_factor_of_three_at_every_tolerance(valve, hold, initial):
    exact = judged(CHAOTIC, valve, hold, initial=initial)
    assert exact > 1e4
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        found = condition(CHAOTIC, valve, hold, solver="taylor", tolerance=tolerance, initial=initial)
        assert exact / 3.0 < found < 3.0 * exact


def test_chaos_of_a_condition_of_1e13_is_announced_at_every_tolerance():
    # Twins a few roundings apart are then as far apart as the attractor is wide.
    groups = Groups(
        duffing=155.0,
        damping_ratio=0.0,
        deborah=0.008,
        radial_coupling=1.24,
        foot_mass_fraction=0.992,
        static_friction=0.036,
        kinetic_friction=0.0072,
    )
    schedule = ANY[:60]
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        assert condition(groups, schedule, 1.0, scene=SYMMETRIC, tolerance=tolerance) > 1e13
    ends = [
        simulate(groups, schedule, 1.0, scene=SYMMETRIC, tolerance=1e-12, initial=State(z)).deformation[-1]
        for z in (0.0, 1e-13)
    ]
    assert abs(ends[1] - ends[0]) > 1e-3


def test_a_linear_body_has_the_condition_that_integration_finds():
    groups = Groups(duffing=0.0, radial_coupling=0.0)
    for options in ({}, {"scene": SYMMETRIC}, {"initial": State(0.2, -0.3, 0.5, 0.1, 0.4)}):
        exact = condition(groups, WORD, 1.0, solver="closed_form", **options)
        for solver in SOLVERS:
            assert condition(groups, WORD, 1.0, solver=solver, **options) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("damping", [1e2, 1e4])
def test_a_stiff_body_has_the_condition_that_the_closed_form_finds(damping):
    groups = Groups(
        duffing=0.0, radial_coupling=0.0, damping_ratio=damping, static_friction=1e-3, kinetic_friction=5e-4
    )
    exact = condition(groups, WORD, 1.0, solver="closed_form")
    for tolerance in (1e-4, 1e-9):
        found = condition(groups, WORD, 1.0, solver="radau", tolerance=tolerance)
        assert found == pytest.approx(exact, rel=1e-2)


def test_natural_units_of_the_tube_are_those_of_the_condition():
    # With half of the tube's mass at each end the body is a crawler in another unit of time.
    scene = Scene(tube_mass=0.5)
    change = 1e-7
    here = simulate(Groups(), WORD, 1.0, scene=scene, tolerance=1e-13)
    columns = []
    for start in (State(deformation=change), State(velocity=change)):
        moved = simulate(Groups(), WORD, 1.0, scene=scene, tolerance=1e-13, initial=start)
        names = ("deformation", "velocity", "foot", "foot_velocity")
        columns.append([(getattr(moved, name)[-1] - getattr(here, name)[-1]) / change for name in names])
    exact = np.linalg.norm(np.transpose(columns), 2)
    assert condition(Groups(), WORD, 1.0, scene=scene) == pytest.approx(exact, rel=1e-2)


@pytest.mark.parametrize("solver", ["auto", *SOLVERS])
def test_asking_does_not_change_the_motion(solver):
    asked = simulate(Groups(), WORD, 1.0, solver=solver, condition=True)
    silent = simulate(Groups(), WORD, 1.0, solver=solver)
    np.testing.assert_array_equal(asked.foot, silent.foot)
    np.testing.assert_array_equal(asked.events, silent.events)
    assert isinstance(asked.condition, float)
    assert silent.condition is None


def test_a_batch_has_the_conditions_of_its_rows():
    crawlers = [Groups(), Groups(duffing=0.0, radial_coupling=0.0), Groups(damping_ratio=1e3)]
    together = simulate(crawlers, WORD, 1.0, condition=True).condition
    assert together.tolist() == [simulate(groups, WORD, 1.0, condition=True).condition for groups in crawlers]


def test_a_run_in_parts_has_conditions_that_bound_the_whole():
    whole = simulate(Groups(), WORD * 2, 1.0, condition=True).condition
    first = simulate(Groups(), WORD, 1.0, condition=True)
    second = simulate(Groups(), WORD, 1.0, initial=first.final_state, condition=True)
    assert whole <= 1.01 * (first.condition + 1.0) * (second.condition + 1.0)


def test_a_pause_within_a_run_changes_nothing(monkeypatch):
    from stickslip.crawler.motion import progress

    whole = simulate(CHAOTIC, ANY[:4], 1.0, condition=True).condition
    monkeypatch.setattr(progress, "PAUSE_AFTER", 7)
    assert simulate(CHAOTIC, ANY[:4], 1.0, condition=True).condition == whole


def test_what_has_no_condition_is_refused():
    with pytest.raises(ValueError, match="condition must be False for a chain"):
        simulate(Groups(), WORD, 1.0, scene=Scene(segments=3, tube_mass=0.5), condition=True)
    with pytest.raises(TypeError, match="condition must be True or False, got 1"):
        simulate(Groups(), WORD, 1.0, condition=1)
