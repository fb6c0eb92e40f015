"""The page of best bodies: what a task needs, what a reservoir holds, and the tables."""

import itertools
import json
import math

import best
import numpy as np
import pytest
from measuring import refreshed

from stickslip.crawler import Scene
from stickslip.reservoir import mean_over_runs
from stickslip.tasks import BodyReservoir, DelayLine, EchoState


def test_the_delay_line_holds_its_taps_and_no_product():
    memory = best.diagnosis("memory capacity", {"line": DelayLine(20)}, length=3000)
    held = list(memory["held"]["line"].values())
    assert held == pytest.approx([1, 1, 0, 0], abs=0.01)
    assert memory["degrees"]["line"]["by_degree"][1] == pytest.approx(20)
    parity = best.diagnosis("parity-3 capacity", {"line": DelayLine(20)}, length=3000)
    first, *_ = parity["missed"].values()
    assert first == pytest.approx(0, abs=1e-6)
    assert max(parity["held"]["line"].values()) < 0.02


def test_what_narma_needs_leaves_less_and_less():
    for task in ("NARMA-2 uniform NRMSE", "NARMA-10 uniform NRMSE"):
        left = list(best.diagnosis(task, {}, length=4000)["missed"].values())
        assert all(later < earlier + 0.01 for earlier, later in itertools.pairwise(left))
        assert left[-1] < 0.15


def test_curves_have_fewer_features_each():
    line = best.curve("memory capacity", DelayLine(8), (2, 4, 60))
    assert line["features"] == [2, 4, 8]
    assert line["mean"] == pytest.approx([2, 4, 8], abs=1e-6)


def test_noise_is_a_thousandth_and_its_own_each_time():
    drive = np.random.default_rng(0).random(20_000)
    exact, noisy = (each(drive, 3) for each in (EchoState(4), best.noisy(EchoState(4))))
    assert (noisy - exact).std(axis=0) / exact.std(axis=0) == pytest.approx([1e-3] * 4, rel=0.03)
    np.testing.assert_array_equal(noisy, best.noisy(EchoState(4))(drive, 3))


def test_a_cell_by_hand():
    assert best.cell(mean_over_runs([1.0, 3.0], bounds=(-math.inf, math.inf))) == "2.00 [-10.71, 14.71]"
    assert best.cell(mean_over_runs([2.0, 2.0])) == "2.00"


def test_modes_decay_as_the_body_does():
    """Pulled and let go by a valve that shuts, a linear anchored chain ends in its slowest mode."""
    groups = {"duffing": 0.0, "radial_coupling": 0.0, "damping_ratio": 0.05, "deborah": 0.01}
    body = BodyReservoir(groups, Scene(segments=4, tube_mass=3.0, anchored=True), hold=0.5, readings="deformation")
    slowest = max(best.mode_memories(body))
    stretch = body(np.repeat([1.0, 0.0], [200, 400]))
    early, late = (np.linalg.norm(stretch[part]) for part in (slice(280, 380), slice(480, 580)))
    assert 200 / np.log(early / late) == pytest.approx(slowest, rel=0.03)


def test_the_tables_of_the_page_are_those_of_the_results():
    """The configurations are laid out by a formatter and may have other line breaks."""
    made = best.tables(json.loads(best.RESULTS.read_text(encoding="utf-8"))["tasks"])
    del made["configurations"]
    page = best.PAGE.read_text(encoding="utf-8")
    assert refreshed(page, made) == page
