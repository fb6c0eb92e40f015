"""What a visitor does to what he sees."""

import json

import pytest

from stickslip.explore.link import setup_of_query
from stickslip.explore.measures import exponents_of, long_run
from stickslip.explore.motion import MOST_LIVE, shown
from stickslip.explore.presets import preset
from stickslip.explore.setup import Setup, setup_of
from stickslip.explore.units import in_si
from stickslip.explore.view import acted, told_of_exponents, told_of_long_run, told_of_motion, told_of_setup, View


def test_each_action_does_what_it_says():
    view = acted(View(Setup()), {"do": "set", "name": "duffing", "value": 2.0})
    assert view.setup == setup_of({"duffing": 2.0})
    view = acted(acted(view, {"do": "set", "name": "units", "value": "SI"}), {"do": "preset", "name": "uphill"})
    assert view.setup == setup_of({"units": "SI"}, preset("uphill"))
    live = acted(view, {"do": "set", "name": "drive", "value": "live"})
    assert live.bits == (0,)
    for bit in (1, 1, 0):
        live = acted(live, {"do": "bit", "value": bit})
    assert live.bits == (0, 1, 1, 0)
    kept = acted(live, {"do": "keep"})
    assert kept.setup == setup_of({"drive": "word", "word": "0110"}, live.setup)
    assert acted(live, {"do": "restart"}) == View(live.setup)
    assert acted(live, {"do": "set", "name": "hold", "value": 1.0}).bits == (0,)


def test_a_word_that_is_kept_is_the_last_bits_and_a_long_run_begins_anew():
    bits = tuple(k % 3 % 2 for k in range(50))
    assert acted(View(Setup(drive="live"), bits), {"do": "keep"}).setup.word == "".join(map(str, bits[-32:]))
    assert acted(View(Setup(drive="live"), (1,) * MOST_LIVE), {"do": "bit", "value": 1}).bits == (0,)


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ({}, "action must be set, preset, bit, keep or restart, got None"),
        ({"do": "exec", "value": "1"}, "action must be set, preset, bit, keep or restart, got 'exec'"),
        ({"do": "bit", "value": 2}, r"bit must be a whole number in \[0, 1\], got 2"),
        ({"do": "bit"}, r"bit must be a whole number in \[0, 1\], got None"),
        ({"do": "set", "name": "groups", "value": {}}, "setup has no 'groups'"),
        ({"do": "set", "value": 1}, "setup has no 'None'"),
        ({"do": "preset", "name": "nosuch"}, "preset must be one of"),
    ],
)
def test_other_actions_are_refused(action, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}"):
        acted(View(Setup()), action)


def test_what_was_asked_for_is_told_in_both_units():
    setup = Setup(hold=1.5)
    told = told_of_setup(View(setup))
    assert (told["setup"], told["si"]) == (setup.to_dict(), in_si(setup))
    assert told["si"] != told["setup"]


def test_what_is_told_is_what_was_found_and_fits_json():
    setup = setup_of({"units": "SI", "word": "11100"})
    what = shown(setup)
    told = json.loads(json.dumps(told_of_motion(View(setup), what), allow_nan=False))
    assert told["distance"] == pytest.approx(31.25 * what.motion.foot[-1])
    assert told["time"] == pytest.approx(0.0625 * 24.0)
    assert told["slips"] == what.motion.slips
    asked = json.loads(json.dumps(told_of_setup(View(setup)), allow_nan=False))
    assert asked["setup"] == told["moved"] == setup.to_dict()
    assert setup_of_query(asked["query"]) == setup
    assert "in_si" in asked["program"]
    run = long_run(setup)
    measured = json.loads(json.dumps(told_of_long_run(setup, run), allow_nan=False))
    assert measured["speed"] == pytest.approx(run.speed * 500.0)
    assert measured["memory"] == run.memory.corrected
    assert measured["front"] == 0.1
    spectrum = exponents_of(setup, run.valve)
    found = json.loads(json.dumps(told_of_exponents(setup, spectrum), allow_nan=False))
    assert found["exponents"] == pytest.approx((16.0 * spectrum.exponents).tolist())
    assert found["verdict"] == "contracting"
