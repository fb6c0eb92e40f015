"""What registers do without flips, and the most memory of each kind."""

import numpy as np
import pytest

from stickslip.reservoir import Estimate
from stickslip.studies.trade.conditions import conditions
from stickslip.studies.trade.gap import gap, KINDS, kinds_of, mixed_runs
from stickslip.studies.trade.judgement import Judgement
from stickslip.studies.trade.registers import register_runs, Registers, tables_of


def test_what_a_register_does_is_what_it_does_from_every_past():
    tables = tables_of(3)
    kinds = kinds_of(tables)
    for table, kind in zip(tables.tolist(), kinds.tolist(), strict=True):
        ends = set()
        for past in range(8):
            valves = []
            for _ in range(40):
                valves.append(table[past])
                past = (2 * past + table[past]) % 8
            ends.add("rests" if len(set(valves[-16:])) == 1 else "walks")
        assert KINDS[kind] == (ends.pop() if len(ends) == 1 else "either")
    assert set(kinds.tolist()) == {0, 1, 2}


def test_a_mixture_is_each_register_in_its_blocks():
    settings = conditions(dither=0.2)
    first, second = "0110", "1001"
    commands, valves = mixed_runs(first, second, [1000, 30], settings, 200)(5)
    alone, _ = register_runs(np.array([[0, 1, 1, 0]]), 0.2, 200, 5)
    assert np.array_equal(commands[0], alone[0])
    for k in range(200):
        past = (valves[1, k - 1] if k > 0 else 0) + 2 * (valves[1, k - 2] if k > 1 else 0)
        assert commands[1, k] == int((first, second)[k // 30 % 2][past])


def test_the_best_of_each_kind_is_at_least_as_fast_and_judged():
    nothing = Judgement((), np.zeros((0, 1)), np.zeros((0, 1)), (0,), 1)
    settings = conditions()
    speeds, memories = np.full(16, 0.3), np.arange(16.0)
    speeds[15] = 0.11
    every = Registers(settings, 2, speeds, memories, nothing, Estimate(0.0, 0.0, 0.0, 1))
    found = gap(every, (0.05, 0.25), seeds=1, holds=1500, threads=1)
    kinds = dict(zip(("".join(map(str, t)) for t in tables_of(2).tolist()), kinds_of(tables_of(2)), strict=True))
    for kind, names in found.chosen.items():
        assert all(name is None or KINDS[kinds[name]] == kind for name in names)
    assert found.chosen["rests"][0] == "1111"
    assert found.judgement.speeds.shape == (len(found.judgement.names), 1)


def test_blocks_of_nothing_are_refused():
    with pytest.raises(ValueError, match="blocks must be a whole number >= 1"):
        mixed_runs("01", "10", [0], conditions(), 10)
