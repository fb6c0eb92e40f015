"""The peers of `benchmarks/peers.py` solve the very problem that stickslip is measured on."""

from importlib import import_module

import pytest

from stickslip.crawler import simulate

SHORT = 16  # holds


@pytest.fixture(scope="module")
def problem():
    return import_module("peer_solvers.problem")


def named(library, method, setting):
    module = import_module(f"peer_solvers.with_{library}")
    return next(each for each in module.contenders() if (each.method, each.setting) == (method, setting))


@pytest.mark.parametrize(
    ("library", "method", "setting", "accuracy"),
    [
        ("scipy", "RK45", "1e-08", 1e-7),
        ("scipy", "DOP853", "1e-12", 1e-10),
        ("scipy", "Radau", "1e-06", 1e-4),
        ("heyoka", "Taylor", "full precision", 1e-13),
        ("mujoco", "RK4, located switch", "dt 0.05", 1e-4),
        ("mujoco", "Euler, mode switch", "dt 0.001", 1e-2),
        pytest.param("diffrax", "Tsit5", "1e-08", 1e-6, marks=pytest.mark.slow),
    ],
)
def test_a_peer_crawls_as_far_in_as_many_slips(problem, library, method, setting, accuracy):
    if library != "scipy":
        pytest.importorskip(library)
    word = problem.WORD[:SHORT]
    done = simulate(problem.GROUPS, word, problem.HOLD, tolerance=1e-14)
    foot, slips = named(library, method, setting).run(word)
    assert foot == pytest.approx(done.foot[-1], abs=accuracy)
    assert slips == done.slips == 4


def test_a_lucky_setting_is_not_the_cheapest():
    comparison = import_module("peer_solvers.comparison")
    errors = {1e-3: 1e-9, 1e-6: 1e-4, 1e-9: 1e-7, 1e-12: 1e-10}
    rows = [
        {
            "library": "any",
            "method": "one",
            "tolerance": tolerance,
            "error": error,
            "microseconds per time unit": [cost, cost, cost],
        }
        for cost, (tolerance, error) in enumerate(errors.items(), 1)
    ]
    assert comparison.cheapest(rows, "any", "one", 1e-6)["tolerance"] == 1e-9
    assert comparison.cheapest(rows, "any", "one", 1e-11) is None
    assert comparison.cheapest(rows, "any", "another", 1e-3) is None
