"""Open-loop schedules: what is tried, what is kept, and that others judge than choose."""

import numpy as np
import pytest

from stickslip.crawler import Groups, Scene
from stickslip.studies.trade import hypervolume, open_loop_front
from stickslip.studies.trade.judgement import HELD_OUT, Judgement
from stickslip.studies.trade.open_loop import commands_of, RATES
from stickslip.train.schedules import pareto_front, performance, repeat

SETTINGS = {"dither": 0.1, "groups": Groups(), "hold": 0.5, "scene": Scene()}


def test_words_are_repeated_and_rates_are_kept():
    word, always, random = commands_of(["110", "1", "random 30%"], 20_000, seed=3)
    assert np.array_equal(word, repeat("110", 20_000)[0])
    assert always.all()
    assert random.mean() == pytest.approx(0.3, abs=4 * np.sqrt(0.21 / 20_000))
    assert not np.array_equal(random, commands_of(["random 30%"], 20_000, seed=4)[0])


@pytest.fixture(scope="module")
def found():
    return open_loop_front(longest=3, seeds=2, holds=1500, screening_holds=200, threads=1)


def test_the_front_is_judged_on_seeds_that_did_not_choose_it(found):
    front = found.front
    assert front.seeds == (HELD_OUT, HELD_OUT + 1)
    assert len(found.names) == 5 + len(RATES)
    word = next(name for name in front.names if name not in RATES)
    i = front.names.index(word)
    for m, seed in enumerate(front.seeds):
        alone = performance(*repeat(word, 1500, dither=0.1, seed=seed), **SETTINGS)
        assert front.speeds[i, m] == alone.speed
        assert front.memories[i, m] == alone.memory.corrected


def test_those_chosen_are_the_front_of_the_longest_runs(found):
    chosen = [found.names.index(name) for name in found.front.names]
    points = np.stack([found.speeds, found.memories], axis=1)[chosen]
    assert len(pareto_front(points)) == len(chosen)
    assert found.hypervolume.mean == hypervolume(found.front.points)
    assert found.hypervolume.low < found.hypervolume.mean < found.hypervolume.high


def test_the_interval_of_one_rectangle_is_that_of_a_product():
    random = np.random.default_rng(0)
    speeds, memories = random.normal(2.0, 0.1, (1, 400)), random.normal(3.0, 0.1, (1, 400))
    found = Judgement(("one",), speeds, memories, tuple(range(400)), 1000).hypervolume()
    error = np.sqrt((3.0**2 + 2.0**2) * 0.1**2 / 400)  # of a product of means, to first order
    assert found.mean == speeds.mean() * memories.mean()
    assert (found.high - found.low) / (2 * 1.966) == pytest.approx(error, rel=0.15)


def test_without_flips_the_fastest_alone_is_the_front():
    found = open_loop_front(longest=4, seeds=1, holds=1000, screening_holds=200, threads=1, dither=0.0)
    assert found.front.memories.max() == 0.0
    assert found.hypervolume.mean == 0.0
    assert len(found.front.names) == 1


@pytest.mark.slow
def test_the_front_is_that_of_independent_code():
    found = open_loop_front()
    assert found.hypervolume.mean == pytest.approx(1.839, abs=0.03)
    assert found.fastest == "11100111000"  # of the necklace of 00011100111
    assert found.front.speed(found.fastest).mean == pytest.approx(0.763, abs=0.01)
    assert found.front.memory(found.fastest).mean == pytest.approx(1.75, abs=0.03)
    speed, memory = found.front.points[found.front.names.index("1")]
    assert speed == pytest.approx(0.106, abs=0.005)
    assert memory == pytest.approx(3.98, abs=0.08)  # which the readouts of shorter runs come to
