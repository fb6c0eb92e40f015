"""Numbers that vary: one vocabulary for randomized episodes, sweeps and searches."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

from stickslip import Groups, Scene
from stickslip.crawler.model.variations import Choice, Range, variations, VARIED, varied, with_amplitude


def test_what_varies_and_between_what():
    assert VARIED == {
        "hold": "(0, inf)",
        "amplitude": "(0, inf)",
        "duffing": "[0, inf)",
        "damping_ratio": "[0, inf)",
        "deborah": "(0, inf)",
        "radial_coupling": "[0, inf)",
        "foot_mass_fraction": "(0, 1)",
        "static_friction": "[0, inf)",
        "kinetic_friction": "[0, inf)",
        "slope": "(-inf, inf)",
    }
    given = {"slope": (-0.1, 0.1), "duffing": [0, 5], "hold": Range(0.1, 10, log=True)}
    found = variations("maps", given)
    assert found == {"hold": Range(0.1, 10.0, log=True), "duffing": Range(0.0, 5.0), "slope": Range(-0.1, 0.1)}
    assert list(found) == ["hold", "duffing", "slope"]
    assert variations("maps", {"duffing": np.array([1, 1])}) == {"duffing": Range(1.0, 1.0)}
    assert variations("maps", {"hold": {"low": 1, "high": 4}}) == {"hold": Range(1.0, 4.0)}
    assert variations("maps", {"hold": {"low": 1, "high": 4, "log": True}}) == {"hold": Range(1.0, 4.0, log=True)}
    assert variations("maps", None) == {}


def test_a_crawler_of_other_numbers():
    groups, scene = Groups(duffing=1.0), Scene(ratchet=False)
    assert varied(groups, scene, 0.5, {}) == (groups, scene, 0.5)
    numbers = {"duffing": 2.0, "static_friction": 0.8, "kinetic_friction": 0.6, "slope": 0.1, "hold": 2}
    assert varied(groups, scene, 0.5, numbers) == (
        Groups(duffing=2.0, static_friction=0.8, kinetic_friction=0.6),
        Scene(ratchet=False, slope=0.1),
        2.0,
    )
    # The pump of the body of the other numbers.
    both = varied(groups, scene, 0.5, {"amplitude": 2.0, "duffing": 3.0})[0]
    assert both == with_amplitude(Groups(duffing=3.0), 2.0)
    assert (both.duffing, both.radial_coupling, both.static_friction, both.kinetic_friction) == (12.0, 0.4, 0.15, 0.1)


@pytest.mark.parametrize("log", [False, True])
def test_a_share_of_the_way(log):
    each = Range(2.0, 8.0, log=log)
    assert [each.at(share) for share in (0.0, 0.5, 1.0)] == pytest.approx([2.0, 4.0 if log else 5.0, 8.0])
    assert Choice("abc").at(1.0) == "c"
    assert Range(3.0, 3.0, log=log).at(0.7) == 3.0


def test_episodes_are_drawn_as_numpy_draws_uniform_numbers():
    """Group by group in their order, and the slope last: what earlier versions drew, to the bit."""
    ranges = {"slope": (-0.2, 0.3), "static_friction": (0.4, 0.9), "duffing": (0.1, 7.3)}
    env = gym.make("StickSlipCrawler-v0", randomize=ranges)
    _, info = env.reset(seed=11)
    random = np.random.default_rng(11)
    drawn = {name: float(random.uniform(*ranges[name])) for name in ("duffing", "static_friction", "slope")}
    assert {**info["groups"], "slope": info["slope"]} == {**Groups().to_dict(), **drawn}
    logarithmic = gym.make("StickSlipCrawler-v0", randomize={"duffing": Range(0.01, 10, log=True)})
    low = [logarithmic.reset(seed=seed)[1]["groups"]["duffing"] for seed in range(40)]
    assert 0.01 < min(low) < 0.1 < 1 < max(low) < 10
    assert np.median(low) < 1


def test_a_range_is_kept_in_what_an_environment_was_made_from():
    env = gym.make("StickSlipCrawler-v0", randomize={"duffing": Range(0.01, 10, log=True), "slope": (0, 0.1)})
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert again.spec.kwargs["randomize"] == {"duffing": {"low": 0.01, "high": 10, "log": True}, "slope": [0, 0.1]}
    assert again.reset(seed=3)[1]["groups"] == env.reset(seed=3)[1]["groups"]


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ([("duffing", (0, 1))], TypeError, "maps must be a mapping of names to .low, high., got "),
        ({"wheels": (0, 1)}, ValueError, r"maps has no 'wheels'; allowed are \['duffing', 'hold'\]"),
        ({"slope": (0, 1)}, ValueError, "maps has no 'slope'"),
        ({"duffing": 1.0}, ValueError, r"maps duffing must be a pair \(low, high\), got 1.0"),
        ({"duffing": "01"}, ValueError, r"maps duffing must be a pair \(low, high\), got '01'"),
        ({"duffing": (2, 1)}, ValueError, r"maps duffing must be a pair with low <= high, got \(2, 1\)"),
        ({"duffing": (-1, 1)}, ValueError, r"maps duffing must be in \[0, inf\), got -1"),
        ({"duffing": ("a", 1)}, TypeError, r"maps duffing must be a number in \[0, inf\), got 'a'"),
        ({"hold": {"low": 1}}, ValueError, r"maps hold must be a pair \(low, high\), got \{'low': 1\}"),
        ({"hold": {"low": 1, "high": 2, "step": 1}}, ValueError, "maps hold has no 'step'; allowed are"),
        ({"hold": {"low": 1, "high": 2, "log": 1}}, TypeError, "maps hold log must be True or False, got 1"),
        ({"hold": Range(-1, 1)}, ValueError, r"maps hold must be in \(0, inf\), got -1"),
    ],
)
def test_bad_input(given, error, message):
    with pytest.raises(error, match=message):
        variations("maps", given, ("duffing", "hold"))


def test_a_range_too_wide_for_a_float():
    with pytest.raises(ValueError, match="slope must be a pair with low <= high"):
        variations("maps", {"slope": (-1.5e308, 1.5e308)})
    with pytest.raises(ValueError, match="numbers has no 'wheels'"):
        varied(Groups(), Scene(), 0.5, {"wheels": 4})
    with pytest.raises(ValueError, match=r"hold must be in \(0, inf\), got 0"):
        varied(Groups(), Scene(), 0.5, {"hold": 0})
