"""Slips that nothing brakes: without kinetic friction an overdamped foot's speed fades, in floats to exactly 0."""

import numpy as np
import pytest
from cases import run
from lane_batches import alone, Batch, taylor
from modal_judge import modal_judge

from stickslip.crawler import ChainState, Groups, Scene, simulate, State
from stickslip.crawler.model.state import BACKWARD, Body, coefficients_of, FORWARD, STUCK
from stickslip.crawler.solvers import SOLVERS

FADING = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=0.05, foot_mass_fraction=1e-3, kinetic_friction=0.0)
SYMMETRIC = Scene(ratchet=False)
STIFF = Groups(damping_ratio=0.5, foot_mass_fraction=1e-2, kinetic_friction=0.0)


@pytest.mark.parametrize("solver", ["auto", "closed_form", "taylor", "radau"])
def test_a_speed_that_fades_to_nothing_is_no_fresh_slip(solver):
    # Of the closed form it is exactly 0 at the end of the first hold. The opening valve then pushes the foot back.
    done = run(FADING, [0, 1, 0, 1, 0], 56.8, initial=State(deformation=1.0), solver=solver)
    assert done.foot[-1] == pytest.approx(180.6660175752, abs=1e-8)
    assert done.slips == 3
    assert abs(done.energy_residual) < 1e-10


@pytest.mark.parametrize("scene", [Scene(), SYMMETRIC], ids=str)
@pytest.mark.parametrize(
    ("valve", "hold", "start"),
    [
        ([0, 1, 0, 1, 0], 20.0, 1.0),  # faded to 1e-99
        ([0, 1, 0, 1, 0], 56.8, 1.0),  # to 0
        ([0, 1, 0], 70.0, -1.0),
        ([1, 0, 1], 70.0, 2.0),
        ([1, 0, 1], 70.0, 0.5),
        ([0.5, 0.5], 140.0, 1.0),  # a hold open and one shut
    ],
)
def test_what_follows_is_what_the_judge_says(scene, valve, hold, start):
    initial = State(deformation=start)
    done = simulate(FADING, valve, hold, scene=scene, initial=initial)
    halves = [half for duty in valve for half in ([1, 0] if duty == 0.5 else [duty] * 2)]
    verdict = modal_judge(FADING, halves, hold / 2, scene=scene, initial=initial)
    np.testing.assert_allclose(done.foot, verdict.foot[1::2], rtol=0, atol=1e-9)
    np.testing.assert_allclose(done.deformation, verdict.deformation[1::2], rtol=0, atol=1e-9)
    assert done.slips == verdict.slips


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    ("motion", "opened", "valve"),
    [(FORWARD, 0.0, 0), (FORWARD, 1.0, 1), (BACKWARD, 0.0, 0), (FORWARD, 0.0, 1), (BACKWARD, 1.0, 0)],
)
def test_a_faded_foot_is_one_at_rest(solver, motion, valve, opened):
    coefficients, method = coefficients_of(FADING, SYMMETRIC), SOLVERS[solver]

    def end(motion, speed):
        body = Body(opened, 0.0, opened, 0.0, motion * speed, motion, 0)
        workspace = method.workspace(coefficients, 0.7, 3)
        return alone(body, coefficients, float(valve), 0.7, method.options(1e-12), np.empty((5, 3)), workspace).body

    flush_to_zero, resting = end(motion, 0.0), end(STUCK, 0.0)
    np.testing.assert_allclose(flush_to_zero, resting, rtol=0, atol=1e-10)
    if valve != opened:  # the turning valve brakes what still moves
        np.testing.assert_allclose(end(motion, 1e-200), resting, rtol=0, atol=1e-10)


@pytest.mark.parametrize("groups", [FADING, STIFF])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-13])
def test_faded_feet_in_lanes(groups, tolerance):
    starts = [(motion, opened) for motion in (STUCK, FORWARD, BACKWARD) for opened in (0.0, 1.0)]
    bodies = np.array([[opened, 0.0, opened, 0.0, 0.0, motion, 0] for motion, opened in starts] * 2).T
    batch = Batch([(groups, SYMMETRIC)] * len(bodies.T), bodies)
    for k in range(4):
        batch.advance([(i // len(starts) + k) % 2 for i in range(len(bodies.T))], 0.7, taylor(tolerance))


def test_it_goes_on_from_a_state_that_has_faded():
    whole = simulate(FADING, [0, 1, 0, 1, 0], 56.8, initial=State(deformation=1.0))
    first = simulate(FADING, [0], 56.8, initial=State(deformation=1.0))
    rest = simulate(FADING, [1, 0, 1, 0], 56.8, initial=first.final_state)
    np.testing.assert_allclose(rest.foot, whole.foot[1:], rtol=0, atol=1e-9)


@pytest.mark.parametrize("segments", [1, 2, 3])
def test_a_chain_keeps_its_energy_balance_as_its_foot_fades(segments):
    scene = Scene(segments=segments, tube_mass=0.1)
    even = ChainState([1.0 / segments] * segments, [0.0] * segments)
    groups = Groups(**STIFF.to_dict() | {"duffing": 0.0, "radial_coupling": 0.0})
    done = simulate(groups, [0, 1, 0, 1, 0], 56.8, scene=scene, initial=even, solver="taylor")
    assert done.slips == 3
    assert abs(done.energy_residual) < 1e-9
