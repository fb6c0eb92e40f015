"""The page of batches says what was kept."""

import json

import batch
from measuring import refreshed


def test_the_tables_of_batches_are_those_of_the_results_that_are_kept():
    results = json.loads(batch.RESULTS.read_text(encoding="utf-8"))
    page = batch.PAGE.read_text(encoding="utf-8")
    assert refreshed(page, batch.tables(results)) == page


def test_a_ratio_stands_with_its_quartiles_beside_its_case():
    holds = {f"{who}, {n} holds{more}": [0.1, 0.2, 0.3] for n in batch.CASES for who, more in CASES}
    ratios = {f"{name} over environment": [1.0, 1.25, 1.5] for name in holds} | {
        "episode start over 40 steps": [0.1, 0.1, 0.2]
    }
    made = batch.tables({"us a hold": holds, "ratios": ratios})
    lines = made["batch"].splitlines()
    assert lines[2] == "| 4096 x 40 | environment | 0.20 [0.10, 0.30] |  |"
    assert lines[4] == "| 4096 x 40 | simulate, groups differ | 0.20 [0.10, 0.30] | 1.25 [1.00, 1.50] |"
    assert len(lines) == 8
    assert made["batch starts"].endswith("| episode start over 40 steps | 0.10 [0.10, 0.20] |")


CASES = (("environment", ""), ("simulate", ""), ("simulate", ", groups differ"))
