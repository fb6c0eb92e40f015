"""A foot that nothing holds turns round for ever: turns above the tolerance are events, and those below are not."""

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from cases import assert_agrees, run
from chain_judge import chain_judge
from modal_judge import LinearMotion, modal_judge

from stickslip.crawler import Groups, Scene, simulate, SolverError, State
from stickslip.crawler.model.state import FORWARD

FREE = Scene(ratchet=False)
LINEAR = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=0.2, static_friction=0.0, kinetic_friction=0.0)
NONLINEAR = Groups(static_friction=0.0, kinetic_friction=0.0)
START = State(deformation=0.5)
SOLVERS = ("closed_form", "taylor", "radau")
# Largest rate of the body between two turns, in tolerances, above which they are counted and below which they are not.
ABOVE, BELOW = 10.0, 1.0


@pytest.fixture(scope="module")
def judged():
    """Moments of the foot's events, and the largest speed of the body after each until the next, in 60 digits."""
    verdict = modal_judge(LINEAR, [0], 60.0, scene=FREE, initial=START)
    with mp.workdps(60):
        smooth = LinearMotion(LINEAR, FREE, FORWARD, *START[:3], 0)
        moments = [mp.mpf(str(moment)) for moment, _ in verdict.events]
        moments.append(moments[-1] + 1)
        peaks = [
            max(abs(smooth.derivative(one + (two - one) * i / 20, 1)) for i in range(21))
            for one, two in pairwise(moments)
        ]
    motions = [motion for _, motion in verdict.events]
    return np.array(moments[:-1], float), motions, np.array(peaks, float)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("solver", SOLVERS)
def test_turns_are_those_of_the_judge_while_the_swing_is_above_the_tolerance(judged, solver, tolerance):
    moments, motions, peaks = judged
    done = run(LINEAR, [0], 60.0, scene=FREE, initial=START, solver=solver, tolerance=tolerance)
    sure = np.count_nonzero(peaks > ABOVE * tolerance)
    assert sure >= 3
    assert sure <= len(done.events) <= np.count_nonzero(peaks > BELOW * tolerance)
    assert done.events["mode"].tolist() == motions[: len(done.events)]
    # It has turned when it is faster than some tolerances.
    late = done.events["time"] - moments[: len(done.events)]
    assert (late >= -100.0 * tolerance).all()
    assert late[0] <= tolerance
    assert (late[1:sure] <= 10.0 * tolerance / peaks[1:sure]).all()
    assert done.slips == 1


@pytest.mark.parametrize("solver", SOLVERS)
def test_without_damping_every_half_period_is_a_turn(solver):
    groups = Groups(**LINEAR.to_dict() | {"damping_ratio": 0.0})
    r = groups.foot_mass_fraction
    frequency = 1.0 / np.sqrt(r * (1.0 - r))
    done = run(groups, [0], 300.5, scene=FREE, initial=START, solver=solver, samples_per_hold=601)
    turns = np.arange(1 + int(300.5 * frequency / np.pi)) * np.pi / frequency
    np.testing.assert_allclose(done.events["time"], turns, rtol=0, atol=1e-6)
    swing = START.deformation * np.cos(frequency * done.time)
    np.testing.assert_allclose(done.deformation, swing, rtol=0, atol=1e-6)
    # The centre of mass stays where it is, whichever way the foot goes.
    centre = done.foot + (1.0 - r) * done.deformation
    np.testing.assert_allclose(centre, (1.0 - r) * START.deformation, rtol=0, atol=1e-12)
    np.testing.assert_allclose(done.foot_velocity, -(1.0 - r) * done.velocity, rtol=0, atol=1e-12)


@pytest.mark.parametrize("solver", SOLVERS)
def test_turns_do_not_depend_on_how_time_is_cut_into_holds(solver):
    options = {"scene": FREE, "initial": START, "solver": solver}
    whole = run(LINEAR, [0], 60.0, **options)
    pieces = run(LINEAR, [0] * 2400, 0.025, **options)
    assert pieces.events["mode"].tolist() == whole.events["mode"].tolist()
    np.testing.assert_allclose(pieces.events["time"], whole.events["time"], rtol=0, atol=1e-3)
    assert pieces.foot[-1] == pytest.approx(whole.foot[-1], abs=1e-9)


@pytest.mark.parametrize("solver", ["taylor", "radau"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
@pytest.mark.parametrize("valve", [[0], [1, 0, 1, 1]], ids=str)
def test_a_long_hold_costs_what_its_oscillations_cost(solver, tolerance, valve):
    options = {"solver": solver, "tolerance": tolerance}
    # So fast that it never stops: the body moves alike, and nothing happens to the foot.
    smooth = _steps(NONLINEAR, valve, 3e3, initial=START._replace(foot_velocity=9.0), **options)
    done = simulate(NONLINEAR, valve, 3e3, scene=FREE, initial=START, **options)
    turning = _steps(NONLINEAR, valve, 3e3, scene=FREE, initial=START, **options)
    assert turning <= 1.1 * smooth + 4 * len(done.events) + 10
    assert len(done.events) < 80 * len(valve)


def _steps(*args, **options):
    """The least budget with which a run finishes."""
    enough = 1
    while not _finishes(*args, **options, max_steps=enough):
        enough *= 2
    short = enough // 2
    while enough - short > 1:
        middle = (short + enough) // 2
        short, enough = (short, middle) if _finishes(*args, **options, max_steps=middle) else (middle, enough)
    return enough


def _finishes(*args, **options):
    try:
        simulate(*args, **options)
    except SolverError:
        return False
    return True


def test_a_chain_turns_as_its_judge_says_and_not_beyond_the_tolerance():
    scene = Scene(ratchet=False, segments=3, tube_mass=0.2)
    options = {"scene": scene, "initial": START, "samples_per_hold": 8}
    judged, *_ = chain_judge(NONLINEAR, [1, 0], 4.0, **options)
    done = run(NONLINEAR, [1, 0], 4.0, **options)
    assert_agrees(done, judged, atol=1e-7)
    assert len(done.events) > 5
    fading = {"scene": scene, "initial": START, "solver": "taylor"}
    coarse, fine = (run(NONLINEAR, [0], 400.0, tolerance=tolerance, **fading) for tolerance in (1e-6, 1e-9))
    assert coarse.events["mode"].tolist() == fine.events["mode"].tolist()[: len(coarse.events)]
    assert coarse.events["time"][-1] < fine.events["time"][-1] < 150.0
