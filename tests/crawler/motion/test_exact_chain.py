"""The chain against the exponential of its matrix: an exact solution, phase by phase, with no integration at all."""

import numpy as np
import pytest
from exact_chain import exact_chain

from stickslip import Groups, simulate
from stickslip.tasks import random_bits

LINEAR = Groups(duffing=0.0, radial_coupling=0.0)


@pytest.mark.parametrize(("segments", "tube_mass"), [(2, 0.1), (5, 0.5)])
def test_a_linear_chain_moves_as_the_exponential_of_its_matrix_does(segments, tube_mass):
    valve = random_bits(14, 4)
    deformation, foot, events = exact_chain(LINEAR, valve, 1.0, segments=segments, tube_mass=tube_mass)
    found = simulate(LINEAR, valve, 1.0, scene={"segments": segments, "tube_mass": tube_mass}, tolerance=1e-12)
    assert len(events) >= 6
    np.testing.assert_allclose(found.events["time"], events, atol=1e-8)
    np.testing.assert_allclose(found.deformation, deformation, atol=1e-9)
    np.testing.assert_allclose(found.foot, foot, atol=1e-9)


def test_one_heavy_segment_is_the_crawler_that_the_exponential_finds():
    valve = random_bits(10, 4)
    deformation, foot, events = exact_chain(LINEAR, valve, 1.0, segments=1, tube_mass=0.3)
    found = simulate(LINEAR, valve, 1.0, scene={"tube_mass": 0.3})
    np.testing.assert_allclose(found.events["time"], events, atol=1e-9)
    np.testing.assert_allclose(found.deformation, deformation, atol=1e-10)
    np.testing.assert_allclose(found.foot, foot, atol=1e-10)
