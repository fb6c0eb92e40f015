"""A valve that turns within its hold, against the same motion in as many shorter holds as it takes."""

import matplotlib as mpl
import numpy as np
import pytest
from cases import assert_agrees, crawlers, HUNT, random_crawler, starts
from chain_judge import chain_judge
from hypothesis import given
from hypothesis import strategies as st
from judge import judge
from modal_judge import modal_judge

from stickslip.crawler import Groups, Scene, simulate, SolverError, State

mpl.use("agg")

SAMPLED = ("deformation", "velocity", "pressure", "foot", "foot_velocity", "segment_deformation", "segment_velocity")
ENERGIES = ("work", "stored", "viscous_loss", "friction_loss")
LINEAR = Groups.of("linear")
SCENES = [Scene(), Scene(ratchet=False), Scene(anchored=True), Scene(slope=-0.2), Scene(segments=3, tube_mass=0.3)]


def finely(counts, of):
    """The schedule of integers, `of` to a hold, whose open parts are those counts."""
    return np.concatenate([np.arange(of) < count for count in counts]).astype(int)


def assert_same_motion(coarse, fine, every, atol):
    """Samples at the ends of the coarse schedule's holds, energies, and events by number, kind and time."""
    for name in SAMPLED:
        ours, theirs = getattr(coarse, name), getattr(fine, name)[..., every - 1 :: every]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=atol, err_msg=name)
    for name in ENERGIES:
        assert getattr(coarse, name) == pytest.approx(getattr(fine, name), abs=10 * atol)
    np.testing.assert_array_equal(coarse.events["mode"], fine.events["mode"])
    np.testing.assert_allclose(coarse.events["time"], fine.events["time"], rtol=0, atol=10 * atol)


@pytest.mark.parametrize("solver", ["taylor", "radau"])
@pytest.mark.parametrize("scene", SCENES[:4], ids=str)
def test_a_nonlinear_crawler_against_the_judge(solver, scene):
    counts, of, hold = [3, 0, 1, 4, 2, 4, 1], 4, 1.3
    valve = np.array(counts) / of
    done = simulate(Groups(), valve, hold, scene=scene, solver=solver, tolerance=1e-11, samples_per_hold=of)
    assert_agrees(done, judge(Groups(), finely(counts, of), hold / of, scene=scene), atol=1e-8)


@pytest.mark.parametrize("scene", SCENES[:4], ids=str)
def test_a_linear_crawler_against_its_modes(scene):
    counts, of, hold = [3, 0, 1, 5, 2, 5, 1], 5, 1.3
    done = simulate(LINEAR, np.array(counts) / of, hold, scene=scene, solver="closed_form", samples_per_hold=of)
    assert_agrees(done, modal_judge(LINEAR, finely(counts, of), hold / of, scene=scene), atol=1e-12)


def test_a_chain_against_newtons_law():
    counts, of, hold, scene = [3, 0, 1, 4], 4, 1.7, SCENES[-1]
    done = simulate(Groups(), np.array(counts) / of, hold, scene=scene, tolerance=1e-11, samples_per_hold=of)
    verdict, stretch, rate = chain_judge(Groups(), finely(counts, of), hold / of, scene=scene)
    assert_agrees(done, verdict, atol=1e-8)
    np.testing.assert_allclose(done.segment_deformation, stretch, rtol=0, atol=1e-8)
    np.testing.assert_allclose(done.segment_velocity, rate, rtol=0, atol=1e-8)


@HUNT
@given(
    groups=crawlers,
    counts=st.lists(st.integers(0, 6), min_size=1, max_size=5),
    hold=st.floats(0.05, 3.0),
    initial=starts,
    solver=st.sampled_from(["taylor", "radau"]),
)
def test_a_duty_cycle_is_as_many_shorter_holds(groups, counts, hold, initial, solver):
    """The samples and the energies; what a rounding decides of a graze is not asked for."""
    options = {"initial": initial, "solver": solver, "tolerance": 1e-12}
    coarse = simulate(groups, np.array(counts) / 6, hold, samples_per_hold=2, **options)
    fine = simulate(groups, finely(counts, 6), hold / 6, **options)
    np.testing.assert_allclose(coarse.pressure, fine.pressure[2::3], rtol=0, atol=1e-13)
    if coarse.slips == fine.slips:
        for name in ("deformation", "foot"):
            np.testing.assert_allclose(getattr(coarse, name), getattr(fine, name)[2::3], rtol=0, atol=1e-6)
    assert abs(coarse.energy_residual) < 1e-8 * (1.0 + coarse.dissipation)


@pytest.mark.parametrize("seed", range(24))
def test_linear_crawlers_from_anywhere_in_the_ranges(seed):
    rng = np.random.default_rng(seed)
    groups, _, hold, options = random_crawler(rng)
    linear = Groups(**{**groups.to_dict(), "duffing": 0.0, "radial_coupling": 0.0})
    options.pop("samples_per_hold")
    counts = rng.integers(0, 4, 6)
    coarse = simulate(linear, counts / 3, hold, samples_per_hold=3, **options)
    fine = simulate(linear, finely(counts, 3), hold / 3, **options)
    assert_same_motion(coarse, fine, 1, 1e-10 * (1.0 + np.abs(fine.foot).max()))


@pytest.mark.parametrize("groups", [Groups(), LINEAR])
@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_the_valve_turns_at_that_very_instant(groups, scene):
    """Any duty cycle, none of them a fraction that a schedule of equal holds could meet: hold by hold, part by part."""
    duties, hold = [0.123456789, 1 / np.pi, 0.999999, 1e-9], 0.9
    whole = simulate(groups, duties, hold, scene=scene, tolerance=1e-13)
    state, stretches = None, []
    for duty in duties:
        for command, length in ((1, duty * hold), (0, hold - duty * hold)):
            part = simulate(groups, [command], length, scene=scene, tolerance=1e-13, initial=state)
            state = part.final_state
        stretches.append([part.deformation[-1], part.velocity[-1], part.pressure[-1], part.foot[-1]])
    ours = np.array([whole.deformation, whole.velocity, whole.pressure, whole.foot])
    np.testing.assert_allclose(ours.T, stretches, rtol=0, atol=1e-10)


@pytest.mark.parametrize("groups", [Groups(), LINEAR, Groups(damping_ratio=50.0)])
@pytest.mark.parametrize("scene", [Scene(), Scene(segments=2, tube_mass=0.3)], ids=str)
def test_full_and_empty_duty_cycles_are_the_open_and_the_shut_valve_bit_for_bit(groups, scene):
    word = [1, 1, 0, 1, 0, 0]
    for whole in (word, np.array(word, bool), np.array(word, np.int8)):
        states = simulate(groups, whole, 0.7, scene=scene, samples_per_hold=3)
        duties = simulate(groups, np.array(word, float), 0.7, scene=scene, samples_per_hold=3)
        assert states.valve.dtype == np.int8
        assert duties.valve.dtype == np.float64
        for name in (*SAMPLED, *ENERGIES, "time", "events", "slips"):
            np.testing.assert_array_equal(getattr(states, name), getattr(duties, name))


@pytest.mark.parametrize("duty", [5e-324, 1e-300, 1e-17, 0.5, 1 - 2**-53, 1 / 3])
@pytest.mark.parametrize("groups", [Groups(), LINEAR, Groups(damping_ratio=50.0)])
@pytest.mark.parametrize("solver", ["auto", "radau"])
def test_every_sample_is_taken_once_wherever_the_valve_turns(groups, duty, solver):
    """At a sample's own instant, too, and within rounding of the hold's ends."""
    done = simulate(groups, [duty] * 3, 0.3, samples_per_hold=6, solver=solver, tolerance=1e-10)
    np.testing.assert_allclose(done.time, 0.3 * np.arange(1, 19) / 6, rtol=1e-15)
    pressure, expected = 0.0, []
    for _ in range(3):
        top = 1.0 + (pressure - 1.0) * np.exp(-duty * 0.3 / groups.deborah)
        for moment in 0.05 * np.arange(1, 7):
            since = moment - duty * 0.3
            rising = 1.0 + (pressure - 1.0) * np.exp(-moment / groups.deborah)
            expected.append(rising if since <= 0 else top * np.exp(-since / groups.deborah))
        pressure = expected[-1]
    np.testing.assert_allclose(done.pressure, expected, rtol=0, atol=1e-14)
    assert abs(done.energy_residual) < 1e-9


def test_a_batch_of_duty_cycles_is_each_by_itself():
    duties = np.random.default_rng(0).random((3, 8))
    batch = simulate(Groups(), duties, 0.5, samples_per_hold=2)
    for row, member in zip(batch.foot, duties, strict=True):
        np.testing.assert_array_equal(row, simulate(Groups(), member, 0.5, samples_per_hold=2).foot)


def test_a_spent_budget_is_told_with_the_time_since_the_start():
    """Here it is spent in the shut part of the second hold, after 150."""
    with pytest.raises(SolverError, match=r"budget of 250 was spent at time 1[5-9]\d\."):
        simulate(Groups(), [0.25, 0.5], 100.0, solver="taylor", max_steps=250, initial=State(deformation=0.5))


def test_the_figure_shows_when_the_valve_is_open():
    figure = simulate(Groups(), [0.25, 1.0, 0.0], 2.0).plot()
    stairs = figure.axes[-1].patches[0].get_data()
    parts = zip(stairs.edges, stairs.edges[1:], stairs.values, strict=False)
    assert [(left, right) for left, right, value in parts if value and left < right] == [(0.0, 0.5), (2.0, 4.0)]
