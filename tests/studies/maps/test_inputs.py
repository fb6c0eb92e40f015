"""Ensembles of inputs: a word and its flips, and their names."""

import numpy as np
import pytest

from stickslip.studies.maps import Inputs
from stickslip.tasks import dithered


def test_fair_bits_and_bits_of_a_probability_are_flips_of_a_letter():
    for text, probability in (("bits", 0.5), ("bernoulli:0.3", 0.3), ("bernoulli:0.8", 0.8)):
        valve, message = Inputs.of(text).drawn(20_000, 3)
        assert set(valve.tolist()) == {0, 1}
        error = np.sqrt(probability * (1 - probability) / 20_000)
        assert abs(valve.mean() - probability) < 4 * error
        np.testing.assert_allclose(message, valve - probability, atol=1e-15)
    assert Inputs.of(Inputs("1", 0.1)) == Inputs("1", 0.1)


def test_a_word_is_repeated_and_flipped():
    valve, message = Inputs.of("word:110").drawn(7, 0)
    assert valve.tolist() == [1, 1, 0, 1, 1, 0, 1]
    assert not message.any()
    command = np.resize([0, 0, 1, 1], 500)
    valve, message = Inputs.of("word:0011:0.1").drawn(500, 5)
    assert np.array_equal(valve, dithered(command, 0.1, 5))
    assert set(np.round(message, 12)) == {-0.9, -0.1, 0.1, 0.9}  # what flips is news, what does not hardly


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("coin", ""),
        ("bits:2", ""),
        ("bernoulli:1", r": probability must be in \(0, 1\)"),
        ("bernoulli:x", ": could not convert"),
        ("word:012", ": word must be made of 0 and 1"),
        ("word:01:0.7", r": dither must be in \[0, 0.5\], got 0.7"),
        ("word:01:0.1:3", ""),
    ],
)
def test_an_input_that_is_none_is_refused(text, reason):
    with pytest.raises(ValueError, match=f"inputs must be 'bits', .* got '{text}'{reason}"):
        Inputs.of(text)
