import math
from importlib import import_module

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.tasks import narma, parity, random_bits, random_narma, random_uniform

narma_module = import_module("stickslip.tasks.narma")  # the name in the package is the function's

UNIFORM = st.lists(st.floats(0, 0.3), min_size=1, max_size=40)


def naive_narma(u, order):
    """Dictionaries that start at zero, indexed as the papers write them."""
    y, past = dict.fromkeys(range(-20, 1), 0.0), dict.fromkeys(range(-20, 0), 0.0) | dict(enumerate(u))
    for t in range(len(u)):
        if order == 2:
            y[t + 1] = 0.4 * y[t] + 0.4 * y[t] * y[t - 1] + 0.6 * past[t] ** 3 + 0.1
            continue
        total = sum(y[t - i] for i in range(order))
        common = 0.3 * y[t] + 0.05 * y[t] * total + 1.5 * past[t - order + 1] * past[t]
        y[t + 1] = math.tanh(common + 0.01) + 0.2 if order == 20 else common + 0.1
    return [y[t + 1] for t in range(len(u))]


@pytest.mark.parametrize("order", [2, 5, 10, 20])
@given(u=UNIFORM)
def test_narma_is_its_equation(order, u):
    np.testing.assert_allclose(narma(u, order), naive_narma(u, order), rtol=1e-12)


def pulses(*times):
    u = np.zeros(80)
    u[list(times)] = 0.2
    return u


def test_narma2_answers_a_pulse_at_the_entry_of_that_pulse():
    changed = np.flatnonzero(narma(pulses(20), 2) != narma(pulses(), 2))
    assert changed[0] == 20


@pytest.mark.parametrize("order", [5, 10, 20])
@pytest.mark.parametrize("off", [-1, 0, 1])
def test_narma_couples_inputs_one_less_than_its_order_apart_and_no_others(order, off):
    """As many inputs as its order, from u(t - order + 1) to u(t): the product answers a pair at the second one."""
    gap = order - 1 + off
    changed = np.flatnonzero(narma(pulses(20, 20 + gap), order) != narma(pulses(), order))
    assert changed[:1].tolist() == ([20 + gap] if off == 0 else [])


@pytest.mark.parametrize("order", [5, 10])
def test_narma_forgets_no_output_before_its_order(order):
    """A difference in y at one step alone reaches the sum for as many steps as its order."""
    base, bumped = narma(pulses(), order), narma(pulses(20, 19 + order), order)
    answer = (bumped - base)[19 + order :]
    # By the equation without input: d(t+1) = 0.3 d + 0.05 (y sum(y) - y0 sum(y0)).
    y, y0 = list(bumped), list(base)
    for t in range(19 + order, 40 + order):
        expected = 0.3 * (y[t] - y0[t]) + 0.05 * (
            y[t] * sum(y[t - order + 1 : t + 1]) - y0[t] * sum(y0[t - order + 1 : t + 1])
        )
        assert answer[t + 1 - 19 - order] == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("bits", [False, True])
@pytest.mark.parametrize("order", [2, 5, 10, 20])
def test_random_narma_gives_its_inputs_and_their_target(order, bits):
    u, y = random_narma(3000, order, 3, bits=bits)
    np.testing.assert_array_equal(y, narma(u, order))
    assert set(u) == {0.0, 0.2} if bits else (u.min() >= 0.0 and 0.49 < u.max() < 0.5)
    again = random_narma(3000, order, 3, bits=bits)
    np.testing.assert_array_equal(u, again[0])
    assert (u != random_narma(3000, order, 4, bits=bits)[0]).any()


def test_inputs_that_diverge_are_drawn_again_whole():
    """At height 0.62 about a tenth of the draws of 300 survive; those that do are the first that do."""
    height, redrawn = 0.62, 0
    for seed in range(10):
        u, y = random_narma(300, 10, seed, height=height)
        first = height * random_uniform(300, seed)
        np.testing.assert_array_equal(y, narma(u, 10))
        assert np.isfinite(y).all()
        assert u.max() <= height
        try:
            narma(first, 10)
        except ValueError:
            redrawn += 1
            assert (u != first).any()
        else:
            np.testing.assert_array_equal(u, first)
    assert redrawn > 0


@pytest.mark.parametrize(("bits", "height"), [(False, 0.62), (True, 0.6)])
def test_each_draw_anew_has_a_seed_of_its_own(bits, height):
    """The first that stays bounded of draws from seed, [seed, 1], [seed, 2] and so on."""

    def bounded(inputs):
        try:
            narma(inputs, 10)
        except ValueError:
            return False
        return True

    attempts = []
    for seed in range(8):
        draws = [(random_bits if bits else random_uniform)(200, [seed, k] if k else seed) for k in range(100)]
        found, _ = random_narma(200, 10, seed, bits=bits, height=height)
        first = next(k for k, drawn in enumerate(draws) if bounded(height * drawn))
        np.testing.assert_array_equal(found, height * draws[first])
        attempts.append(first)
    assert max(attempts) > 1


def test_a_hundred_draws_are_tried_and_no_more(monkeypatch):
    seeds = []
    drawn = narma_module.random_uniform
    monkeypatch.setattr(narma_module, "random_uniform", lambda n, seed: seeds.append(seed) or drawn(n, seed))
    with pytest.raises(ValueError, match=r"height must be small enough for NARMA-10 .* over 500 steps, got 1"):
        random_narma(500, 10, 4, height=1.0)
    assert seeds == [4, *([4, k] for k in range(1, 100))]


@pytest.mark.parametrize(("largest", "diverged"), [(9.9, False), (10.1, True)])
def test_narma_diverges_past_ten(largest, diverged):
    """Of order 2 a single input sets the next y: 0.6 u^3 + 0.1."""
    u = [((largest - 0.1) / 0.6) ** (1 / 3)]
    if diverged:
        with pytest.raises(ValueError, match=r"got values up to 2\.55436, which drive y to 10\.1 at step 0"):
            narma(u, 2)
    else:
        assert narma(u, 2)[0] == pytest.approx(largest)


def test_narma20_saturates_and_still_varies():
    y = narma(random_narma(2000, 20, 0)[0], 20)[200:]
    assert 1.1 < y.min() < y.max() < 1.2
    assert y.std() == pytest.approx(0.009, rel=0.1)


def test_a_diverging_narma_is_refused():
    with pytest.raises(ValueError, match=r"u must be small enough for NARMA-10 .* up to 0.5, which drive y to"):
        narma(np.full(2000, 0.5), 10)
    with pytest.raises(ValueError, match=r"u must be small enough for NARMA-2 .* up to 2"):
        narma(np.full(100, 2.0), 2)
    with pytest.raises(ValueError, match=r"height must be small enough for NARMA-10 .* 2000 steps, got 1"):
        random_narma(2000, 10, 0, height=1.0)


def test_bad_narma_input():
    with pytest.raises(ValueError, match=r"u must be 1-dimensional and not empty, got shape \(0,\)"):
        narma([], 2)
    with pytest.raises(ValueError, match=r"u must be finite, got nan at index \(1,\)"):
        narma([0.1, np.nan], 10)
    with pytest.raises(ValueError, match=r"order must be one of \[2, 5, 10, 20\], got 11"):
        narma([0.1], 11)
    with pytest.raises(ValueError, match=r"height must be in \(0, inf\), got 0"):
        random_narma(10, 2, 0, height=0)


@given(st.lists(st.integers(0, 1), min_size=1, max_size=30), st.integers(1, 5), st.integers(0, 6))
def test_parity_counts_the_ones(bits, order, delay):
    given_bits = dict(enumerate(bits))
    expected = [sum(given_bits.get(t - delay - i, 0) for i in range(order)) % 2 for t in range(len(bits))]
    np.testing.assert_array_equal(parity(bits, order, delay), expected)


def test_a_parity_is_of_the_latest_bits_by_default():
    np.testing.assert_array_equal(parity([1, 1, 0, 1], 2), [1, 0, 1, 1])
    np.testing.assert_array_equal(parity([1, 1, 0, 1], 1), [1, 1, 0, 1])


def test_a_delayed_parity_is_the_parity_delayed():
    bits = random_bits(50, 0)
    np.testing.assert_array_equal(parity(bits, 3, 7)[7:], parity(bits, 3)[:-7])


def test_bad_parity_input():
    with pytest.raises(ValueError, match="order must be a whole number >= 1, got 0"):
        parity([0, 1], 0)
    with pytest.raises(ValueError, match="delay must be a whole number >= 0, got -1"):
        parity([0, 1], 1, -1)
    with pytest.raises(ValueError, match="bits must be 0 or 1, got -1 at index 0"):
        parity([-1, 1], 2)
