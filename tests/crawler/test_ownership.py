"""What `simulate` takes stays the caller's, and what it returns is the caller's own."""

import numpy as np
import pytest

from stickslip.crawler import Actuator, ChainState, Groups, REST, simulate, State

CHAIN = {"segments": 3, "tube_mass": 0.3}
WORD = [1, 1, 0, 1, 0, 0]
ARRAYS = ("time", "deformation", "velocity", "pressure", "foot", "foot_velocity", "valve", "events")
KINDS = {
    "closed_form": {"groups": "linear", "solver": "closed_form"},
    "taylor": {"groups": {}, "solver": "taylor"},
    "radau": {"groups": {}, "solver": "radau"},
    "chain": {"groups": {}, "scene": CHAIN},
}


def copies(trajectory):
    """All arrays of a trajectory, as they are now."""
    names = (*ARRAYS, "segment_deformation", "segment_velocity")
    return {name: getattr(trajectory, name).copy() for name in names}


def assert_unchanged(trajectory, before):
    for name, values in before.items():
        np.testing.assert_array_equal(getattr(trajectory, name), values, err_msg=name)


@pytest.mark.parametrize("kind", [np.int8, np.int64, np.float64, np.float32, bool])
@pytest.mark.parametrize("rows", [None, 2])
def test_a_schedule_that_the_caller_changes_later(kind, rows):
    given = np.array(WORD if rows is None else [WORD] * rows, dtype=kind)
    kept = given.copy()
    done = simulate({}, given, 1.0)
    np.testing.assert_array_equal(given, kept)
    given[...] = 0
    np.testing.assert_array_equal(done.valve, kept)
    assert done.valve.dtype == (np.float64 if np.dtype(kind).kind == "f" else np.int8)


def test_one_schedule_for_many_crawlers_is_each_ones_own():
    given = np.array(WORD)
    batch = simulate([{}, {"duffing": 1.0}, {"duffing": 2.0}], given, 1.0)
    batch.valve[0] = 7
    np.testing.assert_array_equal(batch.valve[1:], [WORD, WORD])
    np.testing.assert_array_equal(given, WORD)


def test_a_list_of_groups_that_the_caller_changes_later():
    given = [Groups(), Groups(duffing=2.0)]
    batch = simulate(given, WORD, 1.0)
    given[0] = Groups(duffing=9.0)
    assert batch.groups == (Groups(), Groups(duffing=2.0))
    mapping = {"duffing": 3.0}
    done = simulate(mapping, WORD, 1.0)
    mapping["duffing"] = 9.0
    assert done.groups == Groups(duffing=3.0)


def test_a_chain_state_that_the_caller_changes_later():
    stretch, rate = np.array([0.1, 0.2, 0.3]), np.array([0.0, -0.1, 0.1])
    start = ChainState(stretch, rate, 0.5)
    done = simulate({}, WORD, 1.0, scene=CHAIN, initial=start)
    again = simulate({}, WORD, 1.0, scene=CHAIN, initial=start)
    np.testing.assert_array_equal(done.foot, again.foot)
    np.testing.assert_array_equal(stretch, [0.1, 0.2, 0.3])
    stretch[:] = rate[:] = 9.0
    np.testing.assert_array_equal(done.initial.segment_deformation, [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(done.initial.segment_velocity, [0.0, -0.1, 0.1])


def test_members_of_a_batch_of_chains_all_start_alike():
    start = ChainState([0.1, 0.2, 0.3], [0.0, -0.1, 0.1], 0.5)
    batch = simulate([{}, {}], WORD, 1.0, scene=CHAIN, initial=start)
    np.testing.assert_array_equal(batch.segment_deformation[0], batch.segment_deformation[1])
    np.testing.assert_array_equal(batch.foot[0], batch.foot[1])


@pytest.mark.parametrize("kind", KINDS)
def test_a_trajectory_is_not_touched_by_the_next_run(kind):
    arguments = dict(KINDS[kind])
    groups = arguments.pop("groups")
    first = simulate(groups, WORD, 1.0, **arguments)
    before = copies(first)
    other = simulate(groups, WORD[::-1], 0.7, initial=State(0.5, -0.2, 0.3, 1.0, 0.4), **arguments)
    for name, values in copies(other).items():
        getattr(other, name)[...] = np.zeros_like(values)
    assert_unchanged(first, before)
    assert_unchanged(simulate(groups, WORD, 1.0, **arguments), before)
    assert State(0.0, 0.0, 0.0, 0.0, 0.0) == REST


@pytest.mark.parametrize("rows", [1, 3])
def test_arrays_may_be_written_and_rows_share_nothing(rows):
    done = simulate([{}] * rows, WORD, 1.0, samples_per_hold=2)
    for name in ARRAYS[1:]:
        array = getattr(done, name)
        before = {other: getattr(done, other).copy() for other in ARRAYS if other != name}
        array[0] = np.zeros_like(array[0])
        for other, values in before.items():
            np.testing.assert_array_equal(getattr(done, other), values, err_msg=f"{other} after {name}")


@pytest.mark.parametrize("kind", KINDS)
def test_a_final_state_is_a_copy(kind):
    arguments = dict(KINDS[kind])
    done = simulate(arguments.pop("groups"), WORD, 1.0, **arguments)
    state, expected = done.final_state, simulate(KINDS[kind]["groups"], WORD, 1.0, **arguments).final_state
    for name in (*ARRAYS, "segment_deformation", "segment_velocity"):
        array = getattr(done, name)
        array[...] = np.zeros_like(array)
    for value, other in zip(state, expected, strict=True):
        np.testing.assert_array_equal(value, other)
        assert np.any(np.asarray(other) != 0.0) or value == 0.0


def test_a_trajectory_in_si_shares_no_motion_with_the_natural_one():
    done = simulate({}, WORD, 1.0, initial=State(0.1, 0.0, 0.5, 1.0, 0.2))
    before = copies(done)
    si = done.in_si(Actuator.ecoflex())
    for name in ("time", "deformation", "velocity", "pressure", "foot", "foot_velocity", "events"):
        array = getattr(si, name)
        array[...] = np.zeros_like(array)
    assert_unchanged(done, before)
    assert done.initial == State(0.1, 0.0, 0.5, 1.0, 0.2)


def test_rows_of_a_batch_keep_their_place():
    """Every kind of number of every row is that of the row alone, where no two rows are alike."""
    members = [{"duffing": 0.1 * i, "deborah": 0.3 + 0.1 * i, "static_friction": 0.25 + 0.02 * i} for i in range(5)]
    members[3] = {"duffing": 0.0, "radial_coupling": 0.0}
    rng = np.random.default_rng(3)
    schedules = rng.integers(0, 2, (5, 12))
    options = {"samples_per_hold": 2, "condition": True, "initial": State(0.3, 0.1, 0.5, 2.0, 0.2)}
    batch = simulate(members, schedules, 1.1, **options)
    assert len({tuple(row) for row in schedules.tolist()}) == 5
    for row, (groups, schedule) in enumerate(zip(members, schedules, strict=True)):
        alone = simulate(groups, schedule, 1.1, **options)
        for name in (*ARRAYS[1:-1], "slips", "work", "stored", "viscous_loss", "friction_loss", "energy_scale"):
            np.testing.assert_array_equal(getattr(batch, name)[row], getattr(alone, name), err_msg=name)
        np.testing.assert_array_equal(batch.segment_deformation[row], alone.segment_deformation)
        own = batch.events[batch.events["crawler"] == row]
        np.testing.assert_array_equal(own[["time", "mode"]], alone.events[["time", "mode"]])
        assert batch.condition[row] == alone.condition
        assert batch.groups[row] == alone.groups
    assert (np.diff(batch.events["crawler"]) >= 0).all()
