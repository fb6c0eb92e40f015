import numpy as np
import pytest
from scipy import stats

from stickslip.tasks import dithered, innovation, random_bits, random_uniform


def test_random_bits_are_fair_independent_and_repeatable():
    bits = random_bits(20_000, 3)
    assert set(bits) == {0, 1}
    assert abs(bits.mean() - 0.5) < 5 * 0.5 / np.sqrt(20_000)
    assert abs(np.corrcoef(bits[1:], bits[:-1])[0, 1]) < 5 / np.sqrt(20_000)
    np.testing.assert_array_equal(bits, random_bits(20_000, 3))
    assert (bits != random_bits(20_000, 4)).any()


def test_random_numbers_are_uniform_independent_and_repeatable():
    numbers = random_uniform(20_000, 3)
    assert stats.kstest(numbers, "uniform").pvalue > 1e-4
    assert abs(np.corrcoef(numbers[1:], numbers[:-1])[0, 1]) < 5 / np.sqrt(20_000)
    np.testing.assert_array_equal(numbers, random_uniform(20_000, 3))
    assert (numbers != random_uniform(20_000, [3, 1])).all()
    assert (random_bits(64, [3, 1]) != random_bits(64, [3, 2])).any()


@pytest.mark.parametrize("seed", [3, [3, 1]])
def test_streams_are_what_numpys_generator_draws(seed):
    random = np.random.default_rng(seed)
    np.testing.assert_array_equal(random_bits(50, seed), random.integers(0, 2, 50))
    np.testing.assert_array_equal(random_uniform(50, seed), np.random.default_rng(seed).random(50))


def test_a_valve_is_the_command_with_flips():
    command = random_bits(200, 1)
    flips = np.random.default_rng(8).random(200) < 0.3
    valve = dithered(command, 0.3, 8)
    np.testing.assert_array_equal(valve, np.where(flips, 1 - command, command))
    assert valve.dtype == np.int64
    np.testing.assert_allclose(innovation(valve, command, 0.3), valve - np.where(command == 1, 0.7, 0.3))
    assert set(dithered([1.0, 0.0, True], 0.5, 0).tolist()) <= {0, 1}


@pytest.mark.parametrize("dither", [0.05, 0.1, 0.5])
def test_the_innovation_is_news(dither):
    """Zero mean, variance eps (1 - eps), and uncorrelated with a periodic command and with its own past."""
    command = np.tile([1, 1, 1, 0, 0], 20_000)
    valve = dithered(command, dither, 0)
    e = innovation(valve, command, dither)
    error = 5 / np.sqrt(len(e))
    assert abs(e.mean()) < error * e.std()
    assert e.var() == pytest.approx(dither * (1 - dither), abs=error)
    for shift in range(5):
        assert abs(np.corrcoef(e, np.roll(command, shift))[0, 1]) < error
    assert abs(np.corrcoef(e[1:], e[:-1])[0, 1]) < error


def test_innovation_by_hand():
    np.testing.assert_allclose(innovation([1, 0, 1, 0], [1, 1, 0, 0], 0.1), [0.1, -0.9, 0.9, -0.1])
    np.testing.assert_allclose(innovation([1, 0], [1, 1], 0.5), [0.5, -0.5])


def test_without_dither_the_valve_obeys():
    np.testing.assert_array_equal(dithered([0, 1, 1], 0, 0), [0, 1, 1])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: random_bits(0, 0), "length must be a whole number >= 1, got 0"),
        (lambda: random_bits(5, -1), "seed must be a whole number >= 0, got -1"),
        (lambda: random_uniform(0, 0), "length must be a whole number >= 1, got 0"),
        (lambda: random_uniform(5, [0, -1]), "seed must be a whole number >= 0, got -1"),
        (lambda: dithered([0, 1], 0.6, 0), r"dither must be in \[0, 0.5\], got 0.6"),
        (lambda: dithered([0, 2], 0.1, 0), "command must be 0 or 1, got 2 at index 1"),
        (lambda: innovation([0, 1], [0, 1], 0), r"dither must be in \(0, 0.5\], got 0"),
        (lambda: innovation([0, 1], [0], 0.1), "valve must have as many holds as command, 1, got 2"),
        (lambda: innovation([0.5], [0], 0.1), "valve must be 0 or 1, got 0.5 at index 0"),
        (lambda: innovation([[0, 1]], [0, 1], 0.1), r"valve must be 1-dimensional .* got shape \(1, 2\)"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ValueError, match=message):
        call()
