"""Times, differences and statistics of a study, with a clock and runs that are made up."""

import json
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from stickslip.crawler import Groups, Scene, simulate, SolverError
from stickslip.studies.work_precision import (
    Case,
    measure,
    measurement,
    Reference,
    reference,
    Row,
    Timing,
    WorkPrecision,
)
from stickslip.studies.work_precision import case as case_module
from stickslip.studies.work_precision.case import (
    afford,
    DEFORMATION,
    differences,
    FOOT,
    MEAN_SPEED,
    RMS_DEFORMATION,
    SLIP_RATE,
    statistics,
)
from stickslip.studies.work_precision.measurement import Omission
from stickslip.studies.work_precision.reference import Check, reference_for


@dataclass
class Clock:
    """Every run takes as long as its holds and solver say, and nothing else takes time."""

    now: float = 0.0
    per_hold: dict = field(default_factory=lambda: {"taylor": 3e-6, "radau": 7e-6})
    runs: list = field(default_factory=list)
    factors: dict = field(default_factory=dict)

    def read(self):
        return self.now

    def run(self, case, solver, tolerance, *, initial=None, holds=None):
        """In place of `Case.run`: a motion that errs by the tolerance."""
        count = case.holds if holds is None else holds
        self.runs.append((solver, tolerance, holds))
        turn = len([each for each in self.runs if each == (solver, tolerance, None)])
        self.now += self.per_hold[solver] * count * self.factors.get(turn, 1.0)
        error = 0.0 if tolerance < 1e-14 else tolerance * (1 if solver == "taylor" else 2)
        ends = np.linspace(0, 1, case.holds)[:count]
        return SimpleNamespace(deformation=ends + error, foot=2 * ends + 3 * error, slips=5)


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(Case, "run", lambda case, *args, **named: clock.run(case, *args, **named))
    monkeypatch.setattr(measurement, "_clock", clock.read)
    monkeypatch.setattr(case_module.time, "perf_counter", clock.read)
    return clock


def test_times_are_per_time_unit_and_quartiles_over_the_rounds(clock):
    """40 holds of 0.25 are ten units of time: a run of 120 us costs 12 us a unit, and 7/3 times as much by Radau."""
    case = Case(holds=40, hold=0.25)
    study = measure(case, rounds=5)
    first = {row.solver: row for row in reversed(study.rows)}
    assert first["taylor"].timing == pytest.approx((12.0, 12.0, 12.0))
    assert first["radau"].timing == pytest.approx((28.0, 28.0, 28.0))
    assert study.call == pytest.approx(3.0)  # one hold of the solver that is first
    assert [row.tolerance for row in study.rows if row.solver == "taylor"] == [10.0**-k for k in range(2, 15)]
    for row in study.rows:
        scale = 1 if row.solver == "taylor" else 2
        assert row.errors == pytest.approx(
            {FOOT: 3 * scale * row.tolerance, DEFORMATION: scale * row.tolerance}, abs=1e-15
        )


def test_the_quartiles_are_those_of_unequal_rounds(clock):
    # The first two runs, of the probe and of the comparison, are not timed.
    clock.factors = {turn: 1.0 + turn for turn in range(20)}
    row = measure(Case(holds=40, hold=0.25), rounds=5).rows[0]
    timed = 12.0 * (1.0 + np.arange(20))
    spans = [timed[start : start + 5] for start in range(1, 12)]
    assert any(row.timing == pytest.approx(np.quantile(each, [0.25, 0.5, 0.75])) for each in spans)
    assert row.timing.low < row.timing.median < row.timing.high


def test_every_other_round_runs_backward(clock):
    rows = measure(Case(holds=40), rounds=3).rows
    timed = [run for run in clock.runs if run[2] is None][-3 * 26 :]
    assert [(solver, tolerance) for solver, tolerance, _ in timed[:26]] == [(row.solver, row.tolerance) for row in rows]
    assert timed[26:52] == timed[:26][::-1]
    assert timed[52:] == timed[:26]


def test_what_is_slow_takes_three_turns(clock):
    """Radau's runs take 2.8 s: after two of them 5 s are over, and a third is the last."""
    clock.per_hold["radau"] = 2.8 / 40
    measure(Case(holds=40), rounds=6)
    counts = {solver: len([r for r in clock.runs if r == (solver, 1e-5, None)]) for solver in ("taylor", "radau")}
    assert counts["taylor"] - counts["radau"] == 3


@pytest.mark.parametrize(("holds", "probed"), [(400, 4), (3, 3)])
def test_what_takes_longer_than_ten_seconds_is_refused_by_its_first_holds(clock, holds, probed):
    clock.per_hold["taylor"] = 9.99 / holds
    afford(Case(holds=holds), "taylor", 1e-6)
    assert clock.runs == [("taylor", 1e-6, 1), ("taylor", 1e-6, probed)]
    clock.per_hold["taylor"] = 12.2 / holds
    with pytest.raises(SolverError, match=r"the run would take about 12 s, more than the 10 s allowed"):
        afford(Case(holds=holds), "taylor", 1e-6)


def test_differences_and_statistics_by_hand():
    one = SimpleNamespace(deformation=np.array([1.0, 2.0, -3.0]), foot=np.array([0.0, 4.0, 6.0]), slips=7)
    other = SimpleNamespace(deformation=np.array([1.5, 2.0, -3.25]), foot=np.array([0.0, 1.0, 8.0]), slips=6)
    ground, anchored = Case(holds=3, hold=2.0), Case(holds=3, hold=2.0, scene=Scene(anchored=True))
    assert differences(ground, one, other) == {FOOT: 3.0, DEFORMATION: 0.5}
    assert differences(anchored, one, other) == {DEFORMATION: 0.5}
    rms = pytest.approx(np.sqrt(14 / 3))
    assert statistics(ground, one) == {MEAN_SPEED: 1.0, SLIP_RATE: 7 / 6, RMS_DEFORMATION: rms}
    assert statistics(anchored, one) == {RMS_DEFORMATION: rms}


def test_a_case_runs_with_every_argument():
    case = Case({"duffing": 2.0}, {"slope": 0.1}, hold=0.75, holds=8, seed=2)
    start = simulate(Groups(), [1.0], 0.5).final_state
    expected = simulate(
        case.groups, case.valve[:5], 0.75, scene=case.scene, tolerance=1e-4, solver="radau", initial=start
    )
    run = case.run("radau", 1e-4, initial=start, holds=5)
    for name in ("deformation", "foot", "velocity", "pressure"):
        np.testing.assert_array_equal(getattr(run, name), getattr(expected, name))
    assert (run.deformation != case.run("taylor", 1e-4, initial=start, holds=5).deformation).any()
    assert len(case.run("taylor", 1e-4).foot) == 8
    assert Case() == Case(Groups(), Scene(), hold=0.5, holds=400, seed=0)
    assert case.duration == 6.0


def twins(means, spread):
    """Statistics of 16 twins, of one mean and standard deviation each."""
    shape = stats.zscore(np.arange(16.0), ddof=1)
    return {name: (mean + spread * shape).tolist() for name, mean in means.items()}


@pytest.mark.parametrize(("apart", "comparable"), [(0.9e-6, True), (1.1e-6, False)])
def test_trajectories_are_compared_up_to_a_millionth(clock, monkeypatch, apart, comparable):
    def run(case, solver, tolerance, **_):
        shift = 0.0 if (solver, tolerance) == ("taylor", 1e-15) else apart
        return SimpleNamespace(deformation=np.zeros(3) + shift, foot=np.full(3, 5.0), slips=4 if shift else 3)

    monkeypatch.setattr(clock, "run", run)
    means = {MEAN_SPEED: 1.0, SLIP_RATE: 2.0}
    asked = []
    monkeypatch.setattr(reference, "twin_statistics", lambda *args: asked.append(args) or twins(means, 0.25))
    case = Case(holds=3)
    found = reference_for(case, comparisons=10)
    assert (found.solver, found.comparable, found.slips) == ("taylor", comparable, (3, 4))
    assert [(check.solver, check.tolerance) for check in found.checks] == [("taylor", 1e-14), ("radau", 1e-15)]
    if comparable:
        assert asked == []
        assert found.values == {}
        assert found.floors == {FOOT: np.spacing(5.0), DEFORMATION: pytest.approx(apart)}
    else:
        assert asked == [(case, "taylor", 1e-15)]
        assert found.values == pytest.approx(means)
        # One in a hundred studies of ten runs and two statistics may see a larger difference of two means of 16.
        quantile = stats.t.ppf(1 - 0.01 / 2 / (10 * 2), 15)
        assert found.floors == pytest.approx({name: quantile * 0.25 * np.sqrt(2 / 16) for name in means})
        alone = reference_for(case)
        assert alone.floors[SLIP_RATE] == pytest.approx(stats.t.ppf(1 - 0.01 / 4, 15) * 0.25 * np.sqrt(2 / 16))


def test_twins_start_a_billionth_apart(monkeypatch):
    starts = []
    run = Case.run

    def seen(case, solver, tolerance, *, initial, **named):
        starts.append(initial)
        return run(case, solver, tolerance, initial=initial, **named)

    monkeypatch.setattr(Case, "run", seen)
    case = Case(holds=4)
    found = reference.twin_statistics(case, "taylor", 1e-9)
    assert [start.deformation for start in starts] == [1e-9 * k for k in range(16)]
    assert {start._replace(deformation=0.0) for start in starts} == {starts[0]}
    for k in (0, 15):
        alone = statistics(case, run(case, "taylor", 1e-9, initial=starts[k]))
        assert {name: values[k] for name, values in found.items()} == alone


def test_the_reference_is_the_most_accurate_solver_that_finishes(monkeypatch):
    refused = []
    allowed = reference.afford

    def but(*solvers):
        def afford(case, solver, tolerance):
            if solver in solvers and tolerance == 1e-15:
                refused.append(solver)
                raise SolverError(f"{solver} is tired")
            allowed(case, solver, tolerance)

        return afford

    linear = Case("linear", Scene(anchored=True), holds=5)
    assert reference_for(linear).solver == "closed_form"
    monkeypatch.setattr(reference, "afford", but("closed_form"))
    assert reference_for(linear).solver == "taylor"
    monkeypatch.setattr(reference, "afford", but("taylor"))
    assert reference_for(Case(holds=5)).solver == "radau"
    monkeypatch.setattr(reference, "afford", but("taylor", "radau", "closed_form"))
    with pytest.raises(SolverError, match=r"tolerance 1e-15 \(taylor: taylor is tired; radau: radau is tired\)"):
        reference_for(Case(holds=5))


def made_up(**of):
    case = Case(holds=10, hold=2.0, seed=4)
    run = simulate(case.groups, case.valve, case.hold)
    checks = (Check("radau", 1e-15, {FOOT: 2e-12, DEFORMATION: 1e-13}, 3), Check("taylor", 1e-14, {FOOT: 4e-13}, 3))
    known = Reference("taylor", run, checks, of.pop("comparable", True), {}, {FOOT: 1e-12, DEFORMATION: 1e-13}, (3, 4))
    rows = (Row("taylor", 1e-3, {FOOT: 1e-14, DEFORMATION: 2e-4}, 3, True, Timing(1.0, 2.0, 3.0)),)
    return WorkPrecision(case, known, rows, of.pop("omissions", ()), 150.0)


def test_an_error_is_told_down_to_the_floor():
    study = made_up()
    [row] = study.rows
    assert (study.error(row, FOOT), study.error(row, DEFORMATION)) == (1e-12, 2e-4)
    assert study.largest_error(row) == 2e-4
    assert row.name == "taylor at tolerance 1e-03"


def test_the_notes_word_for_word():
    assert made_up().title == "errors and time, 10 random holds of 2, seed 4"
    time = (
        "Time is processor time of whole calls of simulate, median and quartiles, nothing subtracted; what a call "
        "costs before the body moves, 150 µs or less, makes 7.50 µs per time unit of it."
    )
    reference = "Reference: taylor at 1e-15; radau at 1e-15 differs by 2.0e-12, taylor at 1e-14 differs by 4.0e-13."
    assert made_up().notes == [reference, time]
    omissions = (Omission("radau", 1e-2, "slow"), Omission("taylor", 1e-9, "long"), Omission("radau", 1e-3, "slower"))
    assert made_up(comparable=False, omissions=omissions).notes == [
        reference,
        "Trajectories are not comparable here: a change in the last digit grows until nothing is shared. Compared are "
        "statistics, each a mean over twins, runs whose starts differ by a billionth.",
        "Left out: radau at 1e-02, 1e-03: slower.",
        "Left out: taylor at 1e-09: long.",
        time,
    ]


def test_the_json_entry_by_entry():
    study = made_up(omissions=(Omission("radau", 1e-2, "slow"),))
    told = json.loads(json.dumps(study.to_dict()))
    reference = told.pop("reference")
    assert told == {
        "groups": Groups().to_dict(),
        "scene": Scene().to_dict(),
        "hold": 2.0,
        "holds": 10,
        "seed": 4,
        "compared": "trajectories",
        "rows": [
            {
                "solver": "taylor",
                "tolerance": 1e-3,
                "errors": {FOOT: 1e-14, DEFORMATION: 2e-4},
                "slips": 3,
                "slips_agree": True,
                "timing": {"low": 1.0, "median": 2.0, "high": 3.0},
            }
        ],
        "call": 150.0,
        "omissions": [{"solver": "radau", "tolerance": 1e-2, "reason": "slow"}],
    }
    assert reference == {
        "solver": "taylor",
        "tolerance": 1e-15,
        "slips": [3, 4],
        "values": {},
        "floors": {FOOT: 1e-12, DEFORMATION: 1e-13},
        "checks": [
            {"solver": "radau", "tolerance": 1e-15, "differences": {FOOT: 2e-12, DEFORMATION: 1e-13}, "slips": 3},
            {"solver": "taylor", "tolerance": 1e-14, "differences": {FOOT: 4e-13}, "slips": 3},
        ],
    }
    assert made_up(comparable=False).to_dict()["compared"] == "statistics"


def test_a_work_precision_table_does_not_move():
    """Errors of a short run, to a tenth: what a changed kernel moves, and rounding does not."""
    rows = {(row.solver, row.tolerance): row for row in measure(Case(holds=30), rounds=1).rows}
    golden = {
        ("taylor", 1e-2): (2.215e-4, 1.637e-4),
        ("taylor", 1e-4): (3.151e-7, 8.634e-7),
        ("taylor", 1e-6): (6.022e-9, 3.257e-9),
        ("taylor", 1e-9): (3.145e-12, 4.985e-12),
        ("radau", 1e-2): (2.520e-4, 1.392e-4),
        ("radau", 1e-5): (3.336e-8, 1.751e-8),
        ("radau", 1e-8): (9.153e-11, 5.173e-11),
    }
    for key, (foot, deformation) in golden.items():
        assert rows[key].errors == pytest.approx({FOOT: foot, DEFORMATION: deformation}, rel=0.1)
        assert (rows[key].slips, rows[key].slips_agree) == (5, True)
