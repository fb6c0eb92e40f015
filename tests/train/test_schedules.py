"""Open-loop schedules: the words, what they come to, and their front."""

import numpy as np
import pytest

from stickslip.crawler import Groups, Scene, simulate
from stickslip.reservoir import memory_capacity, target_series
from stickslip.tasks import body_states, innovation
from stickslip.train.schedules import necklaces, pareto_front, performance, performances, repeat


def moreau(n):
    """Number of Lyndon words of n bits: sum over d | n of mobius(n / d) 2^d, over n."""
    mobius = {1: 1, 2: -1, 3: -1, 4: 0, 5: -1, 6: 1, 7: -1, 8: 0, 9: 0}
    return sum(mobius[n // d] * 2**d for d in range(1, n + 1) if n % d == 0) // n


def test_there_is_one_word_for_each_schedule():
    words = list(necklaces(9))
    assert [sum(len(word) == n for word in words) for n in range(1, 10)] == [moreau(n) for n in range(1, 10)]
    endless = {min((word * 2520)[shift : shift + 2520] for shift in range(len(word))) for word in words[:40]}
    assert len(endless) == 40


def test_words_are_written_with_the_ones_in_front_and_the_shorter_come_first():
    assert list(necklaces(4)) == ["1", "0", "10", "110", "100", "1110", "1100", "1000"]
    assert all(word == max(word[shift:] + word[:shift] for shift in range(len(word))) for word in necklaces(8))


@pytest.mark.parametrize("longest", [0, 1.0])
def test_a_length_that_is_none_is_refused(longest):
    with pytest.raises((ValueError, TypeError), match=f"longest must be a whole number >= 1, got {longest}"):
        list(necklaces(longest))


def test_flips_are_those_of_their_seed():
    command, valve = repeat("10", 400, dither=0.25, seed=5)
    flips = np.random.default_rng(5).random(400) < 0.25
    assert command.tolist() == [1, 0] * 200
    assert np.array_equal(valve, np.where(flips, 1 - command, command))
    assert not np.array_equal(valve, repeat("10", 400, dither=0.25, seed=6)[1])
    assert np.array_equal(repeat("10", 400, dither=0.25)[1], repeat("10", 400, dither=0.25, seed=0)[1])


@pytest.mark.parametrize(("word", "holds"), [("10", 0), ("10", 2.0)])
def test_holds_that_are_none_are_refused(word, holds):
    with pytest.raises((ValueError, TypeError), match=f"holds must be a whole number >= 1, got {holds}"):
        repeat(word, holds)


def test_a_word_is_repeated_and_flipped_at_the_rate_asked_for():
    command, valve = repeat("110", 30_000, dither=0.1, seed=3)
    assert command[:7].tolist() == [1, 1, 0, 1, 1, 0, 1]
    assert np.mean(command != valve) == pytest.approx(0.1, abs=4 * np.sqrt(0.09 / 30_000))
    assert np.array_equal(*repeat("110", 50))


@pytest.mark.parametrize("word", ["", "102", "ab"])
def test_words_of_other_letters_are_refused(word):
    with pytest.raises(ValueError, match="word must be made of 0 and 1"):
        repeat(word, 10)


def speed(word, holds):
    command, valve = repeat(word, holds)
    return performance(command, valve, dither=0.0, groups=Groups(), hold=0.5, scene=Scene()).speed


def test_the_best_open_loop_speed_is_the_one_stated():
    # Between two long runs the start from rest cancels.
    distance = speed("11100", 10_000) * 5_000 - speed("11100", 5_000) * 2_500
    assert distance / 2_500 == pytest.approx(1.0615, abs=1e-4)
    assert max(necklaces(7), key=lambda word: speed(word, 1_000)) == "11100"


CHANGES = {
    "nothing": {},
    "groups": {"groups": {"deborah": 0.8}},
    "hold": {"hold": 0.7},
    "scene": {"scene": Scene(ratchet=False, slope=0.05)},
    "delays": {"delays": 3},
    "virtual_nodes": {"virtual_nodes": 2},
    "tolerance": {"tolerance": 1e-3},
    "dither": {"dither": 0.2},
}


def by_hand(command, valve, *, dither, groups, hold, scene, delays=20, virtual_nodes=4, tolerance=1e-6):
    """Speed and memory from readings put in a row a hold, and from the message as its formula has it."""
    motion = simulate(groups, valve, hold, scene=scene, tolerance=tolerance, samples_per_hold=virtual_nodes)
    states = np.column_stack(
        [
            reading[node::virtual_nodes]
            for reading in (motion.deformation, motion.velocity, motion.pressure)
            for node in range(virtual_nodes)
        ]
    )
    message = valve - ((1 - dither) * command + dither * (1 - command))
    return motion.foot[-1] / motion.time[-1], memory_capacity(states, message, range(delays)).profile


@pytest.mark.parametrize("changed", CHANGES)
def test_every_argument_has_its_effect_on_speed_and_memory(changed):
    command, valve = repeat("110", 2000, dither=0.1, seed=2)
    usual = {"dither": 0.1, "groups": Groups(), "hold": 0.5, "scene": Scene()}
    asked = usual | CHANGES[changed]
    result = performance(command, valve, **asked)
    speed, profile = by_hand(command, valve, **asked)
    assert result.speed == pytest.approx(speed, rel=1e-12)
    np.testing.assert_allclose(result.memory.profile, profile, rtol=0, atol=1e-9)
    if changed != "nothing":
        before = performance(command, valve, **usual)
        assert (result.speed, result.memory.profile.tolist()) != (before.speed, before.memory.profile.tolist())


@pytest.mark.parametrize("dither", [-0.1, 0.6, float("nan")])
def test_a_dither_that_is_no_probability_is_refused(dither):
    command = np.array([1, 0])
    with pytest.raises(ValueError, match=r"dither must be in \[0, 0.5\]"):
        performance(command, command, dither=dither, groups=Groups(), hold=0.5, scene=Scene())


def test_memory_is_measured_where_there_are_flips_only():
    arguments = {"groups": Groups(), "hold": 0.5, "scene": Scene()}
    command, valve = repeat("0", 4000, dither=0.1, seed=1)
    shut = performance(command, valve, dither=0.1, **arguments)
    assert shut.memory.corrected > 3.0
    assert performance(command, command, dither=0.0, **arguments).memory is None
    assert performance(command, command, dither=0.0, **arguments).speed == 0.0


def test_the_front_holds_what_nothing_beats():
    points = np.array([[0.0, 3.0], [1.0, 2.0], [1.0, 1.0], [0.5, 2.0], [2.0, 0.0], [0.0, 3.0]])
    assert points[pareto_front(points)].tolist() == [[2.0, 0.0], [1.0, 2.0], [0.0, 3.0]]


def test_of_no_points_there_is_no_front():
    front = pareto_front(np.empty((0, 2)))
    assert (front.shape, front.dtype) == ((0,), np.int64)


def test_every_point_is_beaten_by_or_on_the_front():
    points = np.random.default_rng(0).random((200, 2))
    front = points[pareto_front(points)]
    for point in points:
        assert any((corner >= point).all() for corner in front)
    for corner in front:
        assert not any((point >= corner).all() and (point > corner).any() for point in points)


def test_many_schedules_come_to_what_each_comes_to_alone():
    settings = {"dither": 0.1, "groups": Groups(), "hold": 0.5, "scene": Scene(), "delays": 5}
    commands, valves = (
        np.array(each)
        for each in zip(*(repeat(word, 400, dither=0.1, seed=3) for word in ("1", "10", "11100")), strict=True)
    )
    many = performances(commands, valves, **settings)
    for command, valve, one in zip(commands, valves, many, strict=True):
        motion = simulate(Groups(), valve, 0.5, samples_per_hold=4, tolerance=1e-6)
        assert one.speed == motion.foot[-1] / 200.0
        alone = memory_capacity(body_states(motion), innovation(valve, command, 0.1), 5)
        np.testing.assert_array_equal(one.memory.profile, alone.profile)
    assert [one.memory for one in performances(commands, commands, **settings | {"dither": 0.0})] == [None] * 3


@pytest.mark.parametrize(("target", "order", "read_out"), [("parity", 2, 5), ("parity", 3, 5), ("narma", 4, 1)])
def test_the_memory_is_the_capacity_for_the_target(target, order, read_out):
    command, valve = repeat("11100", 1500, dither=0.3, seed=3)
    settings = {"dither": 0.3, "groups": Groups(), "hold": 0.5, "scene": Scene(), "delays": 5}
    found = performance(command, valve, **settings, target=target, target_order=order)
    states = body_states(simulate(Groups(), valve, 0.5, samples_per_hold=4, tolerance=1e-6))
    message = target_series(innovation(valve, command, 0.3), target, order, 0.3)
    alone = memory_capacity(states, message, read_out)
    np.testing.assert_array_equal(found.memory.profile, alone.profile)
    assert found.memory.profile.shape == (read_out,)
