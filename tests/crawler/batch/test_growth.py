"""Small changes of crawlers in lanes grow as those of each alone, whose transitions are exponentials and not series."""

import numpy as np
import pytest

from stickslip.crawler import Groups, Scene
from stickslip.crawler.batch.driving import grow_in_lanes
from stickslip.crawler.batch.lane_runs import blank_runs
from stickslip.crawler.model.columns import coefficients_of_each
from stickslip.crawler.model.state import Body, coefficients_of
from stickslip.crawler.motion import progress
from stickslip.crawler.runs import run_growth
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import FINISHED, OUT_OF_STEPS

TAYLOR, TOLERANCE, PLENTY = SOLVERS["taylor"], 1e-9, 10**6
CRAWLERS = [
    (Groups(), Scene()),
    (Groups(duffing=200.0, damping_ratio=0.02), Scene(anchored=True)),
    (Groups(kinetic_friction=0.3), Scene()),
    (Groups(static_friction=0.0, kinetic_friction=0.0), Scene(ratchet=False)),
    (Groups(foot_mass_fraction=0.8, static_friction=0.1, kinetic_friction=0.05), Scene(ratchet=False)),
    (Groups(damping_ratio=3.0), Scene()),
    (Groups(radial_coupling=1.0, duffing=5.0), Scene(slope=0.05)),
    (Groups(deborah=5.0), Scene()),
    (Groups(damping_ratio=0.005, duffing=0.0), Scene()),
]
HOLDS, WASHOUT = 30, 8
ENDS = np.array([1, 7, 8, HOLDS - WASHOUT])


def schedules():
    valves = np.random.default_rng(7).integers(0, 2, (len(CRAWLERS), HOLDS)).astype(float)
    valves[1::3] = 0.1 + 0.6 * valves[1::3]
    return valves


def runs_of(hold, budget=PLENTY, crawlers=CRAWLERS):
    count = len(crawlers)
    columns = coefficients_of_each([groups for groups, _ in crawlers], [scene for _, scene in crawlers])
    return blank_runs(np.zeros((7, count)), columns, np.full(count, hold), np.empty((count, 5, 0)), budget)


# In a hold of 30 some bodies come to rest, and steps are longer than the series of a change reaches.
@pytest.mark.parametrize("hold", [0.7, 30.0])
def test_changes_in_lanes_grow_as_alone(hold, monkeypatch):
    valves, runs = schedules(), runs_of(hold)
    options = TAYLOR.options(TOLERANCE)
    grown = grow_in_lanes(runs, valves, WASHOUT, ENDS, options, 2)
    assert (runs.statuses == FINISHED).all()
    assert grown[:, 3, -1].sum() > 15.0, "hardly a foot has stopped"
    for i, (groups, scene) in enumerate(CRAWLERS):
        alone = TAYLOR.options(TOLERANCE, tangents=True)
        start = Body(0.0, 0.0, 0.0, 0.0, 0.0, 0, 0)
        outcome, finished, growth = run_growth(
            start, coefficients_of(groups, scene), 1.0, valves[i], WASHOUT, hold, alone, TAYLOR
        )
        np.testing.assert_array_equal(runs.bodies[:, i], outcome.body)
        assert (runs.finished[i], runs.steps[i]) == (finished, outcome.steps)
        expected = growth[:, ENDS - 1]
        time = HOLDS * hold
        np.testing.assert_allclose(grown[i, :2], expected[:2], rtol=0.0, atol=2e-8 * time)
        np.testing.assert_allclose(grown[i, 2], expected[2], rtol=1e-12)
        np.testing.assert_array_equal(grown[i, 3], expected[3])
    monkeypatch.setattr(progress, "PAUSE_AFTER", 64)
    paused = runs_of(hold)
    np.testing.assert_array_equal(grow_in_lanes(paused, valves, WASHOUT, ENDS, options, 1), grown)


def test_a_change_of_any_length_is_followed():
    # exp(-3000) and less is no number.
    crawlers = [(Groups(damping_ratio=30.0), Scene(anchored=True))] * 2
    runs = runs_of(2.0, crawlers=crawlers)
    grown = grow_in_lanes(runs, np.ones((2, 40)), 0, np.array([40]), TAYLOR.options(TOLERANCE), 1)
    assert grown[0, 1, 0] == pytest.approx(-2.0 * 30.0 / 0.7 * 80.0, rel=1e-12)
    slow = (30.0 - np.sqrt(30.0**2 - 0.7)) / 0.7
    assert grown[0, 0, 0] == pytest.approx(-slow * 80.0, abs=0.5)


def test_a_spent_budget_is_told_with_the_holds_of_the_washout():
    (crawler, *_), budget = CRAWLERS, 40
    runs, valves = runs_of(0.7, budget, [crawler] * 2), schedules()[:1].repeat(2, axis=0)
    grow_in_lanes(runs, valves, WASHOUT, ENDS, TAYLOR.options(TOLERANCE), 1)
    alone = TAYLOR.options(TOLERANCE, tangents=True, max_steps=budget)
    start = Body(0.0, 0.0, 0.0, 0.0, 0.0, 0, 0)
    outcome, finished, _ = run_growth(start, coefficients_of(*crawler), 1.0, valves[0], WASHOUT, 0.7, alone, TAYLOR)
    assert WASHOUT < finished < HOLDS
    assert runs.statuses.tolist() == [outcome.status] * 2 == [OUT_OF_STEPS] * 2
    assert runs.steps.tolist() == [outcome.steps] * 2 == [budget] * 2
    assert runs.finished.tolist() == [finished] * 2
