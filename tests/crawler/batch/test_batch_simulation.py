"""A batch that is simulated against its rows, each simulated alone: every number, to the last bit."""

import warnings
from threading import Event

import numpy as np
import pytest
from cases import crawlers, HUNT, random_crawler, schedules, starts
from hypothesis import given
from hypothesis import strategies as st

from stickslip.compiling.vectors import LANES
from stickslip.crawler import EnergyWarning, Groups, Scene, simulate, SolverError, State
from stickslip.crawler.batch import driving
from stickslip.crawler.model.columns import coefficients_of_each, units_of
from stickslip.crawler.model.state import coefficients_of
from stickslip.crawler.model.tube import as_crawler
from stickslip.crawler.motion import balance, progress
from stickslip.crawler.solvers import AUTO, choose, choose_for_each, NAMES

ARRAYS = (
    *("deformation", "velocity", "pressure", "foot", "foot_velocity", "segment_deformation", "segment_velocity"),
    *("valve", "slips", "work", "stored", "viscous_loss", "friction_loss", "energy_scale"),
)
LINEAR, STIFF = Groups(duffing=0.0, radial_coupling=0.0), Groups(damping_ratio=500.0)


def assert_same(batch, row, alone):
    """One row of a batch and the same crawler alone: equal bit for bit."""
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(batch, name)[row], getattr(alone, name), err_msg=f"{name} of {row}")
    time = batch.time if batch.time.ndim == 1 else batch.time[row]
    np.testing.assert_array_equal(time, alone.time)
    own = batch.events[batch.events["crawler"] == row]
    for field in ("time", "mode"):
        np.testing.assert_array_equal(own[field], alone.events[field])
    assert alone.model in batch.model
    if alone.condition is not None:
        assert batch.condition[row] == alone.condition


def assert_rows_are_single_runs(groups, valve, hold, scene, **options):
    batch = simulate(groups, valve, hold, scene=scene, **options)
    assert (np.diff(batch.events["crawler"]) >= 0).all()
    for row, of_row in enumerate(zip(groups, valve, hold, scene, strict=True)):
        options.pop("threads", None)
        assert_same(batch, row, simulate(*of_row[:3], scene=of_row[3], **options))
    return batch


def mixture(rng, n, *, tubes=True):
    """Groups, duty cycles, holds and scenes of n crawlers from anywhere in the ranges, some linear and some stiff."""
    groups, holds, scenes = [], [], []
    for k in range(n):
        own, _, hold, options = random_crawler(rng)
        groups.append([own, own, own, LINEAR, STIFF][k % 5])
        holds.append(hold)
        extras = {"slope": float(rng.choice([0.0, rng.uniform(-0.2, 0.2)])), "anchored": bool(rng.random() < 0.2)}
        extras["tube_mass"] = float(rng.uniform(0.0, 0.5)) if tubes and k % 7 == 0 else 0.0
        scenes.append(Scene(ratchet=options["scene"].ratchet, **extras))
    duties = rng.integers(0, 2, (n, 5)) * 1.0
    some = rng.random(duties.shape) < 0.3
    duties[some] = rng.random(np.count_nonzero(some))
    return groups, duties, holds, scenes


rows = st.tuples(
    crawlers,
    st.lists(st.sampled_from([0.0, 1.0, 0.5, 0.123]), min_size=4, max_size=4),
    st.floats(0.05, 3.0),
    st.builds(Scene, anchored=st.booleans(), ratchet=st.booleans(), slope=st.sampled_from([0.0, 0.1, -0.2])),
)


@HUNT
@given(
    members=st.lists(rows, min_size=1, max_size=LANES + 3),
    tolerance=st.sampled_from([1e-3, 1e-6, 1e-9, 1e-13]),
    samples=st.integers(1, 3),
    start=starts,
)
def test_any_rows(members, tolerance, samples, start):
    groups, duties, holds, scenes = map(list, zip(*members, strict=True))
    start = start._replace(foot_velocity=0.0)
    options = {"tolerance": tolerance, "samples_per_hold": samples, "initial": start}
    assert_rows_are_single_runs(groups, duties, holds, scenes, **options)


@HUNT
@given(groups=crawlers, valve=schedules, hold=st.floats(0.05, 5.0), start=starts, count=st.integers(2, LANES + 1))
def test_a_row_repeated_is_the_run(groups, valve, hold, start, count):
    scene = Scene(ratchet=start.foot_velocity >= 0.0)
    options = {"scene": scene, "initial": start, "solver": "taylor"}
    batch, alone = simulate(groups, [valve] * count, hold, **options), simulate(groups, valve, hold, **options)
    for row in range(count):
        assert_same(batch, row, alone)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-14])
def test_rows_from_anywhere_by_all_solvers(tolerance):
    rng = np.random.default_rng(int(-np.log10(tolerance)))
    batch = assert_rows_are_single_runs(*mixture(rng, 3 * LANES), tolerance=tolerance, samples_per_hold=2)
    assert all(name in batch.model for name in ("taylor", "radau", "closed form", "half the tube's mass"))
    assert len(batch.events) > 3 * LANES


def test_rows_one_by_one_where_their_condition_is_asked_for():
    rng = np.random.default_rng(5)
    assert_rows_are_single_runs(*mixture(rng, 6), tolerance=1e-6, condition=True)


def test_chains_beside_bodies_of_as_many_segments():
    rng = np.random.default_rng(6)
    groups, duties, holds, _ = mixture(rng, 5, tubes=False)
    groups = [Groups() if own == STIFF else own for own in groups]
    scenes = [Scene(segments=3, tube_mass=0.2 * (k % 2)) for k in range(5)]
    assert_rows_are_single_runs(groups, duties, holds, scenes, tolerance=1e-6)
    assert_rows_are_single_runs(groups, duties, holds, [Scene(segments=3)] * 5, tolerance=1e-6)


def test_threads_pauses_and_full_logs_change_nothing(monkeypatch):
    rng = np.random.default_rng(7)
    arguments = mixture(rng, 5 * LANES + 1)
    whole = simulate(*arguments[:3], scene=arguments[3], tolerance=1e-6, threads=1)
    monkeypatch.setattr(driving, "_LEAST_HOLDS", 0)
    monkeypatch.setattr(driving, "_CROWD", LANES)
    for threads in (2, 7):
        for steps, events in ((20_000, LANES), (1, 100), (3 * LANES, 16_384)):
            monkeypatch.setattr(progress, "PAUSE_AFTER", steps)
            monkeypatch.setattr(driving, "_EVENTS", events)
            parts = simulate(*arguments[:3], scene=arguments[3], tolerance=1e-6, threads=threads)
            for name in (*ARRAYS, "events"):
                np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))


@pytest.mark.parametrize("threads", [1, 3])
def test_the_first_row_that_fails_is_told_whatever_fails_first(monkeypatch, threads):
    monkeypatch.setattr(driving, "_LEAST_HOLDS", 0)
    monkeypatch.setattr(driving, "_CROWD", LANES)
    unbounded = Groups(duffing=0.0, radial_coupling=2.0)
    slow = Groups(duffing=0.0, radial_coupling=1.01)
    groups = [Groups()] * (4 * LANES)
    groups[LANES + 3], groups[LANES + 1], groups[3 * LANES] = unbounded, slow, unbounded
    arguments = {"tolerance": 1e-6, "solver": "taylor"}
    with pytest.raises(SolverError) as alone:
        simulate(slow, [1], 1e5, **arguments)
    with pytest.raises(SolverError) as caught:
        simulate(groups, [1], [1.0] * LANES + [1e5] * (3 * LANES), **arguments, threads=threads)
    assert str(caught.value) == f"crawler {LANES + 1}: {alone.value}"


def test_a_part_that_is_late_to_begin_still_tells_its_failure_before_those_of_later_rows(monkeypatch):
    def last_first(work, jobs, _threads):
        over = Event()
        return [work(job, over) for job in reversed(jobs)][::-1]

    monkeypatch.setattr(driving, "_LEAST_HOLDS", 0)
    monkeypatch.setattr(driving, "_CROWD", LANES)
    monkeypatch.setattr(driving, "share", last_first)
    groups = [Groups()] * (2 * LANES)
    groups[1] = groups[LANES + 3] = Groups(duffing=0.0, radial_coupling=2.0)
    with pytest.raises(SolverError, match=r"^crawler 1: "):
        simulate(groups, [1], 1e3, tolerance=1e-6, solver="taylor", threads=2)


def test_a_budget_is_each_rows_own():
    groups = [Groups(), Groups(damping_ratio=100.0)] * LANES
    arguments = {"solver": "taylor", "max_steps": 60}
    with pytest.raises(SolverError) as alone:
        simulate(groups[1], [0, 1, 1], 2.0, **arguments)
    with pytest.raises(SolverError) as caught:
        simulate(groups, [0, 1, 1], 2.0, **arguments)
    assert str(caught.value) == f"crawler 1: {alone.value}"
    simulate(groups[::2], [0, 1, 1], 2.0, **arguments)


def test_energies_that_do_not_add_up_are_told_row_by_row(monkeypatch):
    monkeypatch.setattr(balance, "_TOLERANCES", 0.0)
    monkeypatch.setattr(balance, "_ROUNDINGS", 0.0)
    groups = [Groups(), Groups(deborah=0.3), Groups(duffing=2.0)]
    expected = []
    for row, own in enumerate(groups):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", EnergyWarning)
            simulate(own, [1, 0, 1], 1.0)
        expected += [f"crawler {row}: {one.message}" for one in caught]
    assert len(expected) == 3
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", EnergyWarning)
        simulate(groups, [1, 0, 1], 1.0)
    assert [str(one.message) for one in caught] == expected
    assert {one.filename for one in caught} == {__file__}
    # Of a batch that fails, those before the row that does: what rows alone, one after the other, would have told.
    spent = Groups(damping_ratio=100.0)
    groups = [*groups[:2], spent, groups[2], spent]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", EnergyWarning)
        with pytest.raises(SolverError, match=r"^crawler 2: "):
            simulate(groups, [0, 1, 1], 2.0, solver="taylor", max_steps=60)
    assert [str(one.message).partition(":")[0] for one in caught] == ["crawler 0", "crawler 1"]


def test_packed_coefficients_and_choices_are_those_of_each():
    rng = np.random.default_rng(8)
    groups, _, holds, scenes = mixture(rng, 60)
    bodies, grounds, units = units_of(groups, scenes)
    columns = coefficients_of_each(bodies, grounds)
    for column, own, scene, unit in zip(columns.T, groups, scenes, units, strict=True):
        *body, expected = as_crawler(own, scene)
        np.testing.assert_array_equal(column, np.array(coefficients_of(*body), float))
        assert unit == expected
    for tolerance in (1e-3, 1e-9):
        choices = choose_for_each(AUTO, groups, scenes, columns, np.array(holds), units, tolerance)
        for choice, *one in zip(choices.tolist(), groups, scenes, holds, strict=True):
            assert NAMES[choice] == choose(AUTO, *one, tolerance).name
    assert len(set(choices.tolist())) == 3
    with pytest.raises(ValueError, match=r"solver 'closed_form' needs (duffing|radial_coupling) to be 0, got"):
        choose_for_each("closed_form", groups, scenes, columns, np.array(holds), units, 1e-6)


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        ({"hold": [1.0, 2.0, 3.0]}, ValueError, r"groups, valve and hold must have as many rows, got 2, 2 and 3"),
        ({"scene": [None]}, ValueError, r"groups, valve and scene must have as many rows, got 2, 2 and 1"),
        ({"hold": [1.0, 0.0]}, ValueError, r"hold of crawler 1 must be in \(0, inf\), got 0\.0"),
        ({"hold": [1.0, np.inf]}, ValueError, r"hold"),
        ({"hold": [[1.0, 2.0]]}, ValueError, r"hold"),
        ({"hold": ["a", "b"]}, TypeError, r"hold"),
        ({"scene": [None, 3]}, TypeError, r"scene.*got 3"),
        (
            {"scene": [{"segments": 2}, None]},
            ValueError,
            r"same segments in all rows, got \[1, 2\]",
        ),
        ({"threads": 0}, ValueError, r"threads must be.*>= 1, got 0"),
        ({"threads": 1.5}, TypeError, r"threads"),
    ],
)
def test_refuses_rows_that_do_not_match(change, error, says):
    arguments = {"groups": [Groups()] * 2, "valve": [[1], [0]], "hold": 1.0} | change
    with pytest.raises(error, match=says):
        simulate(arguments.pop("groups"), arguments.pop("valve"), arguments.pop("hold"), **arguments)


def test_scenes_or_holds_alone_make_a_batch():
    two = simulate(Groups(), [1, 0], 1.0, scene=[None, {"slope": 0.1}])
    assert_same(two, 1, simulate(Groups(), [1, 0], 1.0, scene=Scene(slope=0.1)))
    holds = np.array([1.0, 0.3])
    two = simulate("linear", [1, 0], holds)
    holds[:] = 7.0
    assert_same(two, 1, simulate("linear", [1, 0], 0.3))
    assert two.hold.tolist() == [1.0, 0.3]
    assert "holds of 0.3 to 1 t_c" in repr(two)
    assert len(simulate("linear", [1, 0], [2.0], initial=State(0.5)).slips) == 1
