"""Observation, objectives and infos each stand in one table; space, arrays, states and documentation follow it."""

import dataclasses
import inspect

import numpy as np
import pytest

from stickslip import Groups, Scene
from stickslip.crawler.model.state import Body, coefficients_of
from stickslip.envs import StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv
from stickslip.envs.infos import COUNTS, infos_of_each, NUMBERS, TOLD
from stickslip.envs.observation import OBSERVATION, observe, seen_at_rest, VALVES, valves_seen
from stickslip.envs.reward import OBJECTIVES, reward
from stickslip.envs.transition import Transition

BODY = Body(0.1, -0.2, 0.3, 1.5, 0.6, 1, 9)
STEP = Transition(1.0, BODY, coefficients_of(Groups(), Scene()), 1, 0, 0b0110, 0.25, 0.1, 0.75, 4.0)


def rows_of(section, until):
    text = inspect.getdoc(StickSlipCrawlerEnv).split(f"## {section}")[1].split(f"## {until}")[0]
    rows = [[cell.strip() for cell in line.strip("| ").split("|")] for line in text.splitlines() if line[:1] == "|"]
    return rows[2:]


def test_the_observation_is_what_the_table_says_and_the_documentation_has_a_row_for_each():
    assert [each.formula(STEP) for each in OBSERVATION] == [0.1, -0.2, 0.3, 0.6]
    assert [VALVES.formula(STEP, age) for age in range(5)] == [0, 1, 1, 0, 0]
    *rows, rest = rows_of("Observation Space", "Rewards")
    assert [int(row[0]) for row in rows] == list(range(len(OBSERVATION) + 1))
    for row, component in zip(rows, (*OBSERVATION, VALVES), strict=True):
        assert set(component.name.split("_")) <= set(row[1].replace("rate", "velocity").replace(",", "").split())
    assert rest[0] == f"{len(rows)}.."


@pytest.mark.parametrize("history", [1, 2, 64])
def test_everything_has_the_shape_of_the_table_and_the_valves_that_are_asked_for(history):
    env, envs = StickSlipCrawlerEnv(valve_history=history), StickSlipCrawlerVectorEnv(2, valve_history=history)
    answers = env.reset(seed=0)[0], env.step(1)[0], envs.reset(seed=0)[0][0], envs.step([1, 1])[0][1]
    shapes = {answer.shape for answer in answers} | {env.observation_space.shape, seen_at_rest(history).shape}
    assert shapes == {(len(OBSERVATION) + history,)}


@pytest.mark.parametrize("history", [1, 2, 63, 64])
def test_valves_are_read_back_from_an_observation(history):
    bits = np.random.default_rng(history).integers(0, 2, 64)
    bits[63] = 1  # the sign
    valves = int(np.packbits(bits, bitorder="little").view("<i8")[0])
    target = seen_at_rest(history)
    observe(target, STEP._replace(valves=valves))
    np.testing.assert_array_equal(target[len(OBSERVATION) :], bits[:history])
    np.testing.assert_array_equal(target[: len(OBSERVATION)], np.float32([0.1, -0.2, 0.3, 0.6]))
    kept = valves_seen(target)
    assert [int(kept) >> age & 1 for age in range(history)] == bits[:history].tolist()
    assert isinstance(kept, np.int64)


def test_the_reward_weighs_the_objectives():
    assert [(each.name, each.weight(STEP), each.formula(STEP)) for each in OBJECTIVES] == [
        ("speed", 0.25, 2.0),
        ("memory", 0.75, 4.0),
    ]
    assert reward(STEP) == 0.25 * 2.0 + 0.75 * 4.0


def test_the_infos_are_what_the_table_says_and_the_documentation_has_a_row_for_each():
    assert NUMBERS == ("speed", "memory", "distance", "innovation")
    assert COUNTS == ("valve", "slips")
    rows = rows_of("Information", "Arguments")
    kinds = {"float": float, "int": int, "dict of floats": dict}
    info = StickSlipCrawlerEnv().reset(seed=0)[1]
    assert {row[0].strip("`"): kinds[row[1]] for row in rows} == {name: type(value) for name, value in info.items()}
    assert [row[3] for row in rows] == ["0"] * len(TOLD) + ["the same"] * 2


def test_infos_of_each_are_those_of_a_single_environment():
    envs, constants = StickSlipCrawlerVectorEnv(3, randomize={"duffing": [0.0, 1.0]}), {"own": False}
    singles = [StickSlipCrawlerEnv(randomize={"duffing": [0.0, 1.0]}) for _ in range(3)]
    envs.reset(seed=0)
    for i, single in enumerate(singles):
        single.reset(seed=i)
    for command in (1, 1, 0):
        infos = infos_of_each(constants)(envs.step([command] * 3)[4], envs.crawlers_by_name)
        expected = [{**single.step(command)[4], "own": False} for single in singles]
        assert infos == expected
        assert [list(info) for info in infos] == [list(info) for info in expected]
    infos[0]["groups"].clear()
    assert envs.crawlers_by_name[0][0]


@pytest.mark.parametrize("name", ["observation", "told"])
def test_a_state_of_other_tables_is_refused(name):
    env = StickSlipCrawlerEnv()
    env.reset(seed=0)
    state = env.get_state()
    short = dataclasses.replace(state, **{name: getattr(state, name)[:-1]})
    with pytest.raises(ValueError, match=r"state must hold an observation of 5 and \('speed', .*, got an observation"):
        env.set_state(short)


def test_a_state_holds_what_was_seen_last():
    env, envs = StickSlipCrawlerEnv(), StickSlipCrawlerVectorEnv(2)
    for state in (env.get_state() for _ in [env.reset(seed=0)]):
        np.testing.assert_array_equal(state.observation, 0.0)
    envs.reset(seed=0)
    for command in (1, 1, 0, 0):
        seen = env.step(command)[0]
        np.testing.assert_array_equal(env.get_state().observation, seen)
        envs.step([command] * 2)
    envs.set_state([None, env.get_state()])
    shown, _ = envs.reset(options={"reset_mask": np.array([True, False])})
    np.testing.assert_array_equal(shown, [np.zeros_like(seen), seen])
