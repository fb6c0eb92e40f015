"""What an unfinished step says of its slips: those of that hold, in the time since it began."""

import gymnasium as gym
import numpy as np
import pytest

from stickslip.crawler import simulate, SolverError
from stickslip.crawler.refusals import solver_error
from stickslip.envs.calibration import calibration_valves

NAME = "StickSlipCrawler-v0"
# It slips in every hold, and diverges in one.
HOLD = 5.0
CRAWLER = {
    "groups": {
        "duffing": 0.0,
        "damping_ratio": 0.05,
        "radial_coupling": 1.5,
        "static_friction": 0.1,
        "kinetic_friction": 0.05,
    },
    "scene": {"ratchet": False},
}


@pytest.fixture
def told(monkeypatch):
    """The (time, slips, beginning) of each unfinished run, as they are told."""
    runs = []

    def tell(status, time, deformation, steps, groups, scene, tolerance, solver, slips=None, began=0.0):
        runs.append((time, slips, began))
        return solver_error(status, time, deformation, steps, groups, scene, tolerance, solver, slips, began)

    for module in ("crawler.simulation", "envs.single", "envs.batch_engine", "envs.single_kernel"):
        monkeypatch.setattr(f"stickslip.{module}.solver_error", tell)
    return runs


def stepped(environment, valve):
    """Slips and steps before the one that fails."""
    environment.reset(seed=0)
    slips, shape = 0, environment.action_space.shape
    for k, command in enumerate(valve):
        try:
            slips = environment.step(np.full(shape, command))[4]["slips"]
        except SolverError:
            return int(np.max(slips)), k
    raise AssertionError("nothing failed")


@pytest.mark.parametrize("others", [[], [{}], [{"damping_ratio": 1e3}]])
def test_a_hold_that_fails_tells_its_own_slips(told, others):
    valve = [1, 0] * 10
    with pytest.raises(SolverError):
        simulate(CRAWLER["groups"], valve, HOLD, scene=CRAWLER["scene"], tolerance=1e-6)
    ((time, in_all, _),) = told
    single = {**CRAWLER, "hold": HOLD, "dither": 0.0, "memory_weight": 0.0}
    batch = {**single, "groups": [*others, CRAWLER["groups"]]}
    for environment in (gym.make(NAME, **single), gym.make_vec(NAME, len(others) + 1, **batch)):
        before, steps = stepped(environment, valve)
        reached, slips, began = told.pop()
        assert before > 0
        assert slips > 0
        assert before + slips == in_all
        assert began == steps * HOLD > 0.0
        assert reached == pytest.approx(time)


def test_a_calibration_that_fails_does_too(told):
    for make in (gym.make, gym.make_vec):
        environment = make(NAME, **CRAWLER, hold=HOLD)
        with pytest.raises(SolverError):
            environment.reset(seed=0)
        _, slips, began = told.pop()
        valves = calibration_valves(environment.unwrapped.settings)[: round(began / HOLD) + 1]
        body = {"scene": CRAWLER["scene"], "tolerance": 1e-6}
        before = simulate(CRAWLER["groups"], valves[:-1], HOLD, **body).slips
        with pytest.raises(SolverError):
            simulate(CRAWLER["groups"], valves, HOLD, **body)
        assert before > 0
        assert before + slips == told.pop()[1]
