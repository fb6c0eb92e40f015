import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.tasks import narma2, narma10, parity, random_bits

UNIFORM = st.lists(st.floats(0, 0.3), min_size=1, max_size=40)


def naive_narma(u, order):
    """Dictionaries that start at zero, indexed as the papers write them."""
    y, past = dict.fromkeys(range(-20, 1), 0.0), dict.fromkeys(range(-20, 0), 0.0) | dict(enumerate(u))
    for t in range(len(u)):
        if order == 2:
            y[t + 1] = 0.4 * y[t] + 0.4 * y[t] * y[t - 1] + 0.6 * past[t] ** 3 + 0.1
        else:
            total = sum(y[t - i] for i in range(10))
            y[t + 1] = 0.3 * y[t] + 0.05 * y[t] * total + 1.5 * past[t - 9] * past[t] + 0.1
    return [y[t + 1] for t in range(len(u))]


@given(UNIFORM)
def test_narma_is_its_equation(u):
    np.testing.assert_allclose(narma2(u), naive_narma(u, 2), rtol=1e-12)
    np.testing.assert_allclose(narma10(u), naive_narma(u, 10), rtol=1e-12)


def pulses(*times):
    u = np.zeros(60)
    u[list(times)] = 0.2
    return u


def test_narma2_answers_a_pulse_at_the_entry_of_that_pulse():
    changed = np.flatnonzero(narma2(pulses(20)) != narma2(pulses()))
    assert changed[0] == 20


@pytest.mark.parametrize("gap", [1, 8, 9, 10, 11])
def test_narma10_couples_inputs_nine_apart_and_no_others(gap):
    """Ten inputs from u(t-9) to u(t): the product answers a pair of pulses at the second one."""
    changed = np.flatnonzero(narma10(pulses(20, 20 + gap)) != narma10(pulses()))
    assert changed[:1].tolist() == ([29] if gap == 9 else [])


def test_narma_on_scaled_bits_stays_bounded():
    for seed in range(5):
        u = 0.2 * random_bits(4000, seed)
        assert narma2(u).max() < 0.5
        assert narma10(u).max() < 0.5


def test_a_diverging_narma_is_refused():
    with pytest.raises(ValueError, match=r"u must be small enough for NARMA-10 .* up to 0.5, which drive y to"):
        narma10(np.full(2000, 0.5))
    with pytest.raises(ValueError, match=r"u must be small enough for NARMA-2 .* up to 2"):
        narma2(np.full(100, 2.0))


def test_bad_narma_input():
    with pytest.raises(ValueError, match=r"u must be 1-dimensional and not empty, got shape \(0,\)"):
        narma2([])
    with pytest.raises(ValueError, match=r"u must be finite, got nan at index \(1,\)"):
        narma10([0.1, np.nan])


@given(st.lists(st.integers(0, 1), min_size=1, max_size=30), st.integers(1, 5), st.integers(0, 6))
def test_parity_counts_the_ones(bits, order, delay):
    given_bits = dict(enumerate(bits))
    expected = [sum(given_bits.get(t - delay - i, 0) for i in range(order)) % 2 for t in range(len(bits))]
    np.testing.assert_array_equal(parity(bits, order, delay), expected)


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
