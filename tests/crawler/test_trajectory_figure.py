"""What the figure of a trajectory says and draws, against the trajectory's own numbers and events."""

import re

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import colors

from stickslip.common.figures import BODY, OKABE_ITO, OPEN, SLIDES
from stickslip.crawler import Actuator, simulate, State
from stickslip.crawler.trajectory_figure import _round_up

mpl.use("Agg")

BLUE, ORANGE, GREEN, PURPLE = OKABE_ITO[:4]
BOTH_WAYS = {"scene": {"ratchet": False}, "samples_per_hold": 7}
BACKWARD = State(foot_velocity=-0.7)
MOTIONS = {
    "forward": lambda: simulate({}, [1, 1, 1, 1, 0, 0, 0, 0], 1.0),
    "both ways": lambda: simulate({"static_friction": 0.1, "kinetic_friction": 0.05}, [1, 0] * 5, 1.5, **BOTH_WAYS),
    "turning at once": lambda: simulate(
        {"duffing": 0.0, "damping_ratio": 0.0, "static_friction": 0.05, "kinetic_friction": 0.05},
        [0],
        6.0,
        initial=State(1.0),
        **BOTH_WAYS,
    ),
    "sliding backward at the start": lambda: simulate(
        {}, [1, 0.25], 1.5, initial=State(foot_velocity=-0.7), **BOTH_WAYS
    ),
    "sliding at the end": lambda: simulate({}, [1, 1, 1, 1, 0], 1.0),
    "at rest": lambda: simulate({}, [0, 0.5], 0.2),
}


@pytest.fixture(params=MOTIONS)
def motion(request):
    return MOTIONS[request.param]()


@pytest.fixture
def drawn():
    """Draws trajectories, and closes their figures afterwards."""
    figures = []

    def draw(trajectory):
        figures.append(trajectory.plot())
        return figures[-1]

    yield draw
    for figure in figures:
        mpl.pyplot.close(figure)


def slides(trajectory):
    """The stretches of time in which the foot slides, by the events and the start alone."""
    times = np.concatenate([[0.0], trajectory.events["time"], [trajectory.time[-1]]])
    modes = np.concatenate([[np.sign(trajectory.initial.foot_velocity)], trajectory.events["mode"]])
    return [(times[i], times[i + 1]) for i in np.flatnonzero(modes)]


def spans(axes):
    """What is shaded over the whole height, and in which colours."""
    boxes = [patch.get_window_extent().transformed(axes.transAxes.inverted()) for patch in axes.patches]
    assert all(box.y0 == pytest.approx(0.0) and box.y1 == pytest.approx(1.0) for box in boxes)
    edges = [patch.get_window_extent().transformed(axes.transData.inverted()) for patch in axes.patches]
    return [(box.x0, box.x1) for box in edges], {colors.to_hex(patch.get_facecolor()) for patch in axes.patches}


def line(axes, label):
    """Times, values and colour of the one line of that name."""
    (found,) = [each for each in axes.lines if each.get_label().split(",")[0] == label]
    return *found.get_data(), found.get_color()


def ahead(axes):
    """How far the payload is drawn in front of where it is, by the legend."""
    (label,) = [each.get_label() for each in axes.lines if each.get_label().startswith("payload")]
    return float(re.fullmatch(r"payload, drawn (\S+) .* ahead", label)[1])


def words(axes):
    legend = axes.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def test_the_motions_are_what_they_are_called():
    modes = {name: make().events["mode"].tolist() for name, make in MOTIONS.items()}
    assert modes["forward"] == [1, 0, 1, 0]
    assert {1, -1} <= set(modes["both ways"])
    assert modes["turning at once"][:3] == [1, -1, 1]
    assert modes["sliding backward at the start"][0] >= 0
    assert modes["sliding at the end"][-1] == 1
    assert modes["at rest"] == []


def test_what_is_shaded_slides_and_what_is_not_sticks(motion, drawn):
    figure = drawn(motion)
    for axes in figure.axes[:2]:
        found, shades = spans(axes)
        np.testing.assert_allclose(np.reshape(found, (-1, 2)), np.reshape(slides(motion), (-1, 2)), rtol=0, atol=1e-9)
        assert shades <= {colors.to_hex(SLIDES)}
    named = words(figure.axes[0])
    assert ("foot slides" in named) == bool(slides(motion))
    assert [name.split(",")[0] for name in named if name != "foot slides"] == ["body", "payload", "foot"]
    # Grey means that, and nothing else.
    greys = {colors.to_hex(each) for axes in figure.axes for line in axes.lines for each in [line.get_color()]}
    assert all(len({each[1:3], each[3:5], each[5:]}) > 1 or each == "#000000" for each in greys)


def test_lines_are_the_trajectorys(motion, drawn):
    travel, stretch, drive = drawn(motion).axes
    for axes, label, values, colour in (
        (travel, "payload", motion.foot + motion.deformation + ahead(travel), ORANGE),
        (travel, "foot", motion.foot, BLUE),
        (drive, "pressure", motion.pressure, PURPLE),
    ):
        times, drawn_values, drawn_colour = line(axes, label)
        np.testing.assert_array_equal(times, motion.time)
        np.testing.assert_allclose(drawn_values, values, rtol=1e-12, atol=1e-12)
        assert drawn_colour == colour
    curve, zero = stretch.lines
    np.testing.assert_array_equal(curve.get_xdata(), motion.time)
    np.testing.assert_array_equal(curve.get_ydata(), motion.deformation)
    assert curve.get_color() == GREEN
    assert list(zero.get_ydata()) == [0.0, 0.0]
    assert len(travel.lines) == 2
    assert len(drive.lines) == 1


def test_the_payload_never_passes_through_the_foot_and_the_body_lies_between(motion, drawn):
    travel = drawn(motion).axes[0]
    _, payload, _ = line(travel, "payload")
    _, foot, _ = line(travel, "foot")
    assert (payload > foot).all()
    (body,) = travel.collections
    assert colors.to_hex(body.get_facecolor()[0]) == colors.to_hex(BODY)
    low, high = body.get_paths()[0].vertices[:, 1].min(), body.get_paths()[0].vertices[:, 1].max()
    assert (low, high) == (pytest.approx(foot.min()), pytest.approx(payload.max()))


@pytest.mark.parametrize(("value", "up"), [(0.0, 1.0), (0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (2.5, 5.0), (60.0, 100.0)])
def test_a_body_is_drawn_as_long_as_a_round_number(value, up):
    assert _round_up(value) == pytest.approx(up)


def test_the_legend_names_what_has_that_colour(drawn):
    travel, _, drive = drawn(MOTIONS["forward"]()).axes
    slid, body, payload, foot = travel.get_legend().legend_handles
    assert colors.to_hex(slid.get_facecolor()) == colors.to_hex(SLIDES)
    assert colors.to_hex(body.get_facecolor()) == colors.to_hex(BODY)
    assert (payload.get_color(), foot.get_color()) == (ORANGE, BLUE)
    shown = dict(zip(words(drive), drive.get_legend().legend_handles, strict=True))
    assert shown["pressure"].get_color() == PURPLE
    assert colors.to_hex(shown["valve open"].get_facecolor()) == colors.to_hex(OPEN)


@pytest.mark.parametrize("actuator", [None, Actuator.ecoflex()], ids=["natural", "SI"])
def test_the_valve_is_open_where_the_schedule_says(actuator, drawn):
    duties, hold = [1.0, 0.0, 0.25, 0.5], 2.0
    done = simulate({}, duties, hold)
    height, unit = 1.0, 1.0
    if actuator is not None:
        done, height, unit = done.in_si(actuator), 1e-3 * actuator.peak_pressure, actuator.scales.time
    axes = drawn(done).axes[-1]
    (valve,) = axes.patches
    stairs = valve.get_data()
    for k, duty in enumerate(duties):
        for share in (0.1, 0.3, 0.4, 0.6, 0.9):
            place = np.searchsorted(stairs.edges, (k + share) * hold * unit) - 1
            assert stairs.values[place] == (height if share < duty else 0.0)
    assert stairs.edges[0] == 0.0
    assert stairs.edges[-1] == pytest.approx(4 * hold * unit)
    assert words(axes) == ["valve open", "pressure"]
    assert valve.get_fill()


@pytest.mark.parametrize(
    ("actuator", "length", "time", "pressure"),
    [(None, "$z_c$", "$t_c$", "$P_{max}$"), (Actuator.ecoflex(), "mm", "s", "kPa")],
    ids=["natural", "SI"],
)
def test_axes_name_quantity_and_unit(actuator, length, time, pressure, drawn):
    done = simulate({}, [1, 1, 1, 1, 0, 0, 0, 0], 1.0, samples_per_hold=3)
    fine = done if actuator is None else done.in_si(actuator)
    travel, stretch, drive = drawn(fine).axes
    assert travel.get_ylabel() == f"displacement ({length})"
    assert stretch.get_ylabel() == f"stretch $z$ ({length})"
    assert drive.get_ylabel() == f"pressure ({pressure})"
    assert drive.get_xlabel() == f"time ({time})"
    if actuator is not None:
        np.testing.assert_allclose(line(travel, "foot")[1], 1e3 * fine.foot)
        np.testing.assert_allclose(line(drive, "pressure")[1], 1e-3 * fine.pressure)
    end = 8.0 if actuator is None else 8.0 * actuator.scales.time
    for axes in (travel, stretch, drive):
        assert axes.get_xlim() == pytest.approx((0.0, end))
        low, high = axes.get_ylim()
        for each in axes.lines:
            assert low <= np.min(each.get_ydata())
            assert np.max(each.get_ydata()) <= high


def test_one_crawler_is_drawn_and_a_batch_is_refused():
    batch = simulate([{}, {}, {}], [1, 0], 1.0)
    with pytest.raises(ValueError, match=r"^plot takes the trajectory of one crawler, got a batch of 3$"):
        batch.plot()


def test_drawing_leaves_matplotlibs_settings_alone(drawn):
    before = dict(mpl.rcParams)
    figure = drawn(MOTIONS["at rest"]())
    assert dict(mpl.rcParams) == before
    assert not figure.axes[0].spines["top"].get_visible()
