"""What a trade came to, against numbers that are worked out by hand."""

import csv
import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from policies_by_hand import negation

from stickslip.common.figures import PAGE_WIDTH
from stickslip.reservoir.targets import TARGETS
from stickslip.studies.trade import report
from stickslip.studies.trade.figure import plot_front
from stickslip.studies.trade.front import area, estimated, Evaluated, Front, fronts, gain, Point
from stickslip.studies.trade.learned import Learned
from stickslip.studies.trade.plan import Cell, CONDITIONED, JUDGED, LIMIT, OPEN_LOOP, Trade, TRAINED
from stickslip.studies.trade.portrait import imitation, portrait
from stickslip.studies.trade.report import areas, COLUMNS, rows, table, write_report

SPREAD = np.array([-0.01, 0.0, 0.01])


def point(kind, name, speed, memory, *, weight=None, seed=None, spread=SPREAD, paid=None):
    episodes = (None, None) if paid is None else (np.full(3, speed), np.full(3, paid))
    return Point(kind, name, weight, seed, speed + spread, memory + 0 * spread, *episodes)


def a_front(**changed):
    of = {
        "dither": 0.1,
        "open_loop": [point(OPEN_LOOP, "1", 0.1, 4.0), point(OPEN_LOOP, "110", 0.7, 2.0)],
        "held": [point("held open", "1", 0.1, 4.0), point("held shut", "0", 0.0, 3.0)],
        "policies": [
            point(TRAINED, "fast", 0.8, 2.0, weight=0.0, seed=0, paid=1.5),
            point(TRAINED, "between", 0.7, 3.0, weight=0.2, seed=0, paid=2.4),
            point(TRAINED, "slow", 0.1, 4.0, weight=1.0, seed=0, paid=3.0),
        ],
        "conditioned": [],
        "limit": {"speeds": [0.8, 0.85, 0.9]},
    }
    return Front(**{**of, **changed})


def test_areas_are_those_of_the_mean_points():
    front = a_front()
    # Each step as wide as what it is faster by, and as high as its memory.
    assert area(front.open_loop).mean == pytest.approx(0.1 * 4 + 0.6 * 2)
    assert area(front.policies).mean == pytest.approx(0.1 * 4 + 0.6 * 3 + 0.1 * 2)
    assert gain(front.policies, front.open_loop).mean == pytest.approx(2.4 / 1.6 - 1)


def test_an_interval_of_a_linear_statistic_is_students():
    """One point of constant memory: its area is proportional to the mean speed."""
    alone = [point(TRAINED, "alone", 0.5, 2.0, weight=0.0)]
    found, expected = area(alone), estimated(2 * alone[0].speeds)
    assert (found.mean, found.low, found.high) == pytest.approx((expected.mean, expected.low, expected.high))
    assert gain(alone, alone).mean == 0


def test_of_several_trainings_their_own_evaluations_choose():
    """Not the seeds that judge: on those another may have been luckier."""
    fast, between, slow = a_front().policies
    lucky = point(TRAINED, "lucky", 0.9, 3.9, weight=0.2, seed=1)
    front = a_front(
        policies=[replace(slow, evaluated=Evaluated(4.0)), replace(between, evaluated=Evaluated(1.1)), lucky, fast]
    )
    assert [each.name for each in front.chosen] == ["fast", "between", "slow"]
    assert (front.knee.name, front.fastest.name) == ("between", "fast")
    front = a_front(policies=[fast, between, slow, replace(lucky, evaluated=Evaluated(1.2))])
    assert [each.name for each in front.chosen] == ["fast", "lucky", "slow"]
    # What none surpasses in both is chosen as well, whatever it earns.
    unlucky = replace(lucky, evaluated=Evaluated(-1.0, 0.8, 3.0))
    seen = [replace(each, evaluated=Evaluated(0.0, 0.7, 3.1)) for each in (fast, between, slow)]
    assert unlucky in a_front(policies=[*seen, unlucky]).chosen
    assert unlucky not in a_front(policies=[*seen, replace(fast, evaluated=Evaluated(0.0, 0.8, 3.1)), unlucky]).chosen
    above = [replace(each, weight=None, floor=0.3) for each in (between, lucky)]
    chosen = a_front(policies=[fast, slow, above[0], replace(above[1], evaluated=Evaluated(0.1))]).chosen
    assert [each.name for each in chosen] == ["fast", "slow", "lucky"]
    assert front.fastest.name == "lucky"
    alone = "policies of one seed, least and most of 2"
    assert [each[0] for each in areas(front)] == ["", OPEN_LOOP, "policies", alone]
    # Of the second seed there is one policy; of the first there are three, of area 2.4. Open loop has 1.6.
    assert areas(front)[-1][1:] == ["2.40 to 3.51", "+50 to +119"]
    assert "lucky" not in str(table(a_front(policies=[*a_front().policies, replace(lucky, evaluated=Evaluated(-1.0))])))
    assert front.summary()["policies"]["hypervolume"]["mean"] == area(front.chosen).mean


def test_the_knee_is_farthest_above_the_chord():
    assert a_front().knee.name == "between"
    on_the_chord = point(TRAINED, "between", 0.45, 3.0, weight=0.2)
    policies = a_front().policies
    assert a_front(policies=[policies[0], on_the_chord, policies[2]]).knee is None
    assert a_front(policies=policies[:1]).knee is None
    assert a_front(policies=[]).knee is None


def test_a_policy_loses_where_it_earns_less_than_a_schedule_at_its_own_weight():
    front = a_front()
    assert front.losses() == []
    # At weight 1 held open earns 4; at weight 0 the word earns 0.7.
    worse = [
        point(TRAINED, "forgetful", 0.5, 3.9, weight=1.0, spread=0 * SPREAD),
        point(TRAINED, "slow", 0.6, 3.0, weight=0.0),
        point(TRAINED, "not surely slow", 0.695, 3.0, weight=0.0, spread=3 * SPREAD),
    ]
    front = a_front(policies=worse)
    assert front.lead(worse[1]).mean == pytest.approx(0.6 - 0.7)
    assert [each.name for each in front.losses()] == ["forgetful", "slow"]
    assert front.lead(worse[2]).mean == pytest.approx(-0.005)


def results(trade):
    found = {}
    for cell in (cell for stage in trade.cells() for cell in stage):
        if cell.kind == OPEN_LOOP:
            numbers = {"names": ["1", "110"], "speeds": [[0.1, 0.1], [0.7, 0.72]], "memories": [[4.0, 4.1], [2.0, 2.0]]}
            held = {"names": ["0", "1"], "speeds": [[0.0, 0.0], [0.1, 0.1]], "memories": [[3.0, 3.0], [4.0, 4.1]]}
            if cell.dither == 0:
                numbers, held = ({**each, "memories": [[0.0, 0.0]] * 2} for each in (numbers, held))
            found[cell] = {"front": numbers, "held": held}
        elif cell.kind == LIMIT:
            found[cell] = {"speeds": [0.84, 0.85]}
        elif cell.judges is not None:
            weight = 0.9 if cell.weight is None else cell.weight
            speed = 0.8 - 0.5 * weight
            found[cell] = {
                "evaluated": {"reward": 10 * weight + (cell.seed or 0), "speed": speed, "memory": weight},
                "speeds": [speed, speed + 0.01],
                "memories": [2 + weight, 2.1 + weight] if cell.dither else [0.0, 0.0],
                "episodes": {"speeds": [speed, speed], "memories": [1.5, 1.5]},
            }
        else:
            found[cell] = {}
    return found


def test_points_come_from_the_cells_of_their_dither():
    trade = Trade(weights=(0.0, 0.5), dithers=(0.0, 0.1), seeds=1, floors=(0.3,), conditioned=True)
    quiet, front = fronts(trade, results(trade))
    assert (quiet.dither, front.dither) == (0.0, 0.1)
    assert [each.weight for each in quiet.policies] == [0.0]
    assert [(each.kind, each.weight) for each in front.policies + front.conditioned] == [
        (TRAINED, 0.0),
        (TRAINED, 0.5),
        (TRAINED, None),
        (CONDITIONED, 0.0),
        (CONDITIONED, 0.5),
    ]
    assert [(each.kind, each.name) for each in front.held] == [("held open", "1"), ("held shut", "0")]
    assert front.policies[1].mean == pytest.approx((0.555, 2.55))
    assert [(each.floor, each.evaluated.reward) for each in front.policies] == [(None, 0.0), (None, 5.0), (0.3, 9.0)]
    assert [each.weight for each in front.losses()] == [0.5, 0.5]  # what has no weight has no reward to lose by
    assert [row[1] for row in table(front) if row[0] == "policy seed 0"] == ["0", "0.5", "floor 0.3"]
    assert front.speed_limit.mean == pytest.approx(0.845)
    assert Cell(JUDGED[TRAINED], 0.1, 0.5, 0).name == "judged-" + front.policies[1].name


def test_what_is_written_says_what_was_found(tmp_path, monkeypatch):
    trade = Trade(weights=(0.0, 0.5), dithers=(0.0, 0.1), seeds=1, conditioned=True)
    found = fronts(trade, results(trade))
    register = point("register", "1100", 0.7, 3.0)
    pictures = {"knee": portrait(negation(2), holds=60, seeds=range(2))}
    imitations = {"knee": {2: imitation(pictures["knee"], 2)}}
    looked_at = Learned(pictures, {"knee": np.zeros(4)}, imitations, {"knee": (2, register)})
    monkeypatch.setattr(report, "learned", lambda folder, front: looked_at if front is found[1] else None)
    write_report(SimpleNamespace(folder=tmp_path, trade=trade), found)
    assert {file.name for file in tmp_path.iterdir()} == {
        "front.csv",
        "front.json",
        "front-0.1.png",
        "learned-0.1.png",
        "index.md",
    }
    with (tmp_path / "front.csv").open(encoding="utf-8", newline="") as text:
        written = list(csv.DictReader(text))
    assert tuple(written[0]) == COLUMNS
    assert len(written) == sum(len(front.points) for front in found)
    fast = next(row for row in written if row["dither"] == "0.1" and row["kind"] == TRAINED)
    assert float(fast["speed"]) == pytest.approx(0.805)
    assert float(fast["lead"]) == pytest.approx(0.805 - 0.71)
    assert float(fast["episode_memory"]) == 1.5
    dithers = json.loads((tmp_path / "front.json").read_text(encoding="utf-8"))["dithers"]
    assert set(dithers["0.0"]) == {"speed limit", "losses", "fastest"}  # without flips there is no memory
    assert dithers["0.0"]["fastest"]["speed"]["mean"] == pytest.approx(0.805)
    told = dithers["0.1"]
    assert told["policies"]["hypervolume"]["mean"] == area(found[1].policies).mean
    page = (tmp_path / "index.md").read_text(encoding="utf-8")
    assert "![Speed against memory capacity](front-0.1.png)" in page
    assert page.count("## Dither") == 2
    assert "A register of the last 2 valve states, table 1100, commands as the knee policy does in 100.0% of" in page
    assert "By itself it comes to speed 0.700 [0.675, 0.725] and memory 3.00." in page


def test_tables_have_a_row_a_policy_and_say_what_an_episode_pays():
    heading, *body = table(a_front())
    assert {len(row) for row in body} == {len(heading)}
    assert [row[0] for row in body if row[0].startswith("policy")] == ["policy seed 0"] * 3
    assert [row[-2] for row in body][-2] == "2.40 (80%)"
    assert all(set(row) == set(COLUMNS) for row in rows(a_front()))
    # The ends of an interval stand behind its mean.
    ends = [k for k, name in enumerate(COLUMNS) if name.endswith("_low")]
    assert len(ends) > 1
    for k in ends:
        mean = COLUMNS[k].removesuffix("_low")
        assert COLUMNS[k - 1 : k + 2] == (mean, f"{mean}_low", f"{mean}_high")


def test_the_figure_shows_every_point_and_what_bounds_them():
    fast, between, slow = a_front().policies
    policies = [replace(fast, body_memories=np.full(3, 1.0)), replace(between, body_memories=np.full(3, 1.5)), slow]
    conditioned = [point(CONDITIONED, "c", 0.78, 2.1, weight=w, seed=0) for w in (0.5, 0.0)]
    figure = plot_front(a_front(policies=policies, conditioned=conditioned), weight=0.25)
    (ax,) = figure.axes
    drawn = {line.get_label(): line.get_xydata() for line in ax.lines if not line.get_label().startswith("_")}
    np.testing.assert_allclose(drawn["one policy a weight"], [each.mean for each in policies])
    np.testing.assert_allclose(drawn["one policy for all weights"], [[0.78, 2.1]] * 2)
    np.testing.assert_allclose(drawn["its body's share of memory"], [[0.8, 1.0], [0.7, 1.5]])
    np.testing.assert_allclose(drawn["best open-loop words"], [[0.7, 2.0], [0.1, 4.0]])
    unnamed = [line.get_xydata() for line in ax.lines if line.get_label().startswith("_")]
    assert any(np.allclose(line[:, 0], 0.85) for line in unnamed)  # the limit
    # Along the dotted lines the reward is the same.
    dotted = [line.get_xydata() for line in ax.lines if line.get_linestyle() == ":" and len(line.get_xdata())]
    assert len(dotted) == 6
    for line in dotted:
        assert np.ptp(0.75 * line[:, 0] + 0.25 * line[:, 1]) == pytest.approx(0)
    assert {text.get_text() for text in ax.texts} == {"speed limit", "knee", "held open"}
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("speed ($z_c / t_c$)", "memory capacity (holds)")
    assert figure.get_size_inches()[0] <= PAGE_WIDTH


def test_the_knee_s_name_touches_no_line():
    found = (0.74, 3.25, 0.4), (0.71, 3.3, 0.5), (0.83, 2.4, 0.0)
    near = [point(TRAINED, "a", speed, memory, weight=weight, seed=0) for speed, memory, weight in found]
    figure = plot_front(a_front(policies=near))
    figure.canvas.draw()
    (ax,) = figure.axes
    (name,) = [text for text in ax.texts if text.get_text() == "knee"]
    box = name.get_window_extent()
    solid = [line for line in ax.lines if line.get_linestyle() in ("-", "--")]
    for line in solid:
        path = line.get_transform().transform_path(line.get_path())
        assert not path.intersects_bbox(box, filled=False), line.get_label()


def test_a_front_without_policies_is_drawn_by_what_there_is_and_by_speed_alone_where_memory_weighs_nothing():
    (ax,) = plot_front(a_front(policies=[]), weight=0.0).axes
    labels = {line.get_label() for line in ax.lines if not line.get_label().startswith("_")}
    assert labels == {"best open-loop words", "equal reward, memory weight 0"}
    assert {text.get_text() for text in ax.texts} == {"speed limit", "held open"}
    right, top = 1.12 * 0.85, 1.12 * 4.0
    assert (ax.get_xlim(), ax.get_ylim()) == (pytest.approx((0.0, right)), pytest.approx((0.0, top)))
    dotted = [line.get_xdata() for line in ax.lines if line.get_linestyle() == ":" and len(line.get_xdata())]
    np.testing.assert_allclose(dotted, [[right * k / 7] * 2 for k in range(1, 7)])


def test_a_figure_names_what_the_memory_is_of():
    trade = Trade(weights=(0.0,), env_kwargs={"target": "parity"}, seeds=1, conditioned=False)
    [front] = fronts(trade, results(trade))
    assert plot_front(front).axes[0].get_ylabel() == "capacity for products of flips"


@pytest.mark.parametrize("target", TARGETS)
def test_there_is_a_name_for_every_target(target):
    assert plot_front(a_front(target=target)).axes[0].get_ylabel()


def test_there_is_no_figure_of_memory_without_flips():
    with pytest.raises(ValueError, match="front must have a dither above 0 to have memory, got 0"):
        plot_front(a_front(dither=0.0))
