"""Targets judged by their formulas written out, and by how they are made: whoever commands, chance earns nothing."""

import numpy as np
import pytest
from plain_environment import message_of, narma

from stickslip.reservoir import delay_line, memory_capacity
from stickslip.reservoir.prequential import PrequentialMemory
from stickslip.reservoir.targets import LONGEST, target_of, target_series, TARGETS
from stickslip.tasks import narma as task_of_narma

ORDERS = range(2, LONGEST + 1)
OTHERS = [(name, order) for name in TARGETS[1:] for order in ORDERS]


def innovations(steps, dither, commands=0, seed=0):
    return (1 - 2 * commands) * ((np.random.default_rng(seed).random(steps) < dither) - dither)


@pytest.mark.parametrize(("name", "order"), [("memory", 2), *OTHERS])
def test_a_series_is_its_formula(name, order):
    e = innovations(300, 0.3, np.random.default_rng(1).integers(0, 2, 300))
    target = target_of(name, order, 0.3)
    expected, variance, lead = message_of(e, name, order, 0.3, (target.mean, target.variance))
    np.testing.assert_allclose(target_series(e, name, order, 0.3), expected, rtol=1e-12, atol=1e-14)
    assert target.variance == pytest.approx(variance, rel=1e-12)
    assert target.lead == lead


def test_the_series_of_order_five_is_the_benchmark_s():
    """Which starts from zeros: both forget where they started."""
    e = innovations(400, 0.5)
    benchmark = task_of_narma((1 + e) / 4, 5)
    series = target_series(e, "narma", 5, 0.5) + target_of("narma", 5, 0.5).mean
    np.testing.assert_allclose(series[200:], benchmark[200:], rtol=1e-12)


@pytest.mark.parametrize("dither", [0.2, 0.5])
@pytest.mark.parametrize(("name", "order"), [("memory", 2), *OTHERS])
def test_mean_and_variance_are_those_of_the_series_whoever_commands(name, order, dither):
    steps, target = 200_000, target_of(name, order, dither)
    scales = []
    for commands in (0, 1, np.arange(steps) % 3 == 0, np.random.default_rng(2).random(steps) < 0.9):
        values = target_series(innovations(steps, dither, 1 * np.asarray(commands), seed=3), name, order, dither)[100:]
        blocks = values[:199_000].reshape(199, 1000)
        means, squares = blocks.mean(axis=1), (blocks**2).mean(axis=1)
        assert abs(means.mean()) < 4.5 * means.std() / np.sqrt(199) + 0.002 * np.sqrt(target.variance)
        assert abs(squares.mean() - target.variance) < 4.5 * squares.std() / np.sqrt(199) + 0.02 * target.variance
        scales.append(squares.mean())
    if name != "narma" and dither == 0.5:
        assert np.ptp(scales) < 1e-12  # each value is the same but for its sign


@pytest.mark.parametrize("order", ORDERS)
def test_no_input_makes_a_series_grow(order):
    largest = narma(np.ones(5000), order, 0.0)
    assert 0 < largest[-1] < 2
    assert largest.max() <= largest[-1] * (1 + 1e-12)


@pytest.mark.parametrize(("name", "order"), [("parity", 2), ("parity", 3), ("narma", 3)])
def test_who_knows_nothing_earns_nothing_and_who_has_it_earns_one(name, order):
    """States of noise, of the innovations, which tell nothing of their products, and of the target itself."""
    dither, steps, delays = 0.4, 1500, 1
    target = target_of(name, order, dither)
    earned = {"noise": [], "innovations": [], "target": []}
    for seed in range(20):
        rng = np.random.default_rng(seed)
        e = innovations(steps, dither, rng.integers(0, 2, steps), seed=100 + seed)
        kinds = {
            "noise": rng.normal(size=(steps, 4)),
            "innovations": delay_line(e, 6),
            "target": np.column_stack([target_series(e, name, order, dither), rng.normal(size=steps)]),
        }
        for kind, states in kinds.items():
            memory = PrequentialMemory(states, delays, target=target)
            scores = [memory.score(state, value) for state, value in zip(states, e.tolist(), strict=True)]
            assert not any(scores[: target.lead])
            earned[kind].append(np.mean(scores[200:]))
    error = {kind: 4 * np.std(means) / np.sqrt(20) for kind, means in earned.items()}
    mean = {kind: np.mean(means) for kind, means in earned.items()}
    assert abs(mean["noise"]) < error["noise"]
    assert mean["target"] == pytest.approx(1, abs=error["target"] + 0.01)
    if name == "parity":
        assert abs(mean["innovations"]) < error["innovations"]
    else:
        offline = memory_capacity(delay_line(e, 6), target_series(e, name, order, dither), 1).corrected
        assert mean["innovations"] == pytest.approx(offline, abs=0.05)


@pytest.mark.parametrize(("name", "order"), [("parity", 3), ("narma", 5)])
@pytest.mark.parametrize("delays", [1, 8])
def test_a_packed_readout_goes_on_as_it_would_have(name, order, delays):
    e = innovations(200, 0.3)
    states = delay_line(e, 4) + 0.1 * np.random.default_rng(0).normal(size=(200, 4))
    memory, other = (PrequentialMemory(states, delays, target=target_of(name, order, 0.3)) for _ in range(2))
    for state, value in zip(states[:90], e[:90].tolist(), strict=True):
        memory.score(state, value)
    other.unpack(memory.packed(), 90)
    for state, value in zip(states[90:], e[90:].tolist(), strict=True):
        assert other.score(state, value) == memory.score(state, value)
    assert len(memory.packed()) == 4


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (("echo", 2, 0.1), ValueError, r"target must be one of \['memory', 'parity', 'narma'\], got 'echo'"),
        (("parity", 6, 0.1), ValueError, r"target_order must be a whole number in \[2, 5\], got 6"),
        (("parity", 2.0, 0.1), TypeError, r"target_order must be a whole number in \[2, 5\], got 2.0"),
        (("parity", 2, 0.0), ValueError, r"dither must be in \(0, 0.5\], got 0.0"),
    ],
)
def test_bad_input(arguments, error, message):
    with pytest.raises(error, match=message):
        target_of(*arguments)
    with pytest.raises(error, match=message):
        target_series(np.zeros(3), *arguments)
