import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.crawler import Groups, simulate
from stickslip.tasks import encode, ENCODINGS, pulse_width, sigma_delta, threshold

UNIT = st.floats(0.0, 1.0)
SERIES = st.lists(UNIT, min_size=1, max_size=40)


def test_a_threshold_by_hand():
    np.testing.assert_array_equal(threshold([0.0, 0.49, 0.5, 1.0]), [0, 0, 1, 1])
    np.testing.assert_array_equal(threshold([0.2, 0.9], 2, level=0.1), [1, 1, 1, 1])


def test_a_pulse_width_is_the_sample_itself():
    np.testing.assert_array_equal(pulse_width([0.25, 1.0], 2), [0.25, 0.25, 1.0, 1.0])


def test_a_sigma_delta_by_hand():
    """A quarter opens one hold of four, the first when half a hold is owing."""
    np.testing.assert_array_equal(sigma_delta([0.25, 0.25], 4), [0, 1, 0, 0, 0, 1, 0, 0])
    np.testing.assert_array_equal(sigma_delta([0.0, 1.0], 3), [0, 0, 0, 1, 1, 1])


def test_the_holds_of_a_sample_by_default():
    assert [len(encoding([0.5, 0.5])) for encoding in (threshold, pulse_width, sigma_delta)] == [2, 2, 16]
    np.testing.assert_array_equal(sigma_delta([0.3], 8), sigma_delta([0.3]))
    np.testing.assert_array_equal(threshold([0.0, 0.3, 1.0], level=1.0), [0, 0, 1])
    np.testing.assert_array_equal(threshold([0.0, 0.3, 1.0], level=0.0), [1, 1, 1])
    assert list(ENCODINGS) == ["threshold", "pulse_width", "sigma_delta"]


@given(SERIES, st.integers(1, 9))
def test_what_a_sigma_delta_lets_in_follows_the_series_to_half_a_hold(series, holds):
    schedule = sigma_delta(series, holds)
    assert set(schedule.tolist()) <= {0, 1}
    owing = np.cumsum(np.repeat(series, holds) - schedule)
    assert np.abs(owing).max() <= 0.5 + 1e-12
    shares = schedule.reshape(len(series), holds).mean(axis=1)
    assert np.abs(shares - series).max() <= 1.0 / holds + 1e-12


@given(SERIES, st.sampled_from(sorted(ENCODINGS)), st.integers(1, 4))
def test_every_encoding_is_causal_and_repeatable(series, encoding, holds):
    """The schedule of a beginning is the beginning of the schedule."""
    schedule = encode(series, encoding, holds)
    assert schedule.shape == (len(series) * holds,)
    for count in range(1, len(series)):
        np.testing.assert_array_equal(encode(series[:count], encoding, holds), schedule[: count * holds])


@given(st.lists(st.integers(0, 1), min_size=1, max_size=20), st.sampled_from(sorted(ENCODINGS)))
def test_bits_pass_as_they_are(bits, encoding):
    np.testing.assert_array_equal(encode(bits, encoding, 1), bits)


def test_a_body_much_slower_than_the_holds_feels_only_the_mean():
    """Pulse width and sigma-delta then bring the lag's pressure to the value they stand for, a threshold does not."""
    slow, value, hold = Groups(deborah=50.0), 0.3, 0.1
    for encoding, reached in (("pulse_width", value), ("sigma_delta", value), ("threshold", 0.0)):
        valve = encode(np.full(1000, value), encoding, 8)
        assert simulate(slow, valve, hold).pressure[-1] == pytest.approx(reached, abs=2e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: threshold([0.5, 1.5]), r"series must be in \[0, 1\], got 1.5 at index 1"),
        (lambda: pulse_width([-0.1]), r"series must be in \[0, 1\], got -0.1 at index 0"),
        (lambda: sigma_delta([np.nan]), r"series must be finite, got nan at index \(0,\)"),
        (lambda: sigma_delta([]), r"series must be 1-dimensional and not empty, got shape \(0,\)"),
        (lambda: sigma_delta([0.5], 0), "holds_per_sample must be a whole number >= 1, got 0"),
        (lambda: threshold([0.5], level=2), r"level must be in \[0, 1\], got 2"),
        (lambda: encode([0.5], "morse", 1), r"encoding must be one of \['threshold', .*\], got 'morse'"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ValueError, match=message):
        call()
