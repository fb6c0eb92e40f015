"""Several policies in one: at each weight it acts as the one that pays best there."""

import numpy as np
import pytest

import stickslip
from stickslip.train.distilled import best_at, distil
from stickslip.train.policies import Policy


def holding(bias, speed, memory):
    """A policy that holds the valve still, or, with no bias, follows the last valve state, with scores of its own."""
    knee = stickslip.pretrained("knee")
    description = knee.description
    description["network"]["sizes"] = [8, 2]
    description["scores"] = {"speed": {"mean": speed}, "memory": {"mean": memory}}
    weight = np.zeros((2, 8), np.float32)
    weight[1, 4] = 0.0 if bias else 2.0
    return Policy([(weight, np.array([0.0, bias or -1.0], np.float32))], description)


SHUT, OPEN = holding(-1.0, 0.5, 0.0), holding(1.0, 0.0, 1.0)


def test_the_best_is_that_of_most_reward():
    # (1 - w) / 2 against w: level at a third.
    assert best_at([SHUT, OPEN], np.array([0.0, 0.33, 0.34, 1.0])).tolist() == [0, 0, 1, 1]


def test_one_network_acts_as_the_best_at_each_weight():
    settings = {"hidden": (8,), "rounds": 2, "holds": 20, "updates": 300}
    pupil = distil([SHUT, OPEN], **settings)
    seen = np.abs(np.random.default_rng(0).normal(size=(200, 8))) * 0.3
    for weight, action in ((0.0, 0), (0.2, 0), (0.6, 1), (1.0, 1)):
        assert np.mean(pupil.predict(seen, weight) == action) > 0.97
    assert pupil.conditioned
    assert "memory_weight" not in pupil.env_kwargs
    assert [each["scores"] for each in pupil.description["algorithm"]["teachers"]] == [SHUT.scores, OPEN.scores]
    again, other = distil([SHUT, OPEN], **settings), distil([SHUT, OPEN], **settings, seed=1)
    np.testing.assert_array_equal(again.layers[0].weight, pupil.layers[0].weight)
    assert not np.array_equal(other.layers[0].weight, pupil.layers[0].weight)


def test_teachers_of_other_environments_are_refused():
    description = OPEN.description
    description["env_kwargs"]["hold"] = 0.25
    with pytest.raises(ValueError, match="policies must be of one environment but for memory_weight"):
        distil([SHUT, Policy(OPEN.layers, description)])
