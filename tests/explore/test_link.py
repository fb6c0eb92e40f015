"""Links: a setup goes through one to the last bit, and a forged one is refused in a sentence."""

from urllib.parse import urlencode

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from stickslip.explore.link import query_of, setup_of_query
from stickslip.explore.presets import preset, PRESETS
from stickslip.explore.setup import DRIVES, NUMBERS, Setup, setup_of, SWITCHES, UNITS
from stickslip.train.policies.pretrained import PRETRAINED

NUMERIC = {name: some.floats(each.low, each.high) for name, each in NUMBERS.items() if "friction" not in name}
CHOSEN = {
    "kinetic_friction": some.floats(0.0, 0.5),
    "static_friction": some.floats(0.5, 1.0),
    "drive": some.sampled_from(DRIVES),
    "policy": some.sampled_from(PRETRAINED),
    "units": some.sampled_from(UNITS),
    **dict.fromkeys(SWITCHES, some.booleans()),
    "word": some.text("01", min_size=1, max_size=32),
}


@settings(max_examples=25)
@given(some.fixed_dictionaries({}, optional={**NUMERIC, **CHOSEN}))
def test_a_link_carries_a_setup_to_the_last_bit(values):
    if "kinetic_friction" in values:
        values.setdefault("static_friction", 0.5)
    setup = setup_of(values)
    assert setup_of_query(query_of(setup)) == setup
    assert setup_of_query("?" + query_of(setup)) == setup


def test_a_link_tells_what_is_not_usual_and_no_more():
    assert query_of(Setup()) == ""
    assert query_of(setup_of({"duffing": 2.0, "word": "10"})) == "duffing=2.0&word=10"
    assert query_of(setup_of({"anchored": True, "ratchet": False})) == "ratchet=false&anchored=true"
    assert setup_of_query("") == Setup()


def test_a_link_may_begin_with_a_preset():
    assert all(setup_of_query(f"preset={name}") == each.setup for name, each in PRESETS.items())
    assert setup_of_query("hold=2&preset=uphill") == setup_of({"hold": 2.0}, preset("uphill"))


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("preset=nosuch", r"preset must be one of \[.*\], got 'nosuch'"),
        ("hold=fast", r"hold must be a number in \[0.05, 5\], got 'fast'"),
        ("hold=", r"hold must be a number in \[0.05, 5\], got ''"),
        ("hold=nan", r"hold must be in \[0.05, 5\], got nan"),
        ("duffing=1e999", r"duffing must be in \[0, 20\], got inf"),
        ("kinetic_friction=0.9", r"kinetic_friction must be in \[0, static_friction = 0.3\], got 0.9"),
        ("word=<script>", r"word must be 1 to 32 letters 0 and 1, got '<script>'"),
        ("policy=..%2F..%2Fetc%2Fpasswd", r"policy must be one of \[.*\], got '../../etc/passwd'"),
        ("anchored=1", r"anchored must be one of \['true', 'false'\], got '1'"),
        ("groups=1", r"link has no 'groups'; allowed are \['preset', 'duffing'"),
        ("__class__=1", r"link has no '__class__'"),
        ("hold=1&hold=2", r"link must name 'hold' once, got it 2 times"),
        ("word=" + "1" * 3000, r"link must have at most 2000 characters, got 3005"),
        (urlencode({"hold": "١"}) + "0" * 30, r"hold must be in \[0.05, 5\], got 1e\+30"),
    ],
)
def test_a_forged_link_is_refused_in_a_sentence(query, message):
    with pytest.raises(ValueError, match=f"^{message}") as caught:
        setup_of_query(query)
    assert "\n" not in str(caught.value)
