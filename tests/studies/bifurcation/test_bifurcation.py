"""Bifurcation diagrams against the runs that they are made of, and a doubling of the period."""

import math

import numpy as np
import pytest

from stickslip import lyapunov_spectrum, simulate
from stickslip.studies.bifurcation import bifurcation_diagram
from stickslip.studies.maps import Inputs

ANCHORED = {"anchored": True}


def test_sections_and_exponents_are_those_of_each_value_alone():
    told = []
    found = bifurcation_diagram(
        ("duffing", [0.5, 3.0, 20.0]),
        groups={"damping_ratio": 0.1},
        hold=0.7,
        holds=120,
        washout=40,
        seeds=2,
        on_progress=lambda done, of: told.append((done, of)),
    )
    assert found.exponents.shape == found.standard_error.shape == (3, 2)
    assert found.sections.shape == (3, 160)
    assert told == [(0, 3), (3, 3)]
    valve = np.array([Inputs.of("bits").drawn(120, seed).valve for seed in (0, 1)])
    groups = {"damping_ratio": 0.1, "duffing": 3.0}
    alone = lyapunov_spectrum(groups, valve, 0.7, washout=40)
    np.testing.assert_array_equal(found.exponents[1], alone.exponents)
    assert found.verdicts[1] == alone.verdict
    motion = simulate(groups, valve, 0.7)
    assert set(found.sections[1]) == set(motion.deformation[:, 40:].ravel())


def test_a_word_is_cut_at_its_ends_where_its_attractor_has_few_points():
    # A linear body answers a word by a motion of the same period.
    found = bifurcation_diagram(
        "hold=0.5,1.0", groups="linear", scene=ANCHORED, inputs="word:0011", holds=1200, washout=1000
    )
    assert found.sections.shape == (2, 50)
    np.testing.assert_allclose(np.ptp(found.sections, axis=1), 0.0, atol=1e-9)
    np.testing.assert_allclose(found.exponents, -0.05 / 0.7, rtol=1e-9)


def test_the_dither_can_vary():
    found = bifurcation_diagram("dither=0.1,0.5", inputs="word:01", holds=60, washout=10)
    valve = Inputs("01", 0.1).drawn(60, 0).valve
    np.testing.assert_array_equal(found.exponents[0], lyapunov_spectrum({}, valve, 0.5, washout=10).exponents)


def test_a_word_without_dither_has_one_run():
    with pytest.raises(ValueError, match="seeds must be 1 for a word without dither"):
        bifurcation_diagram("hold=0.5,1.0", inputs="word:01", seeds=2)


def test_the_figure_shows_every_section_and_both_exponents(tmp_path):
    found = bifurcation_diagram("duffing=1:100:5:log", holds=60, washout=20, scene=ANCHORED)
    figure = found.plot()
    above, below = figure.axes
    assert above.lines[0].get_xdata().size == found.sections.size
    np.testing.assert_array_equal(below.lines[1].get_ydata(), found.exponents[:, 0])
    np.testing.assert_array_equal(below.lines[2].get_ydata(), found.exponents[:, 1])
    assert below.get_xscale() == "log"
    assert math.isclose(below.lines[0].get_ydata()[0], 0.0)
    assert "Pi_1" in below.get_xlabel()
