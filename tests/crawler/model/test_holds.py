"""A hold may be given in seconds where an actuator says how long natural time is."""

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from stickslip.crawler import Actuator, Groups, lyapunov_spectrum, simulate
from stickslip.crawler.model.holds import hold_in_seconds, natural_hold, natural_holds, said_of_hold
from stickslip.tasks import BodyReservoir, crawler_states

SIXTEENTH = Actuator.ecoflex()  # t_c = 1/16 s
QUICK = replace(SIXTEENTH, stiffness=256.0)  # 1/32 s
WORD = [1, 1, 0, 1, 0, 0]


@pytest.mark.parametrize(
    ("text", "natural"),
    [
        ("31.25 ms", 0.5),
        ("31.25ms", 0.5),
        ("0.03125 s", 0.5),
        ("3.125e-2 s", 0.5),
        ("31250 us", 0.5),
        ("31250 µs", 0.5),
        (" +31.25  ms ", 0.5),
        ("0.5 t_c", 0.5),
        ("1 s", 16.0),
        ("20 ms", float(Fraction(20, 1000) * 16)),
    ],
)
def test_a_text_is_converted_with_one_rounding_where_the_units_are_powers_of_two(text, natural):
    assert natural_hold(text, SIXTEENTH) == natural


def test_numbers_are_natural_whatever_the_groups():
    for groups in (SIXTEENTH, Groups(), "linear", {"duffing": 2}, None):
        assert natural_hold(0.5, groups) == 0.5
        assert natural_hold("0.5 t_c", groups) == 0.5


def test_each_of_several_has_its_own_natural_time():
    assert natural_holds("20 ms", [SIXTEENTH, SIXTEENTH]) == 0.32
    np.testing.assert_array_equal(natural_holds("31.25 ms", [SIXTEENTH, QUICK]), [0.5, 1.0])
    np.testing.assert_array_equal(natural_holds(["31.25 ms", "0.25 t_c"], [SIXTEENTH, QUICK]), [0.5, 0.25])
    np.testing.assert_array_equal(natural_holds(["31.25 ms", 0.75], SIXTEENTH), [0.5, 0.75])


def test_a_hold_is_told_in_both_units():
    assert hold_in_seconds(0.5, SIXTEENTH) == 0.03125
    assert said_of_hold(0.5, SIXTEENTH) == "0.5 t_c = 31.25 ms"
    assert said_of_hold(0.5, Groups()) == "0.5 t_c"
    assert hold_in_seconds(0.5, [SIXTEENTH, SIXTEENTH]) == 0.03125
    for groups in (Groups(), "linear", {"duffing": 2}, None, [SIXTEENTH, QUICK], [SIXTEENTH, Groups()]):
        assert hold_in_seconds(0.5, groups) is None


@pytest.mark.parametrize(
    ("hold", "groups", "message"),
    [
        ("20 ms", Groups(), "in units of t_c, such as 0.5, where groups is no Actuator, .* got '20 ms'"),
        ("20 ms", "linear", "groups is no Actuator"),
        ("700 s", SIXTEENTH, r"in \(0, 10000\] t_c, which is \(0, 625\] s where t_c is 0.0625 s, got '700 s'"),
        ("0 ms", SIXTEENTH, r"in \(0, 10000\] t_c, which is .* got '0 ms'"),
        ("-1 ms", SIXTEENTH, "got '-1 ms'"),
        ("2e4 t_c", Groups(), r"in \(0, 10000\] t_c, got '2e4 t_c'"),
        ("1e999 s", SIXTEENTH, "got '1e999 s'"),
    ],
)
def test_what_is_out_of_range_is_refused_in_both_units(hold, groups, message):
    with pytest.raises(ValueError, match=f"hold must be .*{message}"):
        natural_hold(hold, groups, "(0, 10000]")


@pytest.mark.parametrize("hold", ["20", "twenty ms", "20 min", "1e ms", "1.2.3 s", "nan s", "inf s", ""])
def test_what_is_no_hold_is_told_what_one_is(hold):
    message = r"^hold must be a number in \(0, 10000\], or a text of one and its unit \(s, ms, us, µs, t_c\), got "
    with pytest.raises(TypeError, match=message + re.escape(repr(hold))):
        natural_hold(hold, SIXTEENTH, "(0, 10000]")


def test_as_many_holds_as_crawlers():
    with pytest.raises(ValueError, match="groups and hold must have as many rows, got 2 and 3"):
        natural_holds(["1 ms", "2 ms", "3 ms"], [SIXTEENTH, QUICK])


def test_simulate_takes_seconds_and_moves_as_by_natural_time_to_the_bit():
    for body, hold, natural in (
        (SIXTEENTH, "31.25 ms", 0.5),
        ([SIXTEENTH, QUICK], "31.25 ms", [0.5, 1.0]),
        (iter([SIXTEENTH, SIXTEENTH]), "0.03125 s", 0.5),
        ([SIXTEENTH, QUICK], ["31.25 ms", "15.625 ms"], [0.5, 0.5]),
    ):
        expected = [SIXTEENTH, SIXTEENTH] if np.ndim(natural) == 0 and not isinstance(body, Actuator) else body
        found, wanted = simulate(body, WORD, hold), simulate(expected, WORD, natural)
        for name in ("time", "foot", "deformation", "hold"):
            np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))


def test_the_laboratory_takes_seconds_too():
    states = crawler_states(WORD, groups=SIXTEENTH, hold="31.25 ms")
    np.testing.assert_array_equal(states, crawler_states(WORD, groups=SIXTEENTH, hold=0.5))
    assert BodyReservoir(groups=QUICK, hold="31.25 ms").hold == 1.0


def test_exponents_take_seconds_too():
    word = np.resize(WORD, 120)
    found = lyapunov_spectrum(SIXTEENTH, word, "31.25 ms", washout=20)
    np.testing.assert_array_equal(found.exponents, lyapunov_spectrum(SIXTEENTH, word, 0.5, washout=20).exponents)
