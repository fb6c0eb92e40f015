"""Feedback of past valve states and of the body: what it commands, and that evolution finds the better one."""

from itertools import pairwise
from types import SimpleNamespace

import gymnasium as gym
import numpy as np
import pytest

from stickslip.studies.trade import evolution
from stickslip.studies.trade.conditions import conditions
from stickslip.studies.trade.evolution import _best, _children, _pooled, embedded, evolved_feedback, Feedback
from stickslip.studies.trade.registers import acting
from stickslip.studies.trade.rollouts import runs_of

RANDOM = np.random.default_rng(0)


def test_a_command_is_the_entry_of_the_past_and_of_what_the_body_does():
    tables, thresholds = RANDOM.integers(0, 2, (6, 16)), RANDOM.normal(0.3, 0.5, (6, 2))
    act = Feedback(tables, thresholds).acting()
    environment = gym.make_vec("stickslip:StickSlipCrawler-v0", 6, dither=0.3, max_episode_steps=None)
    observations, _ = environment.reset(seed=0)
    valves = [np.zeros(6, int)] * 2
    for k in range(50):
        command = act(k, observations)
        for i in range(6):
            stretched, fast = observations[i, 0] > thresholds[i, 0], observations[i, 1] > thresholds[i, 1]
            assert command[i] == tables[i, valves[-1][i] + 2 * valves[-2][i] + 4 * stretched + 8 * fast]
        observations, _, _, _, infos = environment.step(command)
        valves.append(infos["valve"])


def test_a_register_is_the_same_among_more_bits_whatever_the_body_does():
    table = "1101010011110100"
    settings, seeds = conditions(), (3, 4)
    feedback = Feedback(np.tile(embedded(table, 5), (2, 1)), np.array([[0.2, 0.1], [-0.3, 0.5]]))
    commands, valves = runs_of(feedback.acting(), 1, settings, seeds=seeds, holds=200)(4)
    register = acting(np.tile([int(letter) for letter in table], (2, 1)))
    expected = runs_of(register, 1, settings, seeds=seeds, holds=200)(4)
    assert np.array_equal((commands, valves), expected)
    assert commands.shape == (1, 200)


def test_children_differ_from_their_parents_and_keep_their_shape():
    parents = Feedback(RANDOM.integers(0, 2, (3, 64)), np.zeros((3, 2)))
    born = _children(parents, 50, RANDOM)
    distances = np.abs(born.tables[:, None] - parents.tables).sum(axis=2).min(axis=1)
    assert born.tables.shape == (50, 64)
    assert set(np.unique(born.tables)) == {0, 1}
    assert 0 < distances.mean() < 16
    assert np.all(born.thresholds != 0.0)


def test_the_lucky_of_short_runs_give_way_to_the_good_of_long_ones():
    lucky, good = [0.50, 3.2, 600.0], [0.50, 3.1, 12_000.0]
    scores = np.array([lucky] * 40 + [good] * 14)
    assert _best(scores).tolist() == list(range(40, 54))


def test_evolution_goes_beyond_what_it_begins_from():
    found = evolved_feedback(
        bits=3, generations=1, children=60, begin=["11111111"], seeds=1, holds=1500, screening_holds=200, threads=1
    )
    speeds, memories = found.front.points.T
    assert found.front.names == tuple(map(str, range(len(found.feedback))))
    assert speeds.max() > 0.2  # held open crawls at 0.11
    assert memories.max() > 3.5
    assert found.hypervolume.mean > 0.106 * 4.0


def test_two_runs_count_as_one_of_all_their_holds():
    pooled = _pooled(np.array([[0.5, 3.0, 600.0], [0.1, 2.0, 10.0]]), np.array([[0.2, 1.2, 1200.0], [0.3, 4.0, 30.0]]))
    np.testing.assert_allclose(pooled, [[0.3, 1.8, 1800.0], [0.25, 3.5, 40.0]])


def test_those_kept_run_again_and_no_run_meets_the_flips_of_another(monkeypatch):
    runs = []

    def rolled(acting, count, holds, settings, *, seed, threads):
        assert (settings.dither, threads) == (0.2, 1)
        acting(slice(0, count))(0, np.zeros((count, 8)))
        runs.append((count, holds, seed))
        return SimpleNamespace(speeds=np.linspace(0.2, 0.4, count), memories=np.full(count, 3.0))

    monkeypatch.setattr(evolution, "roll_out_many", rolled)
    asked = {"bits": 2, "generations": 2, "children": 8, "begin": ["1101"], "seeds": 1, "holds": 1000, "threads": 1}
    first, again, other = (
        evolved_feedback(**asked, screening_holds=200, dither=0.2, seed=seed).feedback for seed in (7, 7, 8)
    )
    np.testing.assert_array_equal(first.thresholds, again.thresholds)
    assert not np.isin(first.thresholds, other.thresholds).any()
    assert runs[: len(runs) // 3] == runs[len(runs) // 3 : 2 * len(runs) // 3]
    of_one = runs[: len(runs) // 3]
    # Those it begins from, "1101", "0" and "1", three times; then each generation's children, and with them all again.
    assert [run[:2] for run in of_one] == [(3, 400)] * 3 + [(8, 200), *[(11, 400)] * 3, (8, 200), *[(19, 400)] * 3]
    flips = sorted((seed, seed + count) for count, _, seed in of_one)
    assert flips[0][0] > 2_000_000 + 1_000_000  # what judges is below
    assert all(end <= begin for (_, end), (begin, _) in pairwise(flips))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"seed": -1}, "seed must be a whole number >= 0, got -1"),
        ({"bits": 0}, "bits must be a whole number"),
        ({"generations": 0}, "generations must be a whole number"),
        ({"dither": 0.0}, r"dither must be in \(0, 0.5\]"),
    ],
)
def test_what_cannot_evolve_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        evolved_feedback(**wrong)
