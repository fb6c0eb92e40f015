"""C3 to C5: verdicts that follow where memory is largest."""

import pytest

from stickslip.studies.claims.edge import along_work, an_edge, at_the_edge


def largest(more=(0.5, 0.4, 0.6), exponent=(-0.03, -0.04, -0.02), anchored=3, ground=0):
    cell = {"cells": 70, "most": [2.0, 1.9, 2.1], "exponent": list(exponent)}
    return {
        "anchored, hold 0.5, Π₂ 0.02, raw": {**cell, "chaotic": anchored, "more": list(more)},
        "ground, hold 0.5, Π₂ 0.02, raw": {**cell, "chaotic": ground},
    }


@pytest.mark.parametrize(
    ("first", "inside", "verdict"), [(113, 5, "overturned"), (4, 6, "reproduced in part"), (0, 10, "reproduced")]
)
def test_memory_at_moderate_work(first, inside, verdict):
    told = along_work({"a map": {"first": first, "inside": inside, "last": 0}})
    assert told.verdict == verdict
    share = told.numbers["rows of Pi4 with most memory inside Pi1"]
    assert share.low <= share.value == inside / (first + inside) <= share.high


@pytest.mark.parametrize(
    ("anchored", "ground", "verdict"),
    [(3, 0, "reproduced in part"), (3, 2, "reproduced"), (0, 0, "not reproduced")],
)
def test_an_edge_of_chaos(anchored, ground, verdict):
    told = an_edge(largest(anchored=anchored, ground=ground))
    assert told.verdict == verdict
    assert told.numbers["chaotic cells, anchored, hold 0.5, Π₂ 0.02"].value == anchored / 70


@pytest.mark.parametrize(
    ("more", "exponent", "verdict"),
    [
        ((0.5, 0.4, 0.6), (-0.03, -0.04, -0.02), "overturned"),
        ((0.0, 0.0, 0.0), (0.001, -0.01, 0.012), "reproduced"),
        ((0.0, 0.0, 0.0), (-0.03, -0.04, -0.02), "not reproduced"),
        ((-0.2, -0.3, -0.1), (-0.03, -0.04, -0.02), "not reproduced"),
    ],
)
def test_memory_at_the_edge(more, exponent, verdict):
    told = at_the_edge(largest(more=more, exponent=exponent))
    assert told.verdict == verdict
    (number,) = told.numbers.values()
    assert (number.value, number.low, number.high) == more
