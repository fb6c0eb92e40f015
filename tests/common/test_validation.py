"""Every refusal, word for word, and both sides of every edge."""

import re

import numpy as np
import pytest

from stickslip.common.validation import finite_array, known_names, number_within, truth_value, whole_number


def refuses(error, text):
    return pytest.raises(error, match=f"^{re.escape(text)}$")


@pytest.mark.parametrize(
    ("value", "ndim", "error", "text"),
    [
        ("abc", 1, TypeError, "x must be an array of real numbers, got 'abc'"),
        ([[1.0], [2.0, 3.0]], 2, TypeError, "x must be an array of real numbers, got [[1.0], [2.0, 3.0]]"),
        ([1j], 1, TypeError, "x must be an array of real numbers, got [1j]"),
        (None, 1, ValueError, "x must be 1-dimensional and not empty, got shape ()"),
        ([1.0], 2, ValueError, "x must be 2-dimensional and not empty, got shape (1,)"),
        ([[]], 2, ValueError, "x must be 2-dimensional and not empty, got shape (1, 0)"),
        ([], (1, 2), ValueError, "x must be 1-dimensional or 2-dimensional and not empty, got shape (0,)"),
        (3.0, (1, 2), ValueError, "x must be 1-dimensional or 2-dimensional and not empty, got shape ()"),
        ([0.0, np.nan, np.inf], 1, ValueError, "x must be finite, got nan at index (1,)"),
        (
            np.ma.array([0.0, 1.0, 1.0], mask=[0, 0, 1]),
            1,
            ValueError,
            "x must have no masked entries, got one at index (2,)",
        ),
        ([[0.0, 1.0], [2.0, -np.inf]], (1, 2), ValueError, "x must be finite, got -inf at index (1, 1)"),
    ],
)
def test_what_is_no_finite_array_is_refused(value, ndim, error, text):
    with refuses(error, text):
        finite_array("x", value, ndim)


def test_a_finite_array_is_of_doubles_and_no_copy_where_it_need_not_be():
    given = np.array([1.0, 2.0])
    assert finite_array("x", given, 1) is given
    for value in ([1, 2], (True, 2), np.array([1, 2], dtype=np.float32)):
        found = finite_array("x", value, (1, 2))
        assert found.dtype == np.float64
        assert found.tolist() == [1.0, 2.0]
    assert finite_array("x", [[1], [2]], (1, 2)).shape == (2, 1)


def test_unknown_names_are_refused():
    known_names("colour", ["red", "blue"], ["blue", "green", "red"])
    known_names("colour", [], [])
    with refuses(ValueError, "colour has no 'pink'; allowed are ['red', 'blue']"):
        known_names("colour", ["red", "pink"], iter(["red", "blue"]))


@pytest.mark.parametrize("value", [True, False, np.True_, np.False_])
def test_a_truth_value_is_pythons(value):
    assert type(truth_value("flag", value)) is bool
    assert truth_value("flag", value) == bool(value)


@pytest.mark.parametrize("value", [0, 1, 1.0, "True", None, [True]])
def test_what_is_no_truth_value_is_refused(value):
    with refuses(TypeError, f"flag must be True or False, got {value!r}"):
        truth_value("flag", value)


@pytest.mark.parametrize(
    ("value", "limits", "error", "allowed"),
    [
        (2, (3,), ValueError, ">= 3"),
        (-4, (-3,), ValueError, ">= -3"),
        (2, (3, 5), ValueError, "in [3, 5]"),
        (6, (3, 5), ValueError, "in [3, 5]"),
        (1, (0, 0), ValueError, "in [0, 0]"),
        (3.0, (1,), TypeError, ">= 1"),
        (True, (0, 1), TypeError, "in [0, 1]"),
        ("3", (1, 5), TypeError, "in [1, 5]"),
        (None, (1,), TypeError, ">= 1"),
    ],
)
def test_what_is_no_whole_number_is_refused(value, limits, error, allowed):
    with refuses(error, f"n must be a whole number {allowed}, got {value!r}"):
        whole_number("n", value, *limits)


def test_whole_numbers_at_their_ends_are_pythons():
    for value in (3, np.int64(3), np.uint8(3)):
        for limits in ((3,), (3, 3), (0, 3), (3, 9)):
            found = whole_number("n", value, *limits)
            assert (found, type(found)) == (3, int)
    assert whole_number("n", 10**400, 0) == 10**400


@pytest.mark.parametrize(
    ("value", "interval", "error"),
    [
        (0, "(0, 1]", ValueError),
        (1.5, "(0, 1]", ValueError),
        (1, "[0, 1)", ValueError),
        (-0.1, "[0, 1)", ValueError),
        (float("inf"), "[0, inf)", ValueError),
        (float("-inf"), "(-inf, inf)", ValueError),
        (float("nan"), "(-inf, inf)", ValueError),
        (True, "[0, 1]", TypeError),
        (np.True_, "[0, 1]", TypeError),
        ("0.5", "[0, 1]", TypeError),
        (None, "[0, 1]", TypeError),
        (0.5j, "[0, 1]", TypeError),
    ],
)
def test_what_is_no_number_within_is_refused(value, interval, error):
    number = "a number in" if error is TypeError else "in"
    with refuses(error, f"x must be {number} {interval}, got {value!r}"):
        number_within("x", value, interval)


@pytest.mark.parametrize("value", [10**309, -(10**309)])
def test_a_whole_number_too_large_for_a_float_is_refused_by_its_digits(value):
    with refuses(ValueError, "x must be in (-inf, inf), got a number of 310 digits"):
        number_within("x", value, "(-inf, inf)")


def test_numbers_at_the_ends_that_are_allowed_are_pythons():
    for value, interval in ((0, "[0, 1)"), (1, "(0, 1]"), (np.float32(0.5), "(0, 1)"), (np.int64(10**18), "(0, inf)")):
        found = number_within("x", value, interval)
        assert (found, type(found)) == (value, float)
    assert number_within("x", float("inf"), "(0, inf]") == float("inf")
    assert number_within("x", 10**308, "(0, inf)") == 1e308
