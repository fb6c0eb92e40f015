"""The tables of docs/reservoir.md and of the README are those of the results that are kept."""

import json
import math

import laboratory
import pytest
from measuring import refreshed

from stickslip.reservoir import Estimate
from stickslip.studies.benchmark.report import as_markdown, as_rows
from stickslip.tasks import MEASURES, TASKS

RESULTS = json.loads(laboratory.RESULTS.read_text(encoding="utf-8"))


def table(part, kept, *, signed=False):
    found = {
        (each["task"], each["reservoir"]): Estimate(
            each["mean"], *(each["interval"] or (math.nan, math.nan)), each["seeds"]
        )
        for each in RESULTS[part][kept]
    }
    return as_markdown(as_rows(found, {**TASKS, **MEASURES}, signed=signed))


@pytest.mark.parametrize(
    ("page", "name", "part", "kept"),
    [
        ("README.md", "tasks", "readme", "means"),
        ("docs/reservoir.md", "all", "all", "means"),
        ("docs/reservoir.md", "differences", "all", "differences"),
        *(("docs/reservoir.md", name, name, "means") for name in laboratory.SWEEPS),
    ],
)
def test_a_table_is_that_of_the_results(page, name, part, kept):
    text = (laboratory.ROOT / page).read_text(encoding="utf-8")
    assert refreshed(text, {name: table(part, kept, signed=kept == "differences")}) == text


def test_the_table_of_closed_loops_is_that_of_the_scores():
    """By the intervals of today, which no probe of a task would show."""
    text = (laboratory.ROOT / "docs" / "reservoir.md").read_text(encoding="utf-8")
    rows = laboratory.rows_of_loops(RESULTS["closed loops"]["found"])
    assert refreshed(text, {"loops": as_markdown(rows)}) == text
