"""A run is the same to the bit however many calls of compiled code it is made of."""

import numpy as np
import pytest

from stickslip.crawler import drive, Groups, Scene, simulate, SolverError
from stickslip.crawler.motion import progress

CRAWLERS = {
    "taylor": {"groups": Groups()},
    "taylor, 12 digits": {"groups": Groups(), "tolerance": 1e-12},
    "closed form": {"groups": Groups(duffing=0.0, radial_coupling=0.0)},
    "radau": {"groups": Groups(), "solver": "radau"},
    "slides both ways": {
        "groups": Groups(static_friction=0.05, kinetic_friction=0.02),
        "scene": Scene(ratchet=False, slope=0.01),
    },
    "chain": {"groups": Groups(), "scene": Scene(segments=3, tube_mass=0.3)},
}
DUTY = np.random.default_rng(0).random(30)
DUTY[::5] = 1.0


def run(crawler, **arguments):
    return simulate(valve=DUTY, hold=0.7, samples_per_hold=3, **crawler, **arguments)


def of_one_call_in(steps, monkeypatch):
    monkeypatch.setattr(progress, "PAUSE_AFTER", steps)


@pytest.mark.parametrize("crawler", CRAWLERS.values(), ids=CRAWLERS)
def test_pauses_change_no_bit(monkeypatch, crawler):
    of_one_call_in(10**9, monkeypatch)
    whole = run(crawler)
    assert whole.slips > 3
    for steps in (1, 2, 5):
        of_one_call_in(steps, monkeypatch)
        paused = run(crawler)
        for name in vars(whole) if hasattr(whole, "__dict__") else whole.__slots__:
            np.testing.assert_array_equal(getattr(paused, name), getattr(whole, name), err_msg=name)


@pytest.mark.parametrize("crawler", CRAWLERS.values(), ids=CRAWLERS)
def test_the_budget_is_that_of_all_calls(monkeypatch, crawler):
    reports = []
    for steps in (10**9, 1, 3):
        of_one_call_in(steps, monkeypatch)
        with pytest.raises(SolverError, match="step budget of 40 ") as report:
            run(crawler, max_steps=40)
        reports.append(str(report.value))
    assert len(set(reports)) == 1


def test_no_call_takes_more_steps_than_told(monkeypatch):
    steps = [0.0]

    def watched(state, *arguments):
        kernel(state, *arguments)
        steps.append(state[2])

    kernel = drive._drive_on
    monkeypatch.setattr(drive, "_drive_on", watched)
    of_one_call_in(10, monkeypatch)
    run(CRAWLERS["taylor"])
    assert len(steps) > 5
    assert max(np.diff(steps)) <= 10
