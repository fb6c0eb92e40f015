import math

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.container import BarContainer, ErrorbarContainer

from stickslip.reservoir import Estimate
from stickslip.studies.benchmark.figures import (
    plot_information,
    plot_predictions,
    plot_profiles,
    plot_scores,
    plot_sweep,
)
from stickslip.studies.benchmark.records import Record
from stickslip.studies.benchmark.report import as_json, as_markdown, as_rows, estimates, paired_differences
from stickslip.tasks import DelayLine, MEASURES, TASKS

mpl.use("agg")

KNOWN = {**TASKS, **MEASURES}
RANKS = [name for name in MEASURES if "rank" in name]
NARMA, PARITY = "NARMA-2 NRMSE", "parity-2 capacity"


def records(task, scores, reservoir="crawler", **details):
    return [Record(task, reservoir, seed, score, details) for seed, score in enumerate(scores)]


def test_the_interval_is_students():
    """Mean of 101, 102, 103: t(0.975, 2) = 4.302653 (tables), s = 1. So far from 0 no skew is to be feared."""
    found = estimates(records(NARMA, [101.0, 102.0, 103.0]))[NARMA, "crawler"]
    assert (found.mean, found.runs) == (102.0, 3)
    assert found.high - found.mean == pytest.approx(4.302653 / math.sqrt(3), rel=0.02)
    assert found.mean - found.low == pytest.approx(4.302653 / math.sqrt(3), rel=1e-6)


def test_the_table_by_hand():
    found = {(NARMA, "a"): Estimate(0.5, 0.4, 0.6, 5), (NARMA, "b"): Estimate(0.25, math.nan, math.nan, 1)}
    found |= {(PARITY, "a"): Estimate(1.0, 0.5, 1.5, 5), (PARITY, "b"): Estimate(2.0, 2.0, 2.0, 5)}
    rows = as_rows(found, TASKS)
    assert rows == [
        ["task", "a", "b"],
        ["NARMA-2 NRMSE ↓", "0.500 [0.400, 0.600]", "0.250"],
        ["parity-2 capacity ↑", "1.00 [0.50, 1.50]", "2.00 [2.00, 2.00]"],
    ]
    assert as_markdown(rows).splitlines()[:2] == ["| task | a | b |", "| --- | ---: | ---: |"]


def test_the_json_says_what_was_run_and_every_score():
    kept = records(NARMA, [0.5], prediction=[0.0], target=[1.0]) + records(PARITY, [1.0, 2.0], profile=[1.0])
    told = as_json(kept, estimates(kept), {}, {"length": 10})
    assert told["inputs"] == {"length": 10}
    assert {"python", "stickslip", "numpy"} <= set(told["versions"])
    assert told["means"][0] == {
        "task": NARMA, "reservoir": "crawler", "mean": 0.5, "interval": None, "seeds": 1
    }  # fmt: skip
    assert told["means"][1]["interval"][0] < 1.5 < told["means"][1]["interval"][1]
    assert told["scores"][0] == {"task": NARMA, "reservoir": "crawler", "seed": 0, "score": 0.5}
    assert told["scores"][2] == {"task": PARITY, "reservoir": "crawler", "seed": 1, "score": 2.0, "profile": [1.0]}


def test_an_interval_of_shares_stays_among_them():
    task = "waveform accuracy"
    kept = records(task, [1.0] * 14 + [0.9])
    assert estimates(kept)[task, "crawler"].high > 1
    each = estimates(kept, TASKS)[task, "crawler"]
    assert each.low < each.mean < each.high == 1.0


def test_an_interval_of_errors_or_capacities_is_never_negative():
    for task in (NARMA, PARITY, "memory capacity", "Lorenz valid time"):
        each = estimates(records(task, [0.1, 0.9]), TASKS)[task, "crawler"]
        assert each.low == 0 < each.mean < each.high


@pytest.mark.parametrize("task", ["memory capacity", "parity-3 capacity", "information capacity", *RANKS])
def test_no_capacity_or_rank_reaches_beyond_the_features(task):
    kept = records(task, [12.0] * 14 + [11.5])
    [crawler] = estimates(kept, KNOWN, {"crawler": DelayLine(12)}).values()
    assert crawler.low < crawler.mean < crawler.high == 12
    [unknown] = estimates(kept, KNOWN, {"crawler": lambda series, seed: series}).values()
    assert unknown.high > 12
    [beyond] = estimates([*kept[:-1], kept[-1]._replace(score=12.1)], KNOWN, {"crawler": DelayLine(12)}).values()
    assert beyond.high == max(12, beyond.mean)


def test_equal_scores_have_no_interval_at_a_bound_either():
    [each] = estimates(records("memory capacity", [3.0] * 5), KNOWN, {"crawler": DelayLine(12)}).values()
    assert np.isnan([each.low, each.high]).all()


def test_no_valid_time_reaches_beyond_the_horizon():
    [each] = estimates(records("Lorenz valid time", [8.0, 8.0, 7.0]), KNOWN).values()
    assert each.high == 8


def test_differences_are_paired_by_draw():
    """Scores that vary by 10 from draw to draw, and by 1 and 2 between reservoirs: t(0.975, 1) s / sqrt(2) = 6.353."""
    kept = records(NARMA, [10.0, 20.0], "a") + records(NARMA, [11.0, 22.0], "b") + records(PARITY, [1.0, 1.0], "a")
    kept += records(PARITY, [1.0, 1.0], "b")
    found = paired_differences(kept[::-1], "a")
    assert set(found) == {(NARMA, "b"), (PARITY, "b")}
    assert found[NARMA, "b"].mean == 1.5
    assert found[NARMA, "b"].high - 1.5 == pytest.approx(6.353, abs=1e-3)
    assert math.isnan(found[PARITY, "b"].low)
    rows = as_rows(paired_differences(kept, "b"), TASKS, signed=True)
    assert rows == [
        ["task", "a"],
        ["NARMA-2 NRMSE ↓", "-1.500 [-7.853, +4.853]"],
        ["parity-2 capacity ↑", "+0.00"],
    ]
    told = as_json(kept, estimates(kept), found, {})["differences"]
    assert told[0] == {"task": PARITY, "reservoir": "b", "mean": 0.0, "interval": None, "seeds": 2}
    with pytest.raises(ValueError, match="against has no 'c'"):
        paired_differences(kept, "c")


def test_the_chart_of_differences_has_its_line_at_none():
    found = {(NARMA, name): Estimate(0.5, 0.4, 0.6, 5) for name in ("b", "c")}
    [ax] = plot_scores(found, TASKS, against="a").axes
    assert ax.get_xlabel().startswith("difference from the a: NRMSE")
    [line, *_] = [each for each in ax.collections if len(each.get_segments()) == 1 and each.get_linestyle()[0][1]]
    assert line.get_segments()[0][:, 0].tolist() == [0.0, 0.0]
    [plain] = plot_scores({(NARMA, "a"): found[NARMA, "b"], **found}, TASKS).axes
    assert [each[0].get_color() for each in ax.containers] == [each[0].get_color() for each in plain.containers[1:]]


def test_the_chart_of_scores_has_a_panel_a_unit_and_a_marker_a_reservoir():
    found = {
        (task, reservoir): Estimate(mean, mean - 0.1, mean + 0.1, 5)
        for task, mean in ((NARMA, 0.5), ("NARMA-10 NRMSE", 0.6), (PARITY, 2.0))
        for reservoir in ("a", "b")
    }
    figure = plot_scores(found, TASKS)
    errors, capacity = figure.axes
    assert [label.get_text() for label in errors.get_yticklabels()] == ["NARMA-2 NRMSE ↓", "NARMA-10 NRMSE ↓"]
    assert "standard deviation" in errors.get_xlabel()
    first = next(each for each in errors.containers if isinstance(each, ErrorbarContainer))
    np.testing.assert_allclose(np.asarray(first[0].get_xdata(orig=False), dtype=float), [0.5, 0.6])
    np.testing.assert_allclose(first[2][0].get_segments()[0][:, 0], [0.4, 0.6])
    assert len({each[0].get_color() for each in capacity.containers}) == 2


def test_profiles_are_means_over_seeds():
    kept = [Record(PARITY, "a", seed, 0.0, {"profile": [1.0, 0.5 * seed, 0.0]}) for seed in (0, 1)]
    [ax] = plot_profiles(kept + records(PARITY, [0.0], "b", profile=[0.0] * 3)).axes
    np.testing.assert_allclose([line.get_ydata() for line in ax.lines], [[1, 0.25, 0], [0, 0, 0]])


def test_information_is_stacked_to_its_total_beside_the_rank():
    by_degree = {"by degree": {"1": 2.0, "2": 1.0}, "rank": 4}
    [ax] = plot_information(records("information capacity", [3.0, 3.0], **by_degree)).axes
    bars = [each[0] for each in ax.containers if isinstance(each, BarContainer)]
    assert [(bar.get_x(), bar.get_width()) for bar in bars] == [(0, 2), (2, 1)]
    assert 4.0 in [segment[0][0] for each in ax.collections for segment in each.get_segments()]


def test_predictions_are_drawn_against_their_target():
    kept = [
        Record(task, reservoir, seed, 0.5, {"prediction": [seed + 1.0] * 9, "target": [0.0] * 9})
        for task in (NARMA, "NARMA-10 NRMSE", "Lorenz NRMSE")
        for reservoir in ("other", "another", "delay line", "crawler")
        for seed in (1, 0)
    ]
    panels = plot_predictions(kept, samples=5).axes
    assert [ax.get_title(loc="left").split(":")[0] for ax in panels[:3]] == [NARMA, "NARMA-10 NRMSE", "Lorenz NRMSE"]
    lines = {line.get_label(): line.get_ydata() for line in panels[0].lines}
    assert list(lines) == ["target", "crawler", "delay line", "other"]
    np.testing.assert_array_equal(lines["crawler"], [1.0] * 5)


def test_a_sweep_is_drawn_with_its_intervals():
    figure = plot_sweep("hold", [0.25, 1.0, 4.0], {NARMA: [Estimate(m, m - 0.1, m + 0.1, 5) for m in (1, 2, 3)]}, TASKS)
    [ax] = figure.axes
    assert (ax.get_xscale(), ax.get_xlabel(), ax.get_ylabel()) == ("log", "hold ($t_c$)", "NRMSE")
    assert [label.get_text() for label in ax.get_xticklabels()] == ["0.25", "1", "4"]
    np.testing.assert_array_equal(ax.containers[0][0].get_ydata(), [1, 2, 3])
