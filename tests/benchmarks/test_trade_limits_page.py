"""The page of the trade's limits is made of the results that are kept."""

import json

import pytest
import trade_limits
from measuring import refreshed


def test_the_tables_are_those_of_the_results():
    found = json.loads(trade_limits.RESULTS.read_text(encoding="utf-8"))
    page = trade_limits.PAGE.read_text(encoding="utf-8")
    made = trade_limits.tables(found)
    assert len(made) == page.count("<!-- end -->")
    assert refreshed(page, made) == page


def test_nobody_earns_much_that_is_not_there():
    found = json.loads(trade_limits.RESULTS.read_text(encoding="utf-8"))
    excesses = {name: row["excess"] for name, row in {**found["audit"], **found["learned"]}.items()}
    assert len(excesses) > 19
    assert all(high < 0.15 for _, _, high in excesses.values())


def test_a_place_is_named_by_what_differs_and_the_richest_comes_first():
    row = {"open loop": 1.0, "knee": [0.5, 3.0], "fastest": 0.7, "most": 4.0}
    table = trade_limits.place_table(
        {
            "0": {"place": {"dither": 0.1, "hold": 0.5}, "gain": [0.1, 0.0, 0.2], **row},
            "1": {"place": {"dither": 0.1, "hold": 0.7, "groups": {"deborah": 0.1}}, "gain": [0.5, 0.4, 0.6], **row},
        }
    )
    first, second = table.splitlines()[2:]
    assert first.startswith("| hold 0.7, deborah 0.1 | 0.50 | 50 [40, 60]% |")
    assert second.startswith("| the defaults | 0.10 | 10 [0, 20]% |")


def test_a_part_that_another_needs_is_asked_for(monkeypatch, tmp_path):
    monkeypatch.setattr(trade_limits, "RESULTS", tmp_path / "none.json")
    with pytest.raises(SystemExit, match="the part 'registers' has to be run before"):
        trade_limits.results_of("registers")
