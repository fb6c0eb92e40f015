"""What is warned of is told, once, and to whoever asked."""

import warnings
from concurrent.futures import ThreadPoolExecutor

import pytest

from stickslip.explore.hearing import heard


def warned(number):
    if number % 2:
        warnings.warn(f"number {number}\n  is odd", RuntimeWarning, stacklevel=1)
        warnings.warn("again", stacklevel=1)
    return number


def test_the_first_warning_is_a_sentence_and_none_is_left():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert heard(lambda: warned(4)) == (4, "")
        assert heard(lambda: warned(5)) == (5, "number 5 is odd")
        with pytest.raises(RuntimeWarning):
            warned(5)
    with pytest.raises(ZeroDivisionError):
        heard(lambda: 1 / 0)
    assert heard(lambda: 7) == (7, "")


def test_threads_hear_their_own():
    with ThreadPoolExecutor(4) as workers:
        found = list(workers.map(lambda number: heard(lambda: warned(number)), range(200)))
    assert found == [(number, f"number {number} is odd" if number % 2 else "") for number in range(200)]
