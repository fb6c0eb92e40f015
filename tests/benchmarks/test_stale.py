"""Pages whose numbers are no longer what the measures give are named, with the command that makes them again."""

import json
from statistics import NormalDist

import memory_reward
import pytest
import remeasured
import stale

from stickslip.reservoir import memory
from stickslip.studies.benchmark.probe import probes
from stickslip.tasks import task as tasks
from stickslip.tasks import TASKS


def test_no_page_is_stale():
    assert stale.stale() == []


def test_a_changed_measure_names_the_page_and_the_command(tmp_path, monkeypatch):
    made = {"tasks": {"NARMA-2 NRMSE": {"probes": probes({"NARMA-2 NRMSE": TASKS["NARMA-2 NRMSE"]}, {})}}}
    monkeypatch.setattr(stale, "REMEASURED", {})
    for file in stale.PAGES:
        (tmp_path / file).write_text(json.dumps(made))
    assert stale.stale(tmp_path) == []
    monkeypatch.setattr(tasks, "_HOLDOUT", 0.4)
    laboratory, search = stale.stale(tmp_path)
    assert laboratory.startswith(
        "docs/reservoir.md and README.md: run `python benchmarks/laboratory.py` (NARMA-2 NRMSE: "
    )
    assert search.startswith("docs/best.md: run `python benchmarks/best.py` (NARMA-2 NRMSE: ")


def test_a_changed_cutoff_or_split_names_the_pages_that_hold_no_probes(monkeypatch):
    class Lenient(NormalDist):
        def inv_cdf(self, p):
            return 0.8 * super().inv_cdf(p)

    monkeypatch.setattr(memory, "NormalDist", Lenient)
    monkeypatch.setattr(tasks, "_HOLDOUT", 0.4)
    monkeypatch.setattr(remeasured, "TRUST_CASES", remeasured.TRUST_CASES[:1])
    monkeypatch.setattr(stale, "PAGES", {})
    # Delays whose capacity is far from the cutoff are all that the reward's page shows: it stands.
    trust, encodings = stale.stale()
    assert trust.startswith("docs/trust.md: run `python benchmarks/trust.py --fresh` (power: 0.5, ")
    assert encodings.startswith("docs/encodings.md: run `python benchmarks/encodings.py` (")


def test_rewards_are_those_of_the_environment(monkeypatch):
    monkeypatch.setitem(memory_reward.CASES, "`dither=0.02`", {"dither": 0.021})
    kept = json.loads(memory_reward.RESULTS.read_text(encoding="utf-8"))
    assert [name for name, was, now in remeasured.of_reward(kept) if was != now] == ["reward of `dither=0.02`"]


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
