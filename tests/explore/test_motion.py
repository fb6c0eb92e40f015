"""The data of the figures are those of the motion."""

import numpy as np
import pytest

from stickslip import simulate
from stickslip.explore.motion import events_of, samples_of, shown, shown_holds, trace_of, WHAT
from stickslip.explore.presets import preset
from stickslip.explore.setup import NUMBERS, Setup, setup_of
from stickslip.train.schedules import repeat


def force(groups, trace):
    """The pull of the body, from its definition."""
    z, v, p = trace["deformation"], trace["velocity"], trace["pressure"]
    return p * (1 + groups.radial_coupling * z) - z - groups.duffing * z**3 - 2 * groups.damping_ratio * v


def test_a_trace_is_the_motion_of_the_flipped_word_from_rest():
    setup = setup_of({"word": "110", "duffing": 1.0, "slope": 0.05, "hold": 0.8, "tolerance": 1e-10})
    what = shown(setup)
    trace = trace_of(setup, what)
    command, valve = repeat("110", 30, dither=0.1, seed=0)
    alone = simulate(
        {"duffing": 1.0}, valve, 0.8, scene={"slope": 0.05}, tolerance=1e-10, samples_per_hold=samples_of(0.8)
    )
    for name in ("time", "deformation", "velocity", "pressure", "foot", "payload"):
        np.testing.assert_array_equal(trace[name][1:], getattr(alone, name))
        assert trace[name][0] == 0.0
    per_hold = samples_of(0.8)
    np.testing.assert_array_equal(trace["valve"][1::per_hold], valve)
    np.testing.assert_array_equal(trace["flipped"][1::per_hold], valve != command)
    assert 0 < trace["flipped"].sum() < len(trace["time"])


def test_the_foot_slides_where_it_moves_and_is_drawn_so():
    setup = preset("clean-gait")
    trace = trace_of(setup, shown(setup))
    slides = trace["sliding"] > 0
    moved = np.diff(trace["foot"]) > 0
    # Between two samples it may begin or end; within a slide and within a rest there is no doubt.
    assert moved[slides[1:] & slides[:-1]].all()
    assert not moved[~slides[1:] & ~slides[:-1]].any()
    assert 0.3 < slides.mean() < 0.9
    for name in ("foot", "velocity"):
        drawn = ~np.isnan(trace[f"{name}_sliding"])
        np.testing.assert_array_equal(trace[f"{name}_sliding"][drawn], trace[name][drawn])
        np.testing.assert_array_equal(drawn, slides | np.append(slides[1:], False))


def test_the_foot_breaks_loose_at_the_static_friction_and_takes_turns():
    setup = preset("clean-gait")
    what = shown(setup)
    trace, events = trace_of(setup, what), events_of(setup, what)
    loose = events["what"] == WHAT[0]
    assert loose[::2].all()
    assert not loose[1::2].any()
    assert loose.sum() == what.motion.slips > 5
    pull = np.interp(events["time"], trace["time"], force(setup.groups, trace))
    np.testing.assert_allclose(pull[loose], -setup.groups.static_friction, atol=2e-3)
    still = np.interp(events["time"][1::2] + 0.01, trace["time"], trace["foot"])
    np.testing.assert_allclose(events["foot"][1::2], still, atol=1e-3)


def test_si_is_the_trajectory_s_own():
    natural, si = (setup_of({"units": units, "deborah": 0.4}) for units in ("natural", "SI"))
    what = shown(si)
    from stickslip.explore.units import actuator_with

    own = what.motion.in_si(actuator_with(si.groups))
    trace = trace_of(si, what)
    for name, scale in (("time", 1.0), ("deformation", 1e3), ("velocity", 1e3), ("foot", 1e3), ("pressure", 1e-3)):
        np.testing.assert_allclose(trace[name][1:], scale * getattr(own, name), rtol=1e-13)
    np.testing.assert_allclose(events_of(si, what)["time"], own.events["time"], rtol=1e-13)
    np.testing.assert_array_equal(trace_of(natural, shown(natural))["sliding"], trace["sliding"])


def test_a_policy_answers_to_what_it_sees():
    setup = preset("speed-policy")
    what = shown(setup)
    valve = what.motion.valve
    assert 1 <= (valve != what.command).sum() <= 12
    bent = shown(setup_of({"duffing": 4.0}, setup))
    assert (bent.command != what.command).any()
    assert shown(setup_of({"dither": 0.0}, setup)).motion.foot[-1] > what.motion.foot[-1]


def test_the_space_bar_s_motion_is_of_its_bits_and_its_end_is_shown():
    setup = Setup(drive="live")
    bits = ([1, 1, 1, 0, 0] * 20)[:97]
    whole = simulate({}, bits, 0.5, samples_per_hold=samples_of(0.5))
    trace = trace_of(setup, shown(setup, bits))
    length = shown_holds(0.5) * samples_of(0.5) + 1
    np.testing.assert_array_equal(trace["foot"], whole.foot[-length:])
    np.testing.assert_array_equal(trace["time"], whole.time[-length:])
    events = events_of(setup, shown(setup, bits))
    assert trace["time"][0] <= events["time"].min()
    assert events["time"].max() <= trace["time"][-1]


@pytest.mark.parametrize("hold", [NUMBERS["hold"].low, 0.3, 1.0, NUMBERS["hold"].high])
def test_what_is_drawn_is_neither_sparse_nor_endless(hold):
    assert 12 <= shown_holds(hold) <= 240
    assert 480 <= shown_holds(hold) * samples_of(hold) <= 1440
    assert hold / samples_of(hold) <= 0.1
