"""The study of the edge: what it holds against, and that its verdicts are its numbers'."""

import numpy as np
import pytest

from stickslip import Groups, memory_capacity, simulate
from stickslip.studies.edge.modes import exact_profile
from stickslip.studies.edge.verdicts import memory_along_work, memory_at_the_edge, spread_by_chaos, where_an_edge_is
from stickslip.tasks import body_states, dithered


@pytest.mark.slow
def test_a_linear_body_remembers_what_is_known_exactly():
    linear = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=0.2, deborah=0.5)
    exact = exact_profile(linear, 0.5, 400)
    assert exact.sum() == pytest.approx(3.0, abs=1e-9)
    valve = dithered(np.zeros(20_000, int), 0.5, 0)
    states = body_states(simulate(linear, valve, 0.5, scene={"anchored": True}))
    np.testing.assert_allclose(memory_capacity(states, valve - 0.5, 12).profile, exact[:12], atol=0.02)


def largest(more=(0.5, 0.4, 0.6), exponent=(-0.03, -0.04, -0.02), ground=0):
    cell = {"chaotic": 3, "cells": 70, "most": [2.0, 1.9, 2.1], "exponent": list(exponent)}
    return {
        "anchored, hold 0.5, Π₂ 0.02, raw": {**cell, "edge": [1.5, 1.4, 1.6], "more": list(more)},
        "ground, hold 0.5, Π₂ 0.05, raw": {**cell, "chaotic": ground},
    }


def test_memory_is_at_the_edge_if_no_cell_away_from_it_holds_more():
    told = str(memory_at_the_edge(largest()))
    assert told.startswith("**C5, memory is largest at the edge: no.**")
    assert "holds 0.50 to 0.50 more" in told
    assert memory_at_the_edge(largest(more=(0.0, 0.0, 0.0), exponent=(0.0, -0.01, 0.01))).answer == "yes"
    assert memory_at_the_edge(largest(more=(0.0, 0.0, 0.0))).answer == "not told"
    assert memory_at_the_edge(largest(more=(-0.5, -0.6, -0.4))).answer == "not told"


def test_an_edge_is_where_some_cells_are_chaotic():
    told = where_an_edge_is(largest())
    assert told.answer == "of the anchored body only"
    assert "3 to 3 of 70 cells" in told.sentence
    assert told.sentence.endswith("at Π₂ 0.02 and 0.05.")
    assert where_an_edge_is(largest(ground=2)).answer == "yes"
    nowhere = largest()
    nowhere["anchored, hold 0.5, Π₂ 0.02, raw"]["chaotic"] = 0
    assert where_an_edge_is(nowhere).answer == "not as the paper has it"


@pytest.mark.parametrize(("first", "inside", "answer"), [(9, 1, "no"), (6, 4, "no"), (4, 6, "in part"), (0, 10, "yes")])
def test_memory_peaks_at_moderate_work_if_most_rows_have_it_inside(first, inside, answer):
    told = memory_along_work({"a map": {"first": first, "inside": inside, "last": 0}})
    assert told.answer == answer
    assert f"in {first}, inside in {inside}" in told.sentence


def test_chaos_spreads_the_work_if_starts_do_on_the_ground():
    wild = {"anchored": {"share": 0.9, "exponent": 0.05}}
    assert spread_by_chaos(wild | {"ground": {"share": 1e-9, "exponent": -0.1}}).answer == "no"
    assert spread_by_chaos(wild | {"ground": {"share": 0.5, "exponent": 0.1}}).answer == "in part"
