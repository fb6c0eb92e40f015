"""Which of many controllers are left out, and which make the front."""

import numpy as np

from stickslip.studies.trade.conditions import conditions
from stickslip.studies.trade.rollouts import Rollouts
from stickslip.studies.trade.selection import select, undominated


def test_only_what_is_surely_beaten_in_both_is_left_out():
    speeds, memories = np.array([0.9, 0.5, 0.2, 0.5]), np.array([1.0, 3.0, 0.5, 2.9])
    sure, unsure = np.full(4, 1e-3), np.full(4, 1.0)
    assert undominated(Rollouts(speeds, memories, sure, sure)).tolist() == [0, 1, 3]  # speeds that tie do not beat
    assert undominated(Rollouts(speeds, memories, unsure, sure)).tolist() == [0, 1, 2, 3]
    assert undominated(Rollouts(speeds, np.zeros(4), sure, np.zeros(4))).tolist() == [0]


def test_it_is_what_a_look_at_all_pairs_finds():
    random = np.random.default_rng(0)
    speeds, memories = random.normal(size=(2, 300))
    errors = random.uniform(0.0, 0.2, (2, 300))
    low = np.stack([speeds, memories]) - 2.0 * errors
    high = np.stack([speeds, memories]) + 2.0 * errors
    beaten = (low[:, :, None] > high[:, None, :]).all(axis=0).any(axis=0)
    assert 0 < beaten.sum() < 290
    assert np.array_equal(undominated(Rollouts(speeds, memories, *errors), 2.0), np.flatnonzero(~beaten))


def test_a_controller_keeps_its_number_through_the_rounds():
    asked = []

    def controllers(some, holds):
        asked.append((some.tolist(), holds))
        rows = np.where(some == 1, 1, 0)  # only number 1 ever opens its valve
        return lambda k, observations: rows * (k % 4 < 2)

    found = select(controllers, 9, 200, conditions(dither=0.0), threads=1)
    assert found.front.tolist() == [1]
    assert found.speeds[1] > 0.0
    assert np.flatnonzero(found.speeds).tolist() == [1]
    assert asked == [(list(range(9)), 200), *(([1] * copies, 200) for copies in (4, 16, 64))]
