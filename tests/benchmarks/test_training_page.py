"""The tables of docs/training.md are those of the results that are kept, and the results say what the page says."""

import json
from pathlib import Path

import learning_curves
import numpy as np
import ppo_speed
from measuring import refreshed

PAGE = Path(learning_curves.PAGE).read_text(encoding="utf-8")


def test_the_tables_are_those_of_the_results():
    curves, speed = (json.loads(each.RESULTS.read_text(encoding="utf-8")) for each in (learning_curves, ppo_speed))
    made = {"learning": learning_curves.table(curves), **ppo_speed.tables(speed)}
    assert refreshed(PAGE, made) == PAGE


def test_every_algorithm_learned_and_over_a_dummy_what_it_learned_over_the_batch():
    found = json.loads(learning_curves.RESULTS.read_text(encoding="utf-8"))
    yardstick = max(found["yardsticks"].values())
    for algorithm in learning_curves.ALGORITHMS:
        native, dummy = (learning_curves.rewards(found, algorithm, way) for way in ("native", "DummyVecEnv"))
        np.testing.assert_array_equal(native, dummy)
        assert native.max(axis=1).min() > 3 * yardstick


def test_ratios_are_those_of_the_same_round():
    seconds = {"first": {0: 1.0, 1: 2.0, 2: 4.0}, "second": {0: 0.5, 1: 1.0, 2: 2.0}}
    found = ppo_speed.rates(seconds, {"first": 100, "second": 200})
    assert found["second"]["times"] == [4.0, 4.0, 4.0]
    assert found["first"]["frames per second"][1] == 50.0
