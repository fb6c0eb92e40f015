"""References, rows and the figure, on small cases."""

import json

import matplotlib as mpl
import numpy as np
import pytest
from scipy.linalg import expm

from stickslip.crawler import Groups, PRESETS, REST, Scene, SolverError
from stickslip.studies.work_precision import (
    Case,
    measure,
    plot_work_precision,
    recommend,
    reference_for,
    TOLERANCES,
)
from stickslip.studies.work_precision import measurement as work_precision_module
from stickslip.studies.work_precision import reference as reference_module
from stickslip.studies.work_precision.case import DEFORMATION, FOOT, MEAN_SPEED, RMS_DEFORMATION, SLIP_RATE

mpl.use("agg")

# Chaotic: an undamped stiffening spring, shaken by a quick valve and a foot that slides both ways.
RESTLESS = Groups(duffing=200.0, damping_ratio=0.0, deborah=0.1, static_friction=0.9, kinetic_friction=0.05)


@pytest.fixture(scope="module")
def crawl():
    return measure(Case(holds=60), rounds=3)


def anchored_linear(groups, valve, hold):
    """Deformation at the end of each hold, by the matrix exponential of (1 - r) z'' = p - z - 2 Pi2 z'."""
    payload = 1.0 - groups.foot_mass_fraction
    matrix = np.zeros((4, 4))  # z, v, p, u
    matrix[0, 1] = 1.0
    matrix[1, :3] = np.array([-1.0, -2.0 * groups.damping_ratio, 1.0]) / payload
    matrix[2, 2:] = np.array([-1.0, 1.0]) / groups.deborah
    propagator = expm(matrix * hold)
    state, ends = np.zeros(4), []
    for command in valve:
        state[3] = command
        state = propagator @ state
        ends.append(state[0])
    return np.array(ends)


def test_the_reference_of_a_linear_body_is_its_closed_form():
    case = Case(PRESETS["linear"], Scene(anchored=True), holds=100)
    reference = reference_for(case)
    exact = anchored_linear(case.groups, case.valve, case.hold)
    assert np.abs(reference.trajectory.deformation - exact).max() < 1e-13
    assert reference.comparable
    assert set(reference.floors) == {DEFORMATION}
    assert reference.slips == (0,)


def test_errors_of_a_linear_body_are_those_from_its_closed_form():
    case = Case(PRESETS["linear"], Scene(anchored=True), hold=2.0, holds=50)
    exact = anchored_linear(case.groups, case.valve, case.hold)
    rows = [row for row in measure(case, rounds=1).rows if row.solver == "taylor"]
    assert len(rows) == len(TOLERANCES)
    for row in rows:
        run = case.run(row.solver, row.tolerance)
        assert row.errors[DEFORMATION] == pytest.approx(np.abs(run.deformation - exact).max(), abs=1e-13)


def test_errors_fall_with_the_tolerance(crawl):
    rows = [row for row in crawl.rows if row.solver == "taylor"]
    assert [row.tolerance for row in rows] == list(TOLERANCES)
    errors = np.array([crawl.error(row, FOOT) for row in rows])
    assert errors[0] > 1e-5
    assert (errors[2:8] < 0.2 * errors[:6]).all()
    assert errors[-1] < 1e-12
    assert all(row.slips_agree and row.slips == crawl.reference.trajectory.slips > 5 for row in rows)
    assert all(0.0 < row.timing.low <= row.timing.median <= row.timing.high for row in rows)


def test_the_reference_knows_how_far_it_can_be_trusted(crawl):
    reference = crawl.reference
    assert reference.comparable
    closest = min(max(check.differences.values()) for check in reference.checks)
    assert 0.0 < closest < 1e-11
    assert max(reference.floors.values()) == closest
    assert all(crawl.error(row, FOOT) >= reference.floors[FOOT] for row in crawl.rows)


def test_chaos_is_seen_and_statistics_are_compared():
    study = measure(Case(RESTLESS, Scene(ratchet=False), holds=300), rounds=1)
    assert not study.reference.comparable
    assert max(study.reference.checks[0].differences.values()) > 0.1
    assert set(study.reference.values) == {MEAN_SPEED, SLIP_RATE, RMS_DEFORMATION}
    run = study.reference.trajectory
    assert study.reference.values[SLIP_RATE] == pytest.approx(run.slips / 150.0, rel=0.1)
    assert study.reference.values[RMS_DEFORMATION] == pytest.approx(np.sqrt(np.mean(run.deformation**2)), rel=0.1)
    tight = next(row for row in reversed(study.rows) if row.solver == "taylor")
    assert all(tight.errors[name] <= floor for name, floor in study.reference.floors.items())
    assert recommend(study, 1e-6).row is not None
    assert any("not comparable" in note for note in study.notes)
    assert len(plot_work_precision(study).axes) == 3


def test_a_solver_that_heeds_no_tolerance_has_one_row(monkeypatch):
    case = Case(holds=10)
    deaf = case.run("taylor", 1e-9)
    monkeypatch.setattr(Case, "run", lambda *_, **__: deaf)
    (row,) = {row.solver: row for row in measure(case, rounds=1).rows if row.solver == "taylor"}.values()
    assert row.tolerance is None
    assert row.name == "taylor"


def test_a_run_nobody_would_wait_for_is_left_out(monkeypatch):
    def afford(case, solver, tolerance):
        if tolerance < 1e-12:
            raise SolverError("the run would take a year")

    monkeypatch.setattr(work_precision_module, "afford", afford)
    study = measure(Case(holds=5), rounds=1)
    assert {omission.tolerance for omission in study.omissions} == {1e-13, 1e-14}
    assert min(row.tolerance for row in study.rows if row.solver == "taylor") == 1e-12
    assert any("Left out: taylor at 1e-13, 1e-14: the run would take a year" in note for note in study.notes)


def test_a_case_without_a_reference_says_why(monkeypatch):
    def afford(case, solver, tolerance):
        raise SolverError("the run would take a year")

    monkeypatch.setattr(reference_module, "afford", afford)
    with pytest.raises(SolverError, match=r"no solver gives a reference at tolerance 1e-15 \(.*a year"):
        measure(Case(holds=5), rounds=1)


def test_progress_is_told_to_the_end():
    told = []
    measure(Case(holds=5), rounds=2, on_progress=lambda done, total: told.append((done, total)))
    done, totals = zip(*told, strict=True)
    assert len(set(totals)) == 1
    assert list(done) == list(range(totals[0] + 1))


def test_the_figure_shows_every_row(crawl):
    found = recommend(crawl, 1e-6)
    figure = plot_work_precision(crawl, found)
    assert [ax.get_title(loc="left").split(" (")[0] for ax in figure.axes] == [FOOT, DEFORMATION]
    line = next(line for line in figure.axes[0].lines if line.get_label() == "taylor")
    rows = [row for row in crawl.rows if row.solver == "taylor"]
    np.testing.assert_array_equal(line.get_xdata(), [row.timing.median for row in rows])
    np.testing.assert_array_equal(line.get_ydata(), [crawl.error(row, FOOT) for row in rows])
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"recommended", "error wanted"} <= set(labels)
    assert "wrong slip count" not in labels


def test_all_of_it_goes_into_json(crawl):
    read = json.loads(json.dumps(crawl.to_dict(), allow_nan=False))
    assert read["compared"] == "trajectories"
    assert len(read["rows"]) == len(crawl.rows)
    assert read["rows"][0]["timing"]["median"] == crawl.rows[0].timing.median


def test_a_case_is_driven_by_documented_bits_from_rest():
    case = Case(holds=9, seed=3)
    np.testing.assert_array_equal(case.valve, np.random.default_rng(3).integers(0, 2, 9))
    first = case.run("taylor", 1e-9, holds=4)
    np.testing.assert_array_equal(first.valve, case.valve[:4])
    again = case.run("taylor", 1e-9, initial=REST)
    np.testing.assert_array_equal(again.deformation[:4], first.deformation)
    assert case.duration == 4.5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"holds": 0}, "holds must be a whole number >= 1, got 0"),
        ({"seed": -1}, "seed must be a whole number >= 0, got -1"),
        ({"hold": 0.0}, r"hold must be in \(0, inf\), got 0.0"),
        ({"groups": {"wheels": 4}}, "groups has no 'wheels'"),
        ({"scene": {"wheels": 4}}, "scene has no 'wheels'"),
    ],
)
def test_bad_cases(arguments, message):
    with pytest.raises(ValueError, match=message):
        Case(**arguments)


def test_bad_rounds():
    with pytest.raises(ValueError, match="rounds must be a whole number >= 1, got 0"):
        measure(Case(holds=5), rounds=0)
