"""A picture says what is so: its words, and what stands where in which colour."""

import math

import numpy as np
import pytest

from stickslip.crawler import Actuator, Groups, Scene
from stickslip.crawler.drawing.camera import Camera
from stickslip.crawler.drawing.composition import composed
from stickslip.crawler.drawing.frame import Frame, Message, Past, static_stretch, world_of
from stickslip.crawler.drawing.layout import FOOT_AT, GROUND, HEIGHT, LOWER, PIVOT, WIDTH
from stickslip.crawler.drawing.palette import AIR, GREY, INK, MESSAGE, PAPER, SLIDING, STICKING
from stickslip.crawler.drawing.primitives import Disc, Line, Polygon, rounded, Text, turned_point
from stickslip.crawler.drawing.side_view import AXIS, ruler_step

WORLD = world_of(Scene(), 1.0)
RESTING = Frame(3.0, (0.4,), 0.5, 2.0, 0.0, 0, camera=2.0)
SLIDES, BACKWARD = (RESTING._replace(foot_velocity=speed) for speed in (1.5, -1.5))
SCALE = 60  # pixels a z_c


def points_of(each):
    if isinstance(each, Disc):
        (x, y), radius = each.centre, each.radius
        return [(x - radius, y - radius), (x + radius, y + radius)]
    return each.points


def shapes(frame, world=WORLD, *, colour=None, kind=(Polygon, Line, Disc), top=0, bottom=LOWER - 2):
    """Shapes of a colour within a band of the picture."""
    found = [each for each in composed(frame, world) if isinstance(each, kind) and colour in (None, each.colour)]
    return [each for each in found if all(top <= y <= bottom for _, y in points_of(each))]


def box_of(those):
    corners = np.array([point for each in those for point in points_of(each)])
    return (*corners.min(axis=0), *corners.max(axis=0))


def words(frame, world=WORLD):
    return {each.text: each for each in composed(frame, world) if isinstance(each, Text)}


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({}, "3.0 t_c"),
        ({"time": 12.26}, "12.3 t_c"),
        ({"time": 1e7}, "1e+07 t_c"),
        ({}, "2.0 z_c"),
        ({"foot": -13.34, "camera": 0.0}, "−13.3 z_c"),
        ({"foot": -0.01}, "0.0 z_c"),
        ({}, "0.00 z_c/t_c"),
        ({"foot_velocity": -1.234}, "−1.23 z_c/t_c"),
        ({"memory": -0.555}, "−0.56"),
        ({"memory": 12.0}, "12.00"),
        ({"valve": 0}, "closed"),
        ({"valve": 1}, "open"),
        ({}, "sticks"),
        ({"foot_velocity": 0.1}, "slides"),
        ({"foot_velocity": -0.1}, "slides back"),
    ],
    ids=str,
)
def test_the_words_are_the_numbers(changes, text):
    said = words(RESTING._replace(**changes))
    assert said[text].at[1] < 60
    assert ("memory" in said) == ("memory" in changes)


def test_words_are_in_millimetres_seconds_and_kilopascals_of_an_actuator():
    actuator = Actuator.ecoflex()
    world = world_of(Scene(), 1.0, actuator)
    length, time, _, pressure = actuator.scales
    said = words(RESTING._replace(foot_velocity=0.5), world)
    assert f"{2e3 * length:.1f} mm" in said
    assert f"{500 * length / time:.2f} mm/s" in said
    assert any(math.isclose(float(each.split()[0]), 3 * time, abs_tol=0.1) for each in said if each.endswith(" s"))
    assert said[f"{1e-3 * pressure:.3g}"].at[1] < 60  # the end of the gauge
    assert "pressure, kPa" in said
    assert not [each for each in said if "_c" in each]


@pytest.mark.parametrize("ratchet", [True, False])
def test_a_foot_that_sticks_is_solid_and_the_ground_beneath_hatched(ratchet):
    world = world_of(Scene(ratchet=ratchet), 1.0)
    assert not shapes(RESTING, world, colour=SLIDING)
    solid = shapes(RESTING, world, colour=STICKING, kind=Polygon)
    left, top, right, bottom = box_of(solid)
    assert (left + right) / 2 == pytest.approx(FOOT_AT, abs=1)
    assert top == GROUND - 110
    assert (bottom > GROUND + 5) == ratchet  # teeth dig in
    hatch = shapes(RESTING, world, colour=STICKING, kind=Line)
    assert len(hatch) == 9
    assert all(GROUND < y < GROUND + 20 for line in hatch for _, y in line.points)
    assert all(abs(x - FOOT_AT) < 50 for line in hatch for x, _ in line.points)


@pytest.mark.parametrize("ratchet", [True, False])
@pytest.mark.parametrize("frame", [SLIDES, BACKWARD])
def test_a_foot_that_slides_is_hollow_with_streaks_behind(frame, ratchet):
    world = world_of(Scene(ratchet=ratchet), 1.0)
    assert not shapes(frame, world, colour=STICKING)
    _, top, _, bottom = box_of(shapes(frame, world, colour=SLIDING, kind=Polygon))
    assert bottom <= GROUND
    hollow = [
        each for each in shapes(frame, world, colour=PAPER, kind=Polygon) if abs(each.points[0][0] - FOOT_AT) < 20
    ]
    assert len(hollow) == 1
    inside = box_of(hollow)
    assert top < inside[1] < inside[3] < bottom
    heading = 1 if frame is SLIDES else -1
    lines = shapes(frame, world, colour=SLIDING, kind=Line)
    streaks, teeth = [[each for each in lines if (each.width == 3) == wide] for wide in (True, False)]
    assert len(streaks) == 4
    assert all((x - FOOT_AT) * heading < -30 for each in streaks for x, _ in each.points)
    assert (len(teeth) == 5) == ratchet
    assert all((each.points[1][0] - each.points[0][0]) * heading < 0 for each in teeth)  # laid flat behind


def test_streaks_are_longer_the_faster_the_foot_is():
    def reach(speed):
        left, _, right, _ = box_of(
            shapes(RESTING._replace(foot_velocity=speed), colour=SLIDING, kind=Line, bottom=GROUND)
        )
        return right - left

    assert reach(0.1) < reach(0.5) < reach(1.2) < reach(1.4) == reach(100.0)


def test_an_anchored_body_is_clamped_to_a_wall():
    world = world_of(Scene(anchored=True), 1.0)
    for frame in (RESTING, SLIDES):
        assert "clamped" in words(frame, world)
        assert not shapes(frame, world, colour=STICKING)
        assert not shapes(frame, world, colour=SLIDING)
        hatch = [each for each in shapes(frame, world, colour=GREY, kind=Line) if len(each.points) == 2]
        _, top, right, bottom = box_of(hatch)
        assert right < FOOT_AT
        assert bottom - top > 100
        assert bottom <= GROUND
        bolts = [box_of([each]) for each in shapes(frame, world, colour=INK, kind=Polygon)]
        low, high = sorted((top, bottom) for left, top, right, bottom in bolts if bottom - top == pytest.approx(10))
        assert low[0] + high[1] == pytest.approx(2 * AXIS)  # as far above the body's axis as below it


@pytest.mark.parametrize(("slope", "angle"), [(0.05, 0.05), (-0.1, -0.1), (3.0, math.radians(7))])
def test_a_slope_turns_all_that_stands_on_it(slope, angle):
    world = world_of(Scene(slope=slope), 1.0)
    angle = math.copysign(math.atan(abs(angle)), angle) if abs(slope) < 1 else angle
    assert words(RESTING, world)[f"slope {slope:.3g}".replace("-", "−")].side == 1.0
    on_level = box_of(shapes(RESTING, colour=STICKING, kind=Polygon))
    on_slope = np.array([point for each in shapes(RESTING, world, colour=STICKING) for point in points_of(each)])
    corner = turned_point((on_level[0] + 7, on_level[1]), angle, PIVOT)
    assert np.abs(on_slope - corner).sum(axis=1).min() < 12
    # Uphill is to the right.
    assert np.sign(turned_point((WIDTH, GROUND), angle, PIVOT)[1] - GROUND) == -np.sign(slope)


def test_an_actuator_tells_how_steep_a_slope_is():
    actuator = Actuator.ecoflex()
    weight = actuator.mass * actuator.gravity / actuator.scales.force
    world = world_of(Scene(slope=weight * math.sin(math.radians(3))), 1.0, actuator)
    assert world.slope == "slope 3°"
    assert world.angle == pytest.approx(math.radians(3))
    assert world_of(Scene(), 1.0, actuator).slope == ""


@pytest.mark.parametrize("stretches", [(0.3,), (-1.0,), (0.1, 0.5), (0.2,) * 7, (0.005,) * 200])
def test_the_payload_is_where_the_stretches_put_it(stretches):
    frame = RESTING._replace(stretches=stretches)
    wheels = [each for each in shapes(frame, kind=Disc, colour=INK) if each.radius == 15]
    centre = np.mean([each.centre[0] for each in wheels])
    assert centre == pytest.approx(FOOT_AT + 240 + SCALE * sum(stretches))


def test_segments_are_as_long_as_they_are_stretched_and_told_apart():
    frame = RESTING._replace(stretches=(0.0, 1.0, 0.0))
    joints = [each for each in shapes(frame, kind=Line, colour=GREY) if len(each.points) == 2 and each.width == 2.5]
    first, second = sorted(each.points[0][0] for each in joints)
    rear, front = FOOT_AT + 19, FOOT_AT + 240 + SCALE - 33
    # Of the ways foot to joint, joint to joint and joint to payload the second is longer by one z_c.
    shares = np.diff([rear, first, second, front]) / (front - rear)
    np.testing.assert_allclose(shares, np.array([80, 140, 80]) / 300, rtol=1e-12)


def test_no_stretch_brings_the_payload_into_the_foot_or_out_of_the_picture():
    for stretch in (-50.0, 50.0, math.nan, math.inf, -math.inf):
        frame = RESTING._replace(stretches=(stretch,))
        wheels = [each for each in shapes(frame, kind=Disc, colour=INK) if each.radius == 15]
        assert min(each.centre[0] for each in wheels) > FOOT_AT + 60
        assert max(each.centre[0] for each in wheels) < WIDTH


@pytest.mark.parametrize("pressure", [0.0, 0.25, 1.0])
def test_the_gauge_is_as_full_as_the_body(pressure):
    gauge = shapes(RESTING._replace(pressure=pressure), colour=AIR, kind=Polygon, top=36, bottom=49)
    left, _, right, _ = box_of(gauge)
    assert (left, right - left) == (178, pytest.approx(150 * pressure))


def test_the_body_swells_with_pressure_and_thins_as_it_stretches():
    def height(**changes):
        frame = RESTING._replace(**changes)
        body = [each for each in shapes(frame, kind=Polygon) if len(each.points) == 26]
        return np.ptp([y for each in body for _, y in each.points])

    assert height(pressure=0.0) < height() < height(pressure=1.0)
    assert height(stretches=(2.0,)) < height() < height(stretches=(-1.0,))


@pytest.mark.parametrize(("scale", "step"), [(60.0, 2.0), (1.0, 200.0), (105.0, 1.0), (2400.0, 0.05), (104.9, 2.0)])
def test_labels_of_the_ruler_are_round_and_far_enough_apart(scale, step):
    assert ruler_step(scale) == pytest.approx(step)


@pytest.mark.parametrize("foot", [0.0, -7.25, 1001.0])
def test_the_ruler_says_where_the_foot_is(foot):
    said = words(RESTING._replace(foot=foot, camera=foot))
    mark = 2 * math.floor(foot / 2)
    at = said[f"{mark} z_c".replace("-", "−")].at[0]
    assert at == pytest.approx(FOOT_AT + SCALE * (mark - foot))


def past(count=41):
    time = np.linspace(0.0, 20.0, count)
    foot = np.floor(time / 5.0)
    return Past(time, foot, foot + 0.5, np.where(time % 5.0 < 1.0, 0.25, 0.0), (time % 2.0 < 1.0).astype(float))


def test_the_strip_shows_the_last_moments_where_the_foot_stuck_and_where_it_slid():
    frame = RESTING._replace(time=20.0, past=past())
    lower = {"top": LOWER + 20, "bottom": HEIGHT}
    blue, orange = (shapes(frame, colour=colour, kind=Line, **lower) for colour in (STICKING, SLIDING))
    hollow = shapes(frame, colour=PAPER, kind=Line, **lower)
    assert [each.points for each in hollow] == [each.points for each in orange]
    right = WIDTH - 16
    across = (right - 76) / 10.0
    # From 10 to 20 t_c it slid for two spells, and at the end.
    spans = sorted((right - x[0][0], right - x[-1][0]) for x in (each.points for each in orange))
    assert [(a / across, b / across) for a, b in spans] == [
        (pytest.approx(0.5), 0.0),
        (pytest.approx(5.5), pytest.approx(4.5)),
        (pytest.approx(9.5), pytest.approx(9.5)),
    ][: len(spans)] or len(spans) == 2
    heights = [line.points[0][1] for line in blue]
    assert heights == sorted(heights, reverse=True)  # forward is up
    air = shapes(frame, colour=AIR, kind=Polygon, **lower)
    assert sum(np.ptp([x for x, _ in each.points]) for each in air) / across == pytest.approx(5.0, abs=0.6)


def test_what_is_not_yet_known_is_not_drawn():
    drawing = composed(RESTING, WORLD)
    assert not [each for each in drawing if isinstance(each, Line) and each.colour == STICKING and each.width == 5][1:]


def test_the_message_shows_flips_what_was_sent_and_what_is_recalled():
    sent, recalled = np.array([0.1, -0.9, 0.1]), np.array([0.0, -0.45])
    message = Message((1, 0, 1, 1), (False, False, True, False), 1, sent, recalled, 0.9)
    frame = RESTING._replace(message=message)
    marks = [
        each for each in shapes(frame, colour=INK, top=LOWER, bottom=HEIGHT, kind=Polygon) if len(each.points) == 3
    ]
    (mark,) = marks
    cell = (WIDTH - 16 - 628) / 16
    assert mark.points[2][0] == pytest.approx(WIDTH - 16 - 2.5 * cell)  # of the third newest
    bars = shapes(frame, colour=MESSAGE, top=LOWER, bottom=HEIGHT - 20, kind=Polygon)
    (bar,) = [each for each in bars if np.ptp([y for _, y in each.points]) > 1]
    left, top, right, bottom = box_of([bar])
    # Of the hold before the newest that has ended; half as long as what was sent, and down.
    assert (left + right) / 2 == pytest.approx(WIDTH - 16 - 2.5 * cell)
    hollow = [
        each
        for each in shapes(frame, colour=GREY, top=LOWER + 60, bottom=HEIGHT - 20, kind=Polygon)
        if np.ptp([y for _, y in each.points]) > 20
    ]
    assert bottom - top == pytest.approx(0.5 * (box_of(hollow)[3] - top))
    assert "recalled by the readout" in words(frame)
    assert "recalled by the readout" not in words(RESTING)


@pytest.mark.parametrize("duffing", [0.0, 0.5, 1.0, 1e3, 1e9])
def test_the_static_stretch_balances_the_pressure(duffing):
    stretch = static_stretch(Groups(duffing=duffing))
    assert stretch + duffing * stretch**3 == pytest.approx(1.0, rel=1e-12)


def test_the_camera_follows_within_its_time_and_is_never_far_behind():
    camera = Camera(4.0)
    assert camera.follow(1.0, 0.0) == 1.0
    assert camera.follow(2.0, 1.5) == pytest.approx(2.0 - np.exp(-1))
    assert camera.follow(2.0, 1.5) == pytest.approx(2.0 - np.exp(-1))
    assert camera.follow(9.0, 1.5) == pytest.approx(9.0 - 1.4)
    assert camera.follow(0.0, 0.0) == 0.0  # a new episode


def test_a_box_with_round_corners_is_as_large_as_it_says():
    assert box_of([rounded(10, 20, 30, 40, INK, 5)]) == (10, 20, 40, 60)
    area = 0.0
    points = rounded(0, 0, 30, 40, INK, 5).points
    for (x, y), (u, v) in zip(points, points[1:] + points[:1], strict=True):
        area += (x * v - u * y) / 2
    assert abs(area) == pytest.approx(30 * 40 - (4 - math.pi) * 25, rel=2e-3)


@pytest.mark.parametrize("value", [0.0, -1e3, 1e9, -1e300, 1.7e308, math.inf, -math.inf, math.nan])
def test_no_value_is_too_wild(value):
    wild = Past(*(np.array([0.0, value, 1.0]) for _ in Past._fields))
    message = Message((1,), (True,), 0, np.array([value]), np.array([value]), 1.0)
    frame = Frame(value, (value, value), value, value, value, 1, value, wild, value, message)
    for each in composed(frame, WORLD):
        if not isinstance(each, Text):
            assert np.isfinite(points_of(each)).all()
