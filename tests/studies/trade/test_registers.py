"""Registers: commands from past valve states, all of them, and their front."""

import gymnasium as gym
import numpy as np
import pytest

from stickslip.studies.trade import best_registers
from stickslip.studies.trade.registers import acting, register_runs, simple_registers, tables_of

RANDOM = np.random.default_rng(0)


def test_there_is_one_table_for_each_function_of_the_past():
    tables = tables_of(2)
    assert tables.shape == (16, 4)
    assert len({tuple(table) for table in tables.tolist()}) == 16
    assert tables[6].tolist() == [0, 1, 1, 0]


def test_a_command_is_the_tables_entry_for_the_last_valve_states():
    tables = RANDOM.integers(0, 2, (5, 8))
    commands, valves = register_runs(tables, 0.2, 300, seed=7)
    flips = RANDOM.__class__(np.random.PCG64(7)).random(300) < 0.2
    for table, command, valve in zip(tables.tolist(), commands.tolist(), valves.tolist(), strict=True):
        for k in range(300):
            newest, middle, oldest = (valve[k - i] if k >= i else 0 for i in (1, 2, 3))
            assert command[k] == table[newest + 2 * middle + 4 * oldest]
            assert valve[k] == (1 - command[k] if flips[k] else command[k])


def test_in_the_environment_they_do_the_same():
    tables = RANDOM.integers(0, 2, (3, 16))
    environment = gym.make_vec("stickslip:StickSlipCrawler-v0", 3, dither=0.2, max_episode_steps=None)
    observations, _ = environment.reset(seed=[7, 7, 7])
    act = acting(tables)
    commands, valves = register_runs(tables, 0.2, 60, seed=7)
    for k in range(60):
        command = act(k, observations)
        observations, _, _, _, infos = environment.step(command)
        assert command.tolist() == commands[:, k].tolist()
        assert infos["valve"].tolist() == valves[:, k].tolist()


def test_the_front_of_one_bit_has_the_valve_held_open():
    found = best_registers(1, seeds=2, holds=1500, screening_holds=200, threads=1)
    assert found.speeds.shape == (4,)
    assert "11" in found.front.names
    i = found.front.names.index("11")
    assert found.front.memories[i].mean() == pytest.approx(3.98, abs=0.4)
    assert found.front.memories[i].mean() == found.front.memories.mean(axis=1).max()


@pytest.mark.slow
def test_the_knee_is_that_of_independent_code():
    speeds, memories = best_registers(4).front.points.T
    assert np.any((speeds > 0.74) & (memories > 3.1))


@pytest.mark.parametrize(("bits", "message"), [(0, "bits must be a whole number"), (5, "bits must be a whole number")])
def test_registers_that_are_not_tried_are_refused(bits, message):
    with pytest.raises(ValueError, match=message):
        best_registers(bits)


def test_what_begins_above_a_floor_has_the_most_memory_of_the_registers_as_fast():
    found = simple_registers({"dither": 0.1, "valve_history": 4, "memory_weight": 0.3})
    shown = np.zeros((8, 8), np.float32)
    shown[:, 4:7] = np.arange(8)[:, np.newaxis] >> np.arange(3) & 1
    tables = {floor: "".join(map(str, found.above(floor)(shown))) for floor in (0.05, 0.2, 0.69, 0.9)}
    # As docs/trade_limits.md has them: held open; the stroke; the most memory of those that walk; the fastest of all.
    assert tables == {0.05: "11111111", 0.2: "01010100", 0.69: "11111100", 0.9: "11010100"}


def test_a_register_sees_no_more_than_is_shown():
    command = simple_registers({"dither": 0.1}).above(0.05)
    assert command(np.array([[9, 9, 9, 9, 0], [9, 9, 9, 9, 1]], np.float32)).tolist() == [1, 1]
