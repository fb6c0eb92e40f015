"""The choice of solver and tolerance, on rows made up for it."""

import numpy as np
import pytest

from stickslip.crawler import simulate
from stickslip.studies.work_precision import Case, recommend, Reference, Row, Timing, WorkPrecision
from stickslip.studies.work_precision.case import DEFORMATION, FOOT

CASE = Case(holds=2)
RUN = simulate(CASE.groups, CASE.valve, CASE.hold)


def row(solver, tolerance, error, microseconds, *, slips_agree=True):
    errors = {FOOT: error, DEFORMATION: 0.1 * error}
    timing = Timing(0.9 * microseconds, microseconds, 1.1 * microseconds)
    return Row(solver, tolerance, errors, 7 if slips_agree else 6, slips_agree, timing)


def study(*rows, floor=1e-14, comparable=True):
    floors = {FOOT: floor, DEFORMATION: floor}
    return WorkPrecision(CASE, Reference("taylor", RUN, (), comparable, {}, floors, (7,)), rows, (), 100.0)


TAYLOR = (row("taylor", 1e-4, 1e-3, 2.0), row("taylor", 1e-5, 3e-5, 2.5), row("taylor", 1e-6, 2e-7, 3.0))


def test_the_cheapest_that_is_good_enough_is_recommended_with_its_neighbours():
    found = recommend(study(*TAYLOR), 1e-4)
    assert (found.looser, found.row, found.tighter) == TAYLOR
    assert "For an error of 0.0001 use taylor at tolerance 1e-05: foot position to 3.0e-05" in found.sentence
    assert "looser (1e-04) errs by 1.0e-03 and takes 0.80 times the time" in found.sentence
    assert "tighter (1e-06) errs by 2.0e-07 and takes 1.20 times the time" in found.sentence


def test_another_solver_is_recommended_where_it_is_cheaper():
    exact = row("closed_form", None, 1e-15, 0.2)
    found = recommend(study(*TAYLOR, exact), 1e-6)
    assert (found.looser, found.row, found.tighter) == (None, exact, None)
    assert "tolerance" not in found.sentence


def test_a_wrong_slip_count_is_never_recommended():
    wrong = row("radau", 1e-2, 1e-9, 0.1, slips_agree=False)
    right = row("radau", 1e-3, 1e-10, 4.0)
    found = recommend(study(*TAYLOR, wrong, right), 1e-6)
    assert found.row == TAYLOR[2]
    assert recommend(study(wrong), 1e-6).row is None
    assert "has 6 slips instead of" in recommend(study(wrong), 1e-6).sentence


def test_being_right_by_luck_is_not_recommended():
    lucky = row("taylor", 1e-3, 1e-9, 1.0)
    assert recommend(study(lucky, *TAYLOR), 1e-6).row == TAYLOR[2]


def test_every_quantity_counts():
    stretched = Row("taylor", 1e-6, {FOOT: 1e-9, DEFORMATION: 1e-3}, 7, True, Timing(1.0, 1.0, 1.0))
    assert recommend(study(stretched), 1e-6).row is None


def test_nothing_is_recommended_where_nothing_is_good_enough():
    found = recommend(study(*TAYLOR), 1e-8)
    assert found.row is None
    assert found.sentence == (
        "Nothing measured keeps to an error of 1e-08: the best, taylor at tolerance 1e-06, errs by 2.0e-07."
    )


def test_an_error_below_the_floor_cannot_be_promised():
    perfect = row("taylor", 1e-14, 0.0, 1.0)
    assert recommend(study(perfect, floor=1e-10), 1e-9).row == perfect
    found = recommend(study(perfect, floor=1e-10), 1e-12)
    assert found.row is None
    assert "the reference itself is known to 1.0e-10 only" in found.sentence


def test_a_statistic_within_chance_is_good_enough():
    found = recommend(study(*TAYLOR, floor=1e-4, comparable=False), 1e-12)
    assert found.row == TAYLOR[1]
    assert "statistics that cannot be told from the reference's" in found.sentence


@pytest.mark.parametrize("wanted", [0.0, -1.0, np.nan, np.inf])
def test_bad_input(wanted):
    with pytest.raises(ValueError, match=r"error must be in \(0, inf\), got "):
        recommend(study(*TAYLOR), wanted)
