"""What is fainter than 1e-250 is nothing: denormal numbers would make a step a hundred times as long."""

import numpy as np
import pytest

from stickslip.crawler import Scene, simulate, State


@pytest.mark.parametrize("solver", ["closed_form", "taylor", "radau"])
def test_a_gap_of_the_pressure_below_1e_250_is_none(solver):
    groups = {"duffing": 0.0, "radial_coupling": 0.0, "deborah": 1.0}
    arguments = {"scene": Scene(anchored=True), "solver": solver, "initial": State(pressure=1.0)}
    just_alive, dead = (simulate(groups, [0], hold, **arguments).pressure[-1] for hold in (571.0, 580.0))
    assert just_alive == pytest.approx(np.exp(-571.0), rel=1e-12)
    assert just_alive > 0.0
    assert dead == 0.0
    # So it is of a gap to the open valve, and sample by sample.
    samples = simulate(groups, [0], 600.0, samples_per_hold=60, **arguments).pressure
    np.testing.assert_array_equal(samples > 0.0, 10.0 * np.arange(1, 61) < 576.0)


@pytest.mark.parametrize("field", ["deformation", "velocity", "pressure"])
@pytest.mark.parametrize(("size", "alive"), [(1e-248, True), (1e-252, False)])
def test_a_linear_body_fainter_than_1e_250_is_at_rest(field, size, alive):
    groups = {"duffing": 0.0, "radial_coupling": 0.0, "damping_ratio": 0.0}
    start = State(**{field: size})
    done = simulate(groups, [0], 0.5, scene=Scene(anchored=True), solver="closed_form", initial=start)
    moved = [done.deformation[0], done.velocity[0], done.pressure[0]]
    assert any(moved) == alive
    if alive:
        scaled = State(**{field: 1.0})
        full = simulate(groups, [0], 0.5, scene=Scene(anchored=True), solver="closed_form", initial=scaled)
        expected = np.array([full.deformation[0], full.velocity[0], full.pressure[0]])
        np.testing.assert_allclose(np.divide(moved, size), expected, rtol=1e-12)
