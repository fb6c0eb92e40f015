"""The tables of docs/training.md are those of the results that are kept, and the results say what the page says."""

import json
from pathlib import Path

import learning_curves
import numpy as np
import ppo_speed
import training_outcomes
from measuring import refreshed

PAGE = Path(learning_curves.PAGE).read_text(encoding="utf-8")


def test_the_tables_are_those_of_the_results():
    commands = learning_curves, ppo_speed, training_outcomes
    curves, speed, trained = (json.loads(each.RESULTS.read_text(encoding="utf-8")) for each in commands)
    made = {"learning": learning_curves.table(curves), **ppo_speed.tables(speed)}
    made |= training_outcomes.tables(trained["outcomes"])
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


def outcome(reward, best="held open", still=False):
    """Of a policy with this reward, where held open earns 2 and the word 3 or 1."""
    runs = {"held open": 2.0, "held shut": 0.5, "best word": 3.0 if best == "best word" else 1.0}
    return {
        "policy": {"speed": 0.25, "memory": 4.0, "reward": reward},
        **{name: {"speed": 0.0, "memory": 0.0, "reward": each} for name, each in runs.items()},
        "best baseline": best,
        "word": "110",
        "loses": reward < runs[best],
        "holds still": still,
    }


def test_outcomes_are_counted_by_weight_and_in_all(monkeypatch):
    monkeypatch.setattr(training_outcomes, "limits", lambda: {0.1: 0.8, 0.25: 0.5})
    found = {
        "0.0/0.1/0": outcome(2.5, "best word"),
        "0.0/0.1/4": outcome(3.5, "best word"),
        "1.0/0.1/0": outcome(2.0, still=True),
        "0.0/0.25/0": outcome(9.0),  # of another dither
    }
    assert training_outcomes.table_of_weights(found).splitlines()[2:] == [
        "| 0 | 0.250 ± 0.000 | 4.000 ± 0.000 | 3.000 ± 0.707 | the word 110 | 3.000 | 0 | 1 of 2 |",
        "| 1 | 0.250 | 4.000 | 2.000 | held open | 2.000 | 1 | 0 of 1 |",
        "| all | | | | | | 1 | 1 of 3 [1%, 91%] |",
    ]
    assert training_outcomes.table_of_dithers(found).splitlines()[2:] == [
        "| 0.1 | 0.250 ± 0.000 | 31.2% | 0.800 | 2 |",
        "| 0.25 | 0.250 | 50.0% | 0.500 | 1 |",
    ]


def test_a_training_takes_a_minute_of_one_processor_at_most():
    found = json.loads(training_outcomes.RESULTS.read_text(encoding="utf-8"))["outcomes"]
    assert len(found) > 70
    assert max(each["seconds"]["processor"] for each in found.values()) < 60.0


def test_seconds_are_told_of_all_threads_and_on_the_wall():
    found = {str(k): {"seconds": {"processor": 20.0 + k, "wall": 30.0 * (1 + k)}} for k in range(3)}
    assert training_outcomes.table_of_seconds(found).splitlines()[2:] == [
        "| of all threads together | 21 | 20 | 22 |",
        "| on the wall, the machine busy or not | 60 | 30 | 90 |",
    ]


def test_the_limits_are_those_of_their_page():
    page = (training_outcomes.PAGE.parent / "trade_limits.md").read_text(encoding="utf-8")
    assert all(f"| {dither:g} | {limit:.4f} [" in page for dither, limit in training_outcomes.limits().items())


def test_every_weight_is_trained_once_before_one_is_trained_again():
    order = [each.seed for each in training_outcomes.trainings()]
    assert order == sorted(order)
    cells = {(each.weight, each.dither) for each in training_outcomes.trainings() if each.seed == 0}
    assert cells == {(0.0, 0.1), (0.1, 0.1), (0.2, 0.1), (0.3, 0.1), (0.5, 0.1), (0.7, 0.1), (1.0, 0.1)} | {
        (0.0, 0.0),
        (0.0, 0.05),
        (0.0, 0.25),
    }
