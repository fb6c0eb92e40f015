"""The study of the edge: what it holds against, and that its verdicts are its numbers'."""

import edge
import numpy as np
import pytest

from stickslip import Groups, memory_capacity, simulate
from stickslip.tasks import body_states, dithered


@pytest.mark.slow
def test_a_linear_body_remembers_what_is_known_exactly():
    linear = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=0.2, deborah=0.5)
    exact = edge.exact_profile(linear, 0.5, 400)
    assert exact.sum() == pytest.approx(3.0, abs=1e-9)
    valve = dithered(np.zeros(20_000, int), 0.5, 0)
    states = body_states(simulate(linear, valve, 0.5, scene={"anchored": True}))
    np.testing.assert_allclose(memory_capacity(states, valve - 0.5, 12).profile, exact[:12], atol=0.02)


def test_a_verdict_is_that_of_its_intervals():
    cell = {"chaotic": 3, "cells": 70, "most": [2.0, 1.9, 2.1], "exponent": [-0.03, -0.04, -0.02]}
    told = {
        "anchored, raw": {**cell, "edge": [1.5, 1.4, 1.6], "more": [0.5, 0.4, 0.6]},
        "ground, raw": {**cell, "chaotic": 0},
    }
    assert edge._whether_memory_is_at_it(told).startswith("**C5, memory is largest at the edge: no.**")
    assert "holds 0.50 to 0.50 more" in edge._whether_memory_is_at_it(told)
    assert "3 to 3 of 70 cells" in edge._where_an_edge_is(told)
    told["anchored, raw"]["more"] = [-0.5, -0.6, -0.4]
    assert "at the edge: not told.**" in edge._whether_memory_is_at_it(told)
    told["ground, raw"]["chaotic"] = 2
    assert ": not as the paper has it.**" in edge._where_an_edge_is(told)
