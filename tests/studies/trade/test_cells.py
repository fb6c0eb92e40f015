"""The work of each cell: it is asked for as the trade says, and what comes of it is told."""

from types import SimpleNamespace

import numpy as np
import pytest
from policies_by_hand import negation, policy_of_layers

from stickslip.studies.trade import cells
from stickslip.studies.trade.cells import finish, Job
from stickslip.studies.trade.judgement import Judgement
from stickslip.studies.trade.plan import Cell, CONDITIONED, JUDGED, LIMIT, OPEN_LOOP, Trade, TRAINED
from stickslip.train import distilled, training
from stickslip.train.scores import HELD_OUT, roll_outs

TRADE = Trade(
    weights=(0.0, 0.5), dithers=(0.1,), seeds=1, longest=5, resolution=9, judges=2, holds=1000, steps=7,
    env_kwargs={"hold": 0.75},
)  # fmt: skip
SEEDS = [HELD_OUT, HELD_OUT + 1]
POLICY = negation(1)
EITHER = policy_of_layers([(np.full((2, 6), 0.5), np.zeros(2))])


def judgement(names, speeds):
    return Judgement(names, np.array(speeds), np.array(speeds) + 1.0, tuple(SEEDS), 1000)


@pytest.fixture
def asked(monkeypatch):
    """What others were asked for by a cell's work."""
    calls = {}

    def called(name, result):
        return lambda *given, **named: (calls.update({name: (given, named)}), result)[1]

    limit = SimpleNamespace(
        speeds=np.array([0.5, 0.6]), seeds=tuple(SEEDS), holds=1000, grid_speed=0.7, outside=0.01, policy=None
    )
    front = SimpleNamespace(settings="settings", front=judgement(("110", "1"), [[0.5, 0.7], [0.1, 0.2]]))
    monkeypatch.setattr(cells, "speed_limit", called("limit", limit))
    monkeypatch.setattr(cells, "open_loop_front", called("open loop", front))
    monkeypatch.setattr(cells, "schedule_runs", called("runs", "runs"))
    registers = SimpleNamespace(above=called("above", "register"))
    monkeypatch.setattr(cells, "simple_registers", called("registers", registers))
    monkeypatch.setattr(cells, "judge", called("judge", judgement(("0", "1"), [[0.0, 0.0], [0.1, 0.3]])))
    monkeypatch.setattr(distilled, "distil", called("distil", EITHER))
    monkeypatch.setattr(training, "train", called("train", SimpleNamespace(best_policy="best")))
    monkeypatch.setattr(cells, "read_policy", called("read", POLICY))
    return calls


COMMON = {"seeds": 2, "holds": 1000, "threads": 1, "hold": 0.75, "dither": 0.1}


def test_a_speed_limit(asked):
    done = finish(Job(TRADE, Cell(LIMIT, 0.1)))
    assert asked["limit"] == ((), {"resolution": 9, **COMMON})
    assert done.policy is None
    told = {"speeds": [0.5, 0.6], "seeds": SEEDS, "holds": 1000, "grid speed": 0.7, "outside": 0.01}
    assert done.result == told


def test_an_open_loop_front_and_what_a_held_valve_does(asked):
    done = finish(Job(TRADE, Cell(OPEN_LOOP, 0.1)))
    assert asked["open loop"] == ((), {"longest": 5, **COMMON})
    assert asked["runs"] == ((["0", "1"], 0.1, 1000), {})
    assert asked["judge"] == ((["0", "1"], "runs", "settings"), {"seeds": tuple(SEEDS)})
    of_all = {"seeds": SEEDS, "holds": 1000}
    assert done.result == {
        "front": {
            "names": ["110", "1"],
            "speeds": [[0.5, 0.7], [0.1, 0.2]],
            "memories": [[1.5, 1.7], [1.1, 1.2]],
            **of_all,
        },
        "held": {
            "names": ["0", "1"],
            "speeds": [[0.0, 0.0], [0.1, 0.3]],
            "memories": [[1.0, 1.0], [1.1, 1.3]],
            **of_all,
        },
    }


def test_a_training_is_judged_by_no_more_than_letters(asked):
    done = finish(Job(TRADE, Cell(TRAINED, 0.1, 0.5, 3)))
    (configuration, folder), named = asked["train"]
    assert configuration == TRADE.configuration(0.1, 0.5, 3)
    assert not folder.exists()
    assert set(named) == {"judging", "begin"}
    assert named["judging"].longest_word == 1
    assert named["begin"] is None
    assert asked["read"] == (("best",), {})
    assert done == ({}, POLICY)


def test_a_training_above_a_floor_begins_as_a_register(asked):
    finish(Job(TRADE, Cell(TRAINED, 0.1, None, 3, floor=0.2)))
    (configuration, _), named = asked["train"]
    assert configuration == TRADE.configuration(0.1, None, 3, 0.2)
    assert asked["registers"] == ((configuration.env_kwargs,), {})
    assert asked["above"] == ((0.2,), {})
    assert named["begin"] == "register"


def test_a_distillation_is_of_the_cells_policies_and_seed(asked):
    done = finish(Job(TRADE, Cell(CONDITIONED, 0.1, None, 3), (POLICY, EITHER)))
    assert asked["distil"] == (((POLICY, EITHER),), {"seed": 3})
    assert done == ({}, EITHER)


@pytest.mark.parametrize("dither", [0.0, 0.1])
def test_a_policy_is_judged_in_long_episodes_and_by_what_the_first_thousand_steps_pay(dither):
    trained = policy_of_layers([(POLICY.layers[0].weight, POLICY.layers[0].bias)], {"dither": dither, "hold": 0.75})
    evaluated = {"reward": 0.3, "speed": 0.2, "memory": 1.5}
    trained = trained.scored({name: {"mean": mean} for name, mean in evaluated.items()})
    trade = Trade(weights=(0.0, 0.5), dithers=(dither,), seeds=1, judges=2, holds=1200, env_kwargs={"hold": 0.75})
    done = finish(Job(trade, Cell(JUDGED[TRAINED], dither, 0.0, 0), (trained,)))
    runs = roll_outs(trained, trained.env_kwargs, steps=1200, seeds=SEEDS)
    told = done.result
    assert told["evaluated"] == evaluated
    assert (told["seeds"], told["holds"]) == (SEEDS, 1200)
    assert told["speeds"] == [run.performance.speed for run in runs]
    for name, row in (("speeds", 0), ("memories", 1)):
        paid = [run.paid[row, :1000].mean() for run in runs]
        assert told["episodes"][name] == pytest.approx(paid, rel=1e-12)
    if dither:
        assert told["memories"] == [run.performance.memory.corrected for run in runs]
        # Its flips are fed back to its valve: with the feedback cut less is left, but not nothing.
        assert all(0.5 < body < own for body, own in zip(told["body memories"], told["memories"], strict=True))
    else:
        assert told["memories"] == [0.0, 0.0]
        assert "body memories" not in told


def test_a_policy_for_all_weights_is_judged_at_one(monkeypatch):
    seen = []

    def rolled(policy, *given, **named):
        seen.append((policy, given, named))
        raise InterruptedError

    monkeypatch.setattr(cells, "roll_outs", rolled)
    description = EITHER.description | {"conditioned": True, "observation_space": {"type": "Box", "shape": [5]}}
    every = type(EITHER)(EITHER.layers, description)
    with pytest.raises(InterruptedError):
        finish(Job(TRADE, Cell(JUDGED[CONDITIONED], 0.1, 0.25, 0), (every,)))
    [(policy, given, named)] = seen
    assert policy.env_kwargs["memory_weight"] == 0.25
    assert (given, named) == ((every.env_kwargs,), {"steps": 1000, "seeds": tuple(SEEDS)})
