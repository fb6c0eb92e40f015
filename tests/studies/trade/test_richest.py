"""The gain of closed over open loop at places of a map."""

import numpy as np
import pytest

from stickslip.crawler import Groups, Scene
from stickslip.studies.trade.judgement import jackknifed, joined, Judgement
from stickslip.studies.trade.richest import Place, richest
from stickslip.train.schedules import performance, repeat

BODY = {"groups": Groups(), "hold": 0.5, "scene": Scene()}


def judgement(points, seeds=(1, 2, 3), spread=0.0):
    noise = spread * np.random.default_rng(len(points)).normal(size=(2, len(points), len(seeds)))
    speeds, memories = np.array(points, float).T[:, :, None] + noise
    return Judgement(tuple(map(str, points)), speeds, memories, seeds, 1000)


def test_the_gain_is_the_share_by_which_the_area_grows():
    place = Place({}, judgement([(1.0, 1.0), (0.5, 2.0)]), judgement([(0.8, 2.0)]))
    assert place.gain.mean == pytest.approx(1.8 / 1.5 - 1.0)
    assert place.added.mean == pytest.approx(0.3)


def test_registers_that_are_dominated_gain_nothing():
    assert Place({}, judgement([(1.0, 1.0)]), judgement([(0.9, 0.9)])).gain.mean == 0.0


def test_a_number_of_the_mean_points_has_the_interval_of_a_mean():
    one = judgement([(2.0, 1.0)], tuple(range(50)), 0.1)
    found = jackknifed(lambda points: float(points[0, 0]), one)
    assert found.mean == pytest.approx(one.speeds.mean())
    assert found.high - found.mean == pytest.approx(2.01 * one.speeds.std(ddof=1) / np.sqrt(50), rel=0.02)


def test_judgements_of_other_seeds_are_not_joined():
    with pytest.raises(ValueError, match="judgements must have the same seeds and holds"):
        joined(judgement([(1.0, 1.0)]), judgement([(1.0, 1.0)], (1, 2, 4)))


def test_a_place_has_the_fronts_of_its_conditions():
    [(index, found)] = richest([{"dither": 0.3}], longest=2, bits=1, seeds=1, holds=1500, screening_holds=200)
    assert (index, found.env_kwargs) == (0, {"dither": 0.3})
    word = next(name for name in found.open_loop.names if set(name) <= {"0", "1"})
    alone = performance(*repeat(word, 1500, dither=0.3, seed=found.open_loop.seeds[0]), dither=0.3, **BODY)
    assert alone.memory.corrected == found.open_loop.memories[found.open_loop.names.index(word)][0]
    assert found.registers.seeds == found.open_loop.seeds
    assert found.gain.mean >= 0.0


@pytest.mark.slow
def test_with_the_liveliest_presets_registers_add_more_than_by_default():
    found = dict(richest([{"groups": name} for name in ("ecoflex-00-30", "fast-valve", "low-friction")]))
    assert found[1].added.low > found[0].added.high
    assert found[2].added.low > found[0].added.high
