"""Leading exponents of chains, against eigenvalues and finite differences."""

import math

import numpy as np
import pytest

from stickslip import lyapunov_spectrum
from stickslip.crawler import ChainState, Groups, Scene, simulate
from stickslip.crawler.model.tube import node_masses
from stickslip.crawler.stability.chain_growth import start_chain_growth
from stickslip.crawler.steps.chain_series import chain_workspace

BITS = np.random.default_rng(7).integers(0, 2, 400)
SEGMENTS = 3
CHAIN = {"segments": SEGMENTS, "tube_mass": 0.4}


def rates_of(groups, scene):
    """Matrix of the linear chain whose foot rests: rates of d and d' of the segments."""
    mobility = 1.0 / node_masses(groups, scene)
    mobility[0] = 0.0
    n = scene.segments
    pull = np.zeros((n + 1, n))  # accelerations of nodes by the segments' forces
    for j in range(n):
        pull[j, j] -= mobility[j]
        pull[j + 1, j] += mobility[j + 1]
    stretching = n * np.diff(pull, axis=0)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-stretching, -2.0 * groups.damping_ratio * stretching]])


def test_leading_exponents_of_an_anchored_linear_chain_are_its_slowest_rates():
    groups, scene = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=0.2), Scene(anchored=True, **CHAIN)
    found = lyapunov_spectrum(groups, BITS, 1.0, scene=scene)
    matrix = rates_of(groups, scene)
    slowest = np.sort(np.linalg.eigvals(matrix).real)[::-1][:2]
    assert slowest[0] == pytest.approx(slowest[1])
    np.testing.assert_allclose(found.exponents, slowest, atol=2.0 / found.time)
    assert found.exponents.sum() == pytest.approx(slowest.sum(), abs=0.5 / found.time)
    assert found.divergence == pytest.approx(np.trace(matrix), rel=1e-9)
    assert found.verdict == "contracting"


@pytest.mark.parametrize("further", [{}, {"ratchet": False, "slope": 0.05}])
def test_growth_of_a_chain_through_events_is_what_finite_differences_find(further):
    groups, scene, valve, hold, nudge = Groups(duffing=2.0), Scene(**CHAIN, **further), [1, 1, 0, 0, 1, 0], 1.3, 1e-6
    masses = node_masses(groups, scene)
    start = np.array([0.1, -0.2, 0.05, 0.0, 0.1, -0.1])

    def end(changed):
        initial = ChainState(changed[:SEGMENTS] / SEGMENTS, changed[SEGMENTS:] / SEGMENTS, 0.2)
        done = simulate(groups, valve, hold, scene=scene, tolerance=1e-14, initial=initial)
        stretches = SEGMENTS * np.array([done.segment_deformation[:, -1], done.segment_velocity[:, -1]])
        w = done.foot_velocity[-1]
        velocities = w + np.concatenate([[0.0], np.cumsum(stretches[1]) / SEGMENTS])
        return np.array([*stretches.ravel(), masses @ velocities if w else 0.0]), done

    workspace = chain_workspace(groups, scene, np.zeros((2, SEGMENTS)))
    start_chain_growth(workspace)
    vectors = workspace.tangents[:, :-1]
    moved = np.array([(end(start + nudge * one)[0] - end(start - nudge * one)[0]) / (2.0 * nudge) for one in vectors])
    first, area = np.log(np.linalg.norm(moved[0])), 0.5 * np.linalg.slogdet(moved @ moved.T)[1]

    _, done = end(start)
    assert {0, 1} <= set(done.events["mode"].tolist())
    found = lyapunov_spectrum(groups, valve, hold, scene=scene, tolerance=1e-12, washout=0, initial=done.initial)
    exact = np.sort([first, area - first])[::-1] / found.time
    np.testing.assert_allclose(found.exponents, exact, atol=1e-6)
    assert found.stops == np.count_nonzero(done.events["mode"] == 0)
    assert found.foot_exponent == (-math.inf if found.stops else 0.0)


def test_a_chain_without_friction_keeps_its_momentum_and_forgets_the_rest():
    groups = Groups(duffing=0.0, radial_coupling=0.0, static_friction=0.0, kinetic_friction=0.0, damping_ratio=0.2)
    found = lyapunov_spectrum(groups, BITS[:120], 1.0, scene=Scene(ratchet=False, **CHAIN), washout=40)
    assert (found.foot_exponent, found.stops, found.verdict) == (0.0, 0, "neutral")
    assert found.exponents[0] < -0.2
