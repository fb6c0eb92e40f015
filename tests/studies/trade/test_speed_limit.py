"""The fastest policy: its plan, its grid, and the speeds that independent code came to."""

from itertools import product

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from stickslip.crawler import Groups, simulate
from stickslip.crawler.model.state import State
from stickslip.studies.trade import speed_limit
from stickslip.studies.trade.conditions import conditions
from stickslip.studies.trade.grid import Grid, reachable_pressures
from stickslip.studies.trade.holds import Holds
from stickslip.studies.trade.speed_limit import Planner

SOME = np.array([[0.2, -0.1, 0.9], [-0.4, 0.3, -1.1], [0.7, 0.3, 0.95], [0.0, 0.0, 0.8]])


def test_a_hold_is_that_of_simulate_from_the_same_state():
    valves = np.array([1, 0, 1])
    after, distances = Holds(conditions(), 1)(SOME, valves)
    for i, valve in enumerate(valves.tolist()):
        z, v, p, w = SOME[:, i].tolist()
        run = simulate(Groups(), [valve], 0.5, tolerance=1e-6, initial=State(z, v, p, 0.0, w))
        assert after[:, i].tolist() == [run.deformation[-1], run.velocity[-1], run.pressure[-1], run.foot_velocity[-1]]
        assert distances[i] == run.foot[-1]


def test_interpolation_is_multilinear_on_either_side_of_a_foot_that_sticks():
    grid = Grid([-1.0, 0.0, 2.0], [-2.0, 1.0], [0.0, 0.3, 1.0], [1.0, 3.0])
    random = np.random.default_rng(0)
    values = random.normal(size=grid.shape)
    states = random.uniform([[-1.0], [-2.0], [0.0], [0.0]], [[2.0], [1.0], [1.0], [3.0]], (4, 200))
    states[3, ::2] = 0.0
    found = grid.interpolation(states) @ values.ravel()
    sticks, slides = (
        RegularGridInterpolator(grid.axes[:3], values[..., 0]),
        RegularGridInterpolator(grid.axes, values[..., 1:]),
    )
    assert np.allclose(found[::2], sticks(states[:3, ::2].T), rtol=0, atol=1e-12)
    assert np.allclose(found[1::2], slides(states[:, 1::2].T), rtol=0, atol=1e-12)
    assert np.allclose(grid.interpolation(grid.points) @ values.ravel(), values.ravel(), rtol=0, atol=1e-12)


def test_beyond_its_ends_a_grid_is_what_it_is_there_and_says_so():
    grid = Grid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [1.0, 2.0])
    inside, beyond = np.array([[1.0], [0.5], [0.5], [2.0]]), np.array([[1.5], [0.5], [0.5], [7.0]])
    values = np.random.default_rng(0).normal(size=32)
    assert np.allclose(grid.interpolation(beyond) @ values, grid.interpolation(inside) @ values)
    assert grid.outside(np.hstack([inside, beyond])).tolist() == [False, True]


def test_no_pressure_that_holds_end_with_lies_between_the_intervals():
    points = reachable_pressures(0.5, 0.5, 8)
    kept = np.exp(-1.0)
    reached = np.array([0.5])
    for _ in range(6):
        reached = np.concatenate([kept * reached, 1 - kept + kept * reached])
    assert len(points) == 8
    assert set((np.searchsorted(points, reached) - 1).tolist()) == {0, 2, 4, 6}
    assert np.array_equal(reachable_pressures(0.1, 0.5, 5), [0.0, 0.25, 0.5, 0.75, 1.0])


def test_the_gain_of_a_hold_is_the_best_expectation_over_all_that_can_follow():
    settings = conditions(dither=0.2)
    grid = Grid([-3.0, 3.0], [-4.0, 4.0], [0.0, 1.0], [1.0, 4.0])
    values = np.random.default_rng(0).normal(size=np.prod(grid.shape))
    hold = Holds(settings, 1)

    def worth(state, depth):
        if depth == 0:
            return float((grid.interpolation(state) @ values)[0])
        each = []
        for valve in (0, 1):
            after, distance = hold(state, np.array([valve]))
            each.append(float(distance[0]) + worth(after, depth - 1))
        return max(0.8 * each[a] + 0.2 * each[1 - a] for a in (0, 1))

    gains = Planner(settings, grid, values, lookahead=3, threads=1).gains(SOME)
    for i, valve in product(range(3), (0, 1)):
        after, distance = hold(SOME[:, i : i + 1], np.array([valve]))
        assert gains[valve, i] == pytest.approx(float(distance[0]) + worth(after, 2), abs=1e-12)


def test_without_flips_a_coarse_grid_finds_the_fastest_gait(tmp_path):
    found = speed_limit(0.0, resolution=10, lookahead=3, seeds=1, holds=200, folder=tmp_path, threads=1)
    assert found.speeds == pytest.approx(1.0616, abs=0.01)
    assert found.outside == 0.0
    again = speed_limit(0.0, resolution=10, lookahead=3, seeds=1, holds=200, folder=tmp_path, threads=1)
    assert again.speeds == found.speeds
    assert len(list(tmp_path.iterdir())) == 1
    at_rest = np.zeros(5, np.float32)
    assert again.policy.predict(at_rest) == found.policy.predict(at_rest) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("dither", "speed"), [(0.0, 1.0616), (0.05, 0.948), (0.1, 0.841), (0.25, 0.561)])
def test_the_limits_are_those_of_independent_code(dither, speed):
    assert speed_limit(dither).speed.mean == pytest.approx(speed, abs=0.01)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"resolution": 5}, "resolution must be a whole number in"),
        ({"lookahead": 0}, "lookahead must be a whole number"),
        ({"scene": {"ratchet": False}}, "scene must have a foot that slides forward alone"),
        ({"memory_weight": 0.5}, "env_kwargs must be without memory_weight"),
    ],
)
def test_what_has_no_limit_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        speed_limit(**wrong)
