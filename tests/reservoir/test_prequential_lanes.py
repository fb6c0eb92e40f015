"""Eight memory scores at once are to the bit what each is alone."""

import numpy as np
import pytest

from stickslip.compiling.compilation import compiled
from stickslip.compiling.vectors import aligned_zeros, LANES
from stickslip.reservoir.prequential import PrequentialMemory
from stickslip.reservoir.prequential_lanes import blank_readouts, forget, packed, readouts_of, score_lanes, unpack
from stickslip.reservoir.targets import target_of

FEATURES, DELAYS, COUNT = 3, 5, 11
NOISE = target_of("memory", 2, 0.2)


@compiled
def score_all(readouts, states, innovations, scratch):
    for block in range(readouts.weights.shape[0]):
        score_lanes(readouts, block, states, (block * states.shape[1] + 1) * LANES, LANES, innovations, scratch)


class Pair:
    """Reservoirs one by one, and in lanes."""

    def __init__(self, seed=0, lead=0):
        self.rng = np.random.default_rng(seed)
        calibrations = [self.rng.normal(size=(50, FEATURES)) * 3 + i for i in range(3)]
        self.kind = self.rng.integers(0, 3, COUNT)
        target = NOISE._replace(lead=lead)
        memories = [PrequentialMemory(each, DELAYS, target=target) for each in calibrations]
        self.single = [PrequentialMemory(calibrations[which], DELAYS, target=target) for which in self.kind]
        self.readouts = readouts_of(memories, self.kind)

    def step(self):
        states, innovations = self.rng.normal(size=(COUNT, FEATURES)) * 3, self.rng.normal(size=COUNT)
        blocks = len(self.readouts.weights)
        columns, earned = np.zeros((blocks, FEATURES + 1, LANES)), np.zeros(blocks * LANES)
        for i in range(COUNT):
            columns[i // LANES, 1:, i % LANES] = states[i]
        earned[:COUNT] = innovations
        score_all(self.readouts, columns, earned, aligned_zeros(2, FEATURES + 1, LANES))
        return earned[:COUNT].tolist(), [
            memory.score(state, e) for memory, state, e in zip(self.single, states, innovations.tolist(), strict=True)
        ]


@pytest.mark.parametrize("lead", [0, 1, 4])
def test_lanes_score_to_the_bit_what_each_does_alone(lead):
    pair = Pair(lead=lead)
    for k in range(30):
        lanes, single = pair.step()
        assert lanes == single
        assert k >= lead or not any(lanes)
    assert all(lanes)


def test_those_in_the_mask_start_again_and_the_others_go_on():
    pair = Pair(1)
    for _ in range(7):
        pair.step()
    mask = np.zeros(COUNT, np.bool_)
    mask[[0, 5, 9]] = True
    forget(pair.readouts, mask)
    for i in np.flatnonzero(mask):
        pair.single[i].reset()
    # Nothing of what was before is left, not even where it would be multiplied by zero.
    for i in range(COUNT):
        for one, each in zip(packed(pair.readouts, i), pair.single[i].packed(), strict=True):
            np.testing.assert_array_equal(one, each)
        assert packed(pair.readouts, i)[2].any() != mask[i]
    for _ in range(10):
        lanes, single = pair.step()
        assert lanes == single


def test_a_readout_goes_on_from_what_was_packed_wherever_it_lies():
    pair, other = Pair(2), Pair(3)
    for _ in range(9):
        pair.step()
        other.step()
    state = packed(pair.readouts, 9)
    for one, each in zip(state, pair.single[9].packed(), strict=True):
        np.testing.assert_array_equal(one, each)
    # To two lanes of another batch, scaled as they are, and to two readouts alone.
    unpack(other.readouts, [2, 10], state, 9)
    for i in (2, 10):
        other.single[i].unpack(state, 9)
    pair.step()
    for _ in range(10):
        lanes, single = other.step()
        assert lanes == single
    assert not np.shares_memory(state[0], pair.readouts.weights)


def test_blank_readouts_see_nothing_and_learn_nothing():
    readouts = blank_readouts(9, DELAYS, FEATURES + 1, 0.25)
    assert readouts.weights.shape == (2, DELAYS, FEATURES + 1, LANES)
    assert readouts.covariance.shape == (2, 10, LANES)
    assert readouts.past.shape == (2, DELAYS, LANES)
    assert readouts.scaling.shape == (2, 2, FEATURES, LANES)
    assert readouts.seen.shape == (16,)
    assert (readouts.variance, readouts.lead) == (0.25, 0.0)
    assert blank_readouts(8, DELAYS, FEATURES + 1, 1.0).seen.shape == (8,)
    earned = np.full(16, 0.5)
    score_all(readouts, np.ones((2, FEATURES + 1, LANES)), earned, aligned_zeros(2, FEATURES + 1, LANES))
    assert not readouts.weights.any()
    assert not readouts.covariance.any()


@pytest.mark.parametrize("seen", [0, 3])
def test_scores_begin_with_the_messages_that_were_seen(seen):
    pair = Pair(4)
    for _ in range(seen):
        pair.step()
    assert (pair.readouts.seen[:COUNT] == seen).all()
    assert (pair.readouts.past[0, seen:] == 0).all()
