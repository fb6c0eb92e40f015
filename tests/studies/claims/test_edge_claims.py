"""C3 to C5: verdicts that follow where memory is largest."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible

from stickslip.studies.claims import edge
from stickslip.studies.claims.asked import Asked
from stickslip.studies.claims.edge import along_work, an_edge, at_the_edge, Edge
from stickslip.studies.claims.edge_figure import plot_edge, plot_through_the_edge, plot_work
from stickslip.studies.edge.over_maps import name_of


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


def test_memory_is_drawn_against_the_share_of_the_most_work():
    shape = ("deborah", "duffing", "seed")
    found = xr.Dataset(
        {"memory": (shape, np.full((3, 2, 4), 2.0)), "work": (shape, np.tile([[[4.0], [1.0]]], (3, 1, 4)))},
        coords={"deborah": [0.1, 1.0, 8.0], "duffing": [0.0, 50.0]},
    )
    maps = {name_of(place, 0.5, 0.02, "raw"): found for place in ("anchored", "ground")}
    figure = plot_work(Edge(maps, {}, {}, {}))
    assert_legible(figure)
    left, right = figure.axes
    np.testing.assert_array_equal(left.get_lines()[0].get_xdata(), [1.0, 0.25])
    assert right.get_legend().get_texts()[0].get_text() == r"$\Pi_4$ = 0.1"


@pytest.mark.slow
def test_a_small_study_decides_and_draws_all_three(tmp_path, monkeypatch):
    tiny = replace(edge.QUICK, rows=3, holds=1200, line=5, line_holds=400, long_holds=400, long_delays=30)
    monkeypatch.setattr(edge, "QUICK", tiny)
    said = []
    found = edge.measure(Asked(tmp_path, quick=True, show=said.append))
    told = {claim.name: claim for claim in edge.claims(found)}
    assert [*told] == ["C3", "C4", "C5"]
    assert told["C3"].verdict == "overturned"
    assert told["C4"].verdict == "reproduced in part"
    assert any(number.unit == "mJ" for number in told["C3"].body.values())
    assert len(said) == 15
    for draw in (plot_work, plot_edge, plot_through_the_edge):
        assert all(ax.has_data() for ax in draw(found).axes)
