"""The memory reward beside the memory there is, and whose memory it is."""

import numpy as np
import pytest

from stickslip.reservoir import memory_capacity
from stickslip.studies.trade.adversaries import ADVERSARIES, audit, HONEST
from stickslip.studies.trade.attribution import attribute, feedback_cut
from stickslip.studies.trade.conditions import conditions
from stickslip.studies.trade.open_loop import commands_of
from stickslip.studies.trade.registers import register_runs
from stickslip.tasks import crawler_states, dithered, innovation

SOME = ("open and shut in blocks of 10", "relay of the flip 5 ago")


def test_no_adversary_earns_what_is_not_there():
    found = audit({name: ADVERSARIES[name] for name in SOME}, seeds=3, holds=1500, threads=1)
    assert found.names == SOME
    assert found.earned.shape == found.capacities.shape == (2, 3)
    for name in found.names:
        assert found.excess(name).mean < 0.15
    assert found.capacities.min() > 1.0


def test_what_there_is_is_the_capacity_of_the_run():
    found = audit({"open": HONEST["held open"]}, seeds=1, holds=1000, threads=1)
    command = np.ones(1200, np.int64)
    valve = dithered(command, 0.1, found.seeds[0])
    alone = memory_capacity(
        crawler_states(valve, tolerance=1e-6), innovation(valve, command, 0.1), 20, scoring="leave one out"
    )
    assert found.capacities[0, 0] == alone.total


def test_a_relay_commands_the_flip_of_so_many_holds_ago():
    class Batch:
        num_envs = 1

    act = ADVERSARIES["relay of the flip 5 ago"](Batch())
    flips = np.random.default_rng(0).random(40) < 0.3
    commands, observation = [], np.zeros((1, 5), np.float32)
    for k, flip in enumerate(flips.tolist()):
        commands.append(int(act(k, observation)[0]))
        observation[0, 4] = commands[-1] ^ flip
    assert commands == [0] * 5 + flips[:-5].astype(int).tolist()


def test_the_greedy_look_ahead_at_what_a_hold_earns():
    most, least = "takes what the readout earns most by", "takes what the readout earns least by"
    greedy = {name: ADVERSARIES[name] for name in (most, least)}
    found = audit({**greedy, "open": HONEST["held open"]}, seeds=1, holds=200, threads=1)
    assert found.earned[0, 0] > found.earned[1, 0] + 0.2


def test_without_flips_there_is_nothing_to_audit_or_to_attribute():
    with pytest.raises(ValueError, match=r"dither must be in \(0, 0.5\]"):
        audit(dither=0.0)
    with pytest.raises(ValueError, match=r"dither must be in \(0, 0.5\]"):
        attribute(["1"], lambda seed: (np.ones((1, 10), int),) * 2, conditions(dither=0.0), seeds=[0])


def test_a_schedule_has_no_memory_but_the_bodys_and_a_relay_has():
    settings, table = conditions(), np.array([[(past >> 3) & 1 for past in range(16)], [1] * 16])
    found = attribute(
        ["relay", "open"], lambda seed: register_runs(table, 0.1, 3000, seed), settings, seeds=[1, 2, 3, 4]
    )
    assert found.controller("open").mean == pytest.approx(0.0, abs=0.25)
    assert found.controller("relay").mean > 0.3
    assert found.body("relay").mean + found.controller("relay").mean == pytest.approx(found.closed.memory("relay").mean)


def test_commands_stay_and_flips_are_fresh():
    def runs(seed):
        commands = commands_of(["random 50%", "110"], 4000, seed)
        return commands, np.array([dithered(each, 0.1, seed) for each in commands])

    commands, valves = runs(3)
    same, fresh = feedback_cut(runs, 0.1)(3)
    assert np.array_equal(same, commands)
    both = (fresh != commands) & (valves != commands)
    assert both.mean() == pytest.approx(0.01, abs=4 * np.sqrt(0.01 / 8000))
    assert (fresh != commands).mean() == pytest.approx(0.1, abs=4 * np.sqrt(0.09 / 8000))
