"""The figure of work and precision by its artists, on rows made up for it."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.colors import to_hex

from stickslip.crawler import Groups, Scene, simulate
from stickslip.studies.work_precision import (
    Case,
    plot_work_precision,
    recommend,
    Reference,
    Row,
    Timing,
    WorkPrecision,
)
from stickslip.studies.work_precision.case import DEFORMATION, FOOT, MEAN_SPEED, RMS_DEFORMATION, SLIP_RATE

mpl.use("agg")

CASE = Case(Groups(duffing=0.75), holds=6)
BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"


@pytest.fixture(autouse=True)
def _closed():
    yield
    plt.close("all")


def row(solver, tolerance, microseconds, errors, *, slips_agree=True):
    timing = Timing(0.75 * microseconds, microseconds, 1.5 * microseconds)
    return Row(solver, tolerance, errors, 3, slips_agree, timing)


def study(rows, floors, *, comparable=True, case=CASE):
    run = simulate(case.groups, case.valve, case.hold, scene=case.scene)
    return WorkPrecision(case, Reference("taylor", run, (), comparable, {}, floors, (3,)), tuple(rows), (), 100.0)


FLOORS = {FOOT: 1e-13, DEFORMATION: 1e-14}
ROWS = [
    row("taylor", 1e-3, 1.0, {FOOT: 1e-4, DEFORMATION: 1e-5}, slips_agree=False),
    row("taylor", 1e-6, 3.0, {FOOT: 1e-7, DEFORMATION: 1e-8}),
    row("taylor", 1e-12, 20.0, {FOOT: 1e-15, DEFORMATION: 2e-13}),
    row("closed_form", None, 0.5, {FOOT: 3e-13, DEFORMATION: 0.0}),
]


def points(line):
    return [tuple(point) for point in np.asarray(line.get_xydata()).tolist()]


def solver_lines(ax):
    return {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}


def test_every_row_stands_at_its_time_and_its_error():
    figure = plot_work_precision(study(ROWS, FLOORS))
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["foot position ($z_c$)", "deformation ($z_c$)"]
    foot, deformation = map(solver_lines, figure.axes)
    assert points(foot["taylor"]) == [(1.0, 1e-4), (3.0, 1e-7), (20.0, 1e-13)]  # not below the reference's own error
    assert points(foot["closed_form"]) == [(0.5, 3e-13)]
    assert points(deformation["taylor"]) == [(1.0, 1e-5), (3.0, 1e-8), (20.0, 2e-13)]
    assert points(deformation["closed_form"]) == [(0.5, 1e-14)]
    # A solver has its colour and marker in every figure, whichever others are there.
    assert [(foot[name].get_color(), foot[name].get_marker()) for name in ("taylor", "closed_form")] == [
        (BLUE, "o"), (GREEN, "^")
    ]  # fmt: skip
    for ax in figure.axes:
        assert ax.get_xlabel() == "time (µs per time unit)"
        assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
        quartiles = [segment.tolist() for bars in ax.collections for segment in bars.get_segments()]
        assert [[x for x, _ in each] for each in quartiles] == [
            [0.75, 1.5], [2.25, 4.5], [15.0, 30.0], [0.375, 0.75]
        ]  # fmt: skip
        assert [to_hex(bars.get_color()[0]) for bars in ax.collections] == [BLUE.lower(), GREEN.lower()]
    assert [ax.get_ylabel() for ax in figure.axes] == ["error", ""]
    assert figure.axes[0].get_ylim() == pytest.approx((0.2 * 1e-14, 5 * 1e-4))


def test_a_wrong_slip_count_is_crossed_out():
    figure = plot_work_precision(study(ROWS, FLOORS))
    crosses = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    assert [points(line) for line in crosses] == [[(1.0, 1e-4)], []]
    opened = [line for line in figure.axes[0].lines if line.get_markerfacecolor() == "white"]
    assert [points(line) for line in opened] == [[(1.0, 1e-4)], []]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "taylor", "closed_form", "below the reference's own error", "wrong slip count"
    ]  # fmt: skip
    right = plot_work_precision(study(ROWS[1:], FLOORS))
    assert "wrong slip count" not in [text.get_text() for text in right.legends[0].get_texts()]


def test_the_error_wanted_and_the_row_recommended_are_marked():
    chosen = recommend(study(ROWS[:3], FLOORS), 1e-6)
    assert chosen.row == ROWS[1]
    figure = plot_work_precision(study(ROWS[:3], FLOORS), chosen)
    for ax, error in zip(figure.axes, (1e-7, 1e-8), strict=True):
        lines = solver_lines(ax)
        assert points(lines["recommended"]) == [(3.0, error)]
        assert (lines["recommended"].get_markerfacecolor(), lines["recommended"].get_markeredgecolor()) == (
            "none",
            "black",
        )
        assert set(lines["error wanted"].get_ydata()) == {1e-6}
    none = recommend(study(ROWS[:1], FLOORS), 1e-2)
    figure = plot_work_precision(study(ROWS[:1], FLOORS), none)
    assert "recommended" not in solver_lines(figure.axes[0])
    assert figure.axes[0].get_ylim()[1] == pytest.approx(5 * 1e-2)


def test_the_band_reaches_up_to_what_cannot_be_told():
    for ax, floor in zip(plot_work_precision(study(ROWS, FLOORS)).axes, FLOORS.values(), strict=True):
        [band] = ax.patches
        assert band.get_y() + band.get_height() == pytest.approx(floor, rel=1e-9)
        assert band.get_label() == "below the reference's own error"


def test_tolerances_are_written_beside_their_markers():
    written = [text.get_text() for text in plot_work_precision(study(ROWS, FLOORS)).axes[0].texts]
    assert written == ["$10^{-3}$", "$10^{-6}$", "$10^{-12}$"]
    [first, *_] = plot_work_precision(study(ROWS, FLOORS)).axes[0].texts
    assert first.xy == (1.0, 1e-4)
    # Two that would stand on one another: the first one's alone.
    close = [row("taylor", 1e-5, 3.0, ROWS[1].errors), *ROWS[1:]]
    assert [text.get_text() for text in plot_work_precision(study(close, FLOORS)).axes[0].texts] == [
        "$10^{-5}$", "$10^{-12}$"
    ]  # fmt: skip


def test_statistics_are_drawn_as_differences_on_a_linear_axis():
    floors = {MEAN_SPEED: 0.01, SLIP_RATE: 0.02, RMS_DEFORMATION: 0.005}
    rows = [
        row("taylor", 1e-3, 1.0, {MEAN_SPEED: 0.03, SLIP_RATE: 0.01, RMS_DEFORMATION: 0.001}),
        row("radau", 1e-3, 5.0, {MEAN_SPEED: 0.002, SLIP_RATE: 0.0, RMS_DEFORMATION: 0.004}),
    ]
    made = study(rows, floors, comparable=False)
    figure = plot_work_precision(made, recommend(made, 1e-6))
    assert [ax.get_title(loc="left") for ax in figure.axes] == [
        "mean speed ($z_c/t_c$)", "slips per time ($1/t_c$)", "RMS deformation ($z_c$)"
    ]  # fmt: skip
    assert figure.axes[0].get_ylabel() == "difference of means over twins"
    for ax, (name, floor) in zip(figure.axes, floors.items(), strict=True):
        assert ax.get_yscale() == "linear"
        lines = solver_lines(ax)
        assert points(lines["taylor"]) == [(1.0, rows[0].errors[name])]  # as it is, also below the floor
        assert points(lines["radau"]) == [(5.0, rows[1].errors[name])]
        assert lines["radau"].get_color() == ORANGE
        assert points(lines["recommended"]) == [(5.0, rows[1].errors[name])]
        assert ax.get_ylim()[0] < 0
        [band] = ax.patches
        assert (band.get_y(), band.get_height(), band.get_label()) == (0, floor, "within chance")
    caption = figure.get_suptitle().splitlines()
    assert caption[2:] == [
        "trajectories are not comparable: a change in the last digit grows",
        "compared are means over twins whose starts differ by a billionth",
    ]


def test_the_caption_says_what_was_run():
    made = study(ROWS, FLOORS)
    slips = made.reference.trajectory.slips
    assert plot_work_precision(made).get_suptitle() == (
        r"$\Pi_1 = 0.75$, $\Pi_2 = 0.05$, $\Pi_4 = 0.5$, $\Pi_5 = 0.2$, $r = 0.3$, $s = 0.3$, $k = 0.2$"
        f"\n6 random holds of 0.5, {slips} slips; reference: taylor at $10^{{-15}}$"
    )
    anchored = Case(scene=Scene(anchored=True, slope=0.25), holds=4, hold=2.0)
    rows = [row("taylor", 1e-6, 1.0, {DEFORMATION: 1e-7})]
    figure = plot_work_precision(study(rows, {DEFORMATION: 1e-14}, case=anchored))
    first, second = figure.get_suptitle().splitlines()
    assert first.endswith("$; slope = 0.25; anchored = True") or first.endswith("$; anchored = True; slope = 0.25")
    assert second == "4 random holds of 2; reference: taylor at $10^{-15}$"


def test_a_tolerance_is_left_out_where_it_would_stand_on_another():
    """17 points aside or 7 above is room enough, from marker to marker in the order of the rows."""
    rows = [row("taylor", 10.0**-k, 1.05**k, {FOOT: 10.0 ** (-1 - 0.35 * k), DEFORMATION: 1e-12}) for k in range(2, 15)]
    rows += [
        row("radau", 10.0**-k, 1.3 * 1.15**k, {FOOT: 10.0 ** (-1 - 0.5 * k), DEFORMATION: 1e-12}) for k in (3, 4, 5, 9)
    ]
    figure = plot_work_precision(study(rows, FLOORS))
    ax = figure.axes[0]
    spots, expected = [], []
    for each in rows:
        spot = ax.transData.transform((each.timing.median, each.errors[FOOT])) * 72 / figure.dpi
        if all(abs(spot[0] - x) > 17 or abs(spot[1] - y) > 7 for x, y in spots):
            spots.append(spot)
            expected.append((each.timing.median, each.errors[FOOT]))
    assert [text.xy for text in ax.texts] == expected
    assert 4 < len(expected) < len(rows)
    assert [text.get_color() for text in ax.texts][:: len(expected) - 1] == [BLUE, ORANGE]


@pytest.mark.parametrize(("slowest", "narrow"), [(9.9, True), (10.0, False)])
def test_times_within_a_decade_have_finer_ticks(slowest, narrow):
    rows = [row("taylor", 1e-3, 1.0, ROWS[0].errors), row("taylor", 1e-6, slowest, ROWS[1].errors)]
    figure = plot_work_precision(study(rows, FLOORS))
    ticks = figure.axes[0].xaxis.get_major_locator().tick_values(1.0, 9.99)
    assert (3.0 in ticks) == narrow
    assert {1.0, 2.0, 5.0} <= set(ticks)
