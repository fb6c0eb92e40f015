"""Pages whose numbers are no longer what the measures give are named, with the command that makes them again."""

import json

import pytest
import stale

from stickslip.tasks import task as tasks
from stickslip.tasks import TASKS
from stickslip.tasks.probe import probes


def test_no_page_is_stale():
    assert stale.stale() == []


def test_a_changed_measure_names_the_page_and_the_command(tmp_path, monkeypatch):
    made = {"tasks": {"NARMA-2 NRMSE": {"probes": probes({"NARMA-2 NRMSE": TASKS["NARMA-2 NRMSE"]}, {})}}}
    for file in stale.PAGES:
        (tmp_path / file).write_text(json.dumps(made))
    assert stale.stale(tmp_path) == []
    monkeypatch.setattr(tasks, "_HOLDOUT", 0.4)
    laboratory, search = stale.stale(tmp_path)
    assert laboratory.startswith(
        "docs/reservoir.md and README.md: run `python benchmarks/laboratory.py` (NARMA-2 NRMSE: "
    )
    assert search.startswith("docs/best.md: run `python benchmarks/best.py` (NARMA-2 NRMSE: ")


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        ({}, "no probes were kept"),
        ({"probes": {"tasks": {"gone": {"probe": 1.0}}, "reservoirs": {}}}, "gone: 1.0 then, None today"),
        (
            {"made for": {"tasks": {}, "reservoirs": {"delay line": {"probe": [2.0]}}}},
            r"delay line: \[2.0\] then, \[0.",
        ),
    ],
)
def test_what_is_gone_or_was_never_kept_is_said(kept, said):
    [sentence] = stale.changes(kept)
    import re

    assert re.match(said, sentence)
