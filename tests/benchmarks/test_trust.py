"""The tables of docs/trust.md are those of the results that are kept, and the results say what the page says."""

import json
import math
from pathlib import Path

import pytest
import trust
from measuring import refreshed

DONE = json.loads(trust.RESULTS.read_text(encoding="utf-8"))["cases"]
INTERVALS = ("capacity", "total", "corrected, this readout", "corrected, best readout")


def test_the_tables_are_those_of_the_results():
    page = Path(trust.PAGE).read_text(encoding="utf-8")
    assert refreshed(page, trust.tables(DONE)) == page


def test_every_case_was_measured():
    assert set(trust.cases(1.0)) == set(DONE)


@pytest.mark.parametrize("name", [name for name in DONE if name.startswith(("memory", "information"))])
def test_intervals_cover_at_their_rate(name):
    """Binomial: 190 of 200 have standard deviation 3."""
    one = DONE[name]
    runs = one["runs"]
    for key in INTERVALS:
        if key in one:
            assert one[key] >= 0.95 * runs - 3.5 * math.sqrt(0.95 * 0.05 * runs), key
    assert one.get("own estimate", runs) == runs


@pytest.mark.parametrize("significance", trust.SIGNIFICANCES)
@pytest.mark.parametrize("message", trust.INPUTS)
@pytest.mark.parametrize("kind", trust.STATES)
def test_functions_pass_by_chance_at_most_twice_as_often_as_they_may(kind, message, significance):
    passed = tried = 0
    for features, samples in trust.SIZES:
        one = DONE[f"false positives: {message}, {kind}, {features} states, {samples} samples"]
        counts = one[f"information {significance:g}"]
        passed, tried = passed + counts[0], tried + counts[2]
    # Functions of one run share its states and inputs, so that their passes come together.
    assert passed <= 2 * significance * tried + 6 * math.sqrt(significance * tried)


def test_a_case_is_measured_again_alike():
    assert trust.power("0.5", 10_000, 0.025, 1) == trust.power("0.5", 10_000, 0.025, 1)


@pytest.mark.parametrize("significance", trust.SIGNIFICANCES)
@pytest.mark.parametrize("message", ["0.5", "0.1", "uniform"])
@pytest.mark.parametrize("kind", trust.STATES)
def test_delays_pass_by_chance_at_most_twice_as_often_where_flips_are_not_rare(kind, message, significance):
    passed = tried = 0
    for features, samples in trust.SIZES:
        one = DONE[f"false positives: {message}, {kind}, {features} states, {samples} samples"]
        counts = one[f"held out {significance:g}"]
        passed, tried = passed + counts[0], tried + counts[2]
    assert passed <= 2 * significance * tried + 3 * math.sqrt(significance * tried)
