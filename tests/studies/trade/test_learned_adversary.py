"""A policy that is learned to fool the memory reward: what it sees, and that its search finds what there is."""

import numpy as np
import pytest

from stickslip.studies.trade import learned_adversary as learning
from stickslip.studies.trade.adversaries import ADVERSARIES, earned_and_held
from stickslip.studies.trade.conditions import conditions
from stickslip.studies.trade.learned_adversary import inputs, learned_adversary, linear

SETTINGS = conditions(dither=0.2)


def test_a_linear_policy_may_be_a_relay_or_hold_the_valve():
    relay, held = np.zeros((2, inputs(SETTINGS)))
    relay[5], held[0] = 1.0, 1.0  # the flip five ago; the constant
    both = earned_and_held(linear(np.array([relay, held])), SETTINGS, (3, 4, 3, 4), 200, 1)
    by_hand = {"relay": ADVERSARIES["relay of the flip 5 ago"], "open": lambda batch: lambda *_: np.ones(2, np.int64)}
    for i, adversary in enumerate(by_hand.values()):
        alone = earned_and_held(adversary, SETTINGS, (3, 4), 200, 1)
        np.testing.assert_array_equal(both[:, 2 * i : 2 * i + 2], alone)


def test_what_is_searched_for_is_found(monkeypatch):
    aim = np.linspace(-2.0, 2.0, inputs(conditions()))
    monkeypatch.setattr(learning, "linear", lambda weights: weights)

    def excess(weights, settings, seeds, holds, threads):
        each = np.repeat(-np.sum((weights - aim) ** 2, axis=1), len(seeds) // len(weights))
        return np.array([each, np.zeros(len(each))])

    monkeypatch.setattr(learning, "earned_and_held", excess)
    found = learned_adversary(generations=40, policies=200)
    np.testing.assert_allclose(found[0], aim, atol=0.1)
    np.testing.assert_array_equal(learned_adversary(generations=40, policies=200), found)
    assert not np.array_equal(learned_adversary(generations=40, policies=200, seed=1), found)


@pytest.mark.parametrize(
    ("options", "says"),
    [({"generations": 0}, "generations must be"), ({"holds": 100}, "holds must be"), ({"dither": 0.0}, "dither must")],
)
def test_a_search_of_what_cannot_be_is_refused(options, says):
    with pytest.raises(ValueError, match=says):
        learned_adversary(**options)
