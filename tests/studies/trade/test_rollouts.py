"""Scores of controllers in the batched environment."""

import gymnasium as gym
import numpy as np
import pytest

from stickslip.studies.trade.conditions import conditions
from stickslip.studies.trade.rollouts import arguments_of, roll_out_many, runs_of, WASHOUT


def open_and_shut(part):
    return lambda k, observations: np.arange(part.start, part.stop) % 2


def test_scores_are_means_of_what_the_environment_tells():
    found = roll_out_many(open_and_shut, 4, 300, conditions(), seed=5, threads=1)
    environment = gym.make_vec("stickslip:StickSlipCrawler-v0", 4, max_episode_steps=None)
    environment.reset(seed=5)
    told = [environment.step(np.arange(4) % 2)[4] for _ in range(WASHOUT + 300)][WASHOUT:]
    speeds, memories, squares = (
        np.mean([each[name] ** power for each in told], axis=0)
        for name, power in (("speed", 1), ("memory", 1), ("innovation", 2))
    )
    assert found.speeds == pytest.approx(speeds, rel=1e-12)
    assert found.memories == pytest.approx(memories / (squares / 0.09), rel=1e-12)


def test_errors_are_those_of_another_run():
    found = roll_out_many(open_and_shut, 200, 1000, conditions(), threads=1)
    for values, errors in ((found.speeds, found.speed_errors), (found.memories, found.memory_errors)):
        for kind in (0, 1):
            assert errors[kind::2].mean() == pytest.approx(values[kind::2].std(), rel=0.3)


def test_without_flips_there_is_no_memory():
    found = roll_out_many(open_and_shut, 2, 200, conditions(dither=0.0), threads=1)
    assert found.memories.tolist() == [0.0, 0.0]


def test_runs_are_of_each_policy_and_seed():
    runs = runs_of(lambda k, _: np.repeat([0, 1, 1], 2), 3, conditions(dither=0.3), seeds=(4, 9), holds=50)
    commands, valves = runs(9)
    flips = np.random.default_rng(9).random(50) < 0.3
    assert commands.tolist() == [[0] * 50, [1] * 50, [1] * 50]
    assert np.array_equal(valves, commands ^ flips)


def test_every_argument_of_the_environment_is_handed_on():
    given = {"hold": 0.7, "dither": 0.2, "delays": 7, "target": "parity", "target_order": 3, "valve_history": 4}
    settings = conditions(groups="high-damping", scene={"slope": 0.01}, tolerance=1e-5, virtual_nodes=2, **given)
    assert gym.make_vec("stickslip:StickSlipCrawler-v0", 2, **arguments_of(settings)).unwrapped.settings == settings
    assert {name: getattr(settings, name) for name in given} == given
