"""The search argument by argument, and the spaces number by number."""

import inspect
import json
import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from stickslip.crawler import Groups, Scene
from stickslip.reservoir import Estimate
from stickslip.studies.search import (
    body_space,
    Choice,
    crawler_space,
    echo_state_space,
    held_out_scores,
    Range,
    search,
    Space,
)
from stickslip.studies.search.evolution import Evaluation
from stickslip.tasks import BodyReservoir, Solution, TASKS
from stickslip.tasks.task import CAPACITY, mean_score, NRMSE

SHORT = {"evaluations": 30, "exploration": 8, "validation_seeds": (50, 51), "length": 400, "washout": 20}


@dataclass
class Bowl:
    """A task whose least is known, and which keeps what it was asked with."""

    more: bool = False
    asked: list = field(default_factory=list, compare=False, repr=False)

    @property
    def metric(self):
        return CAPACITY if self.more else NRMSE

    def attempt(self, reservoir, *, length, seed, washout):
        self.asked.append((length, seed, washout))
        x, y = reservoir
        distance = (x - 0.3) ** 2 + (math.log(y) - math.log(2)) ** 2 + 1e-9 * seed
        return Solution(-distance if self.more else distance)


PLANE = Space(
    {"x": Range(-1, 1), "y": Range(0.01, 100, log=True), "kind": Choice("ab")},
    lambda values: (values["x"], values["y"]) if values["kind"] == "a" else None,
)


def buildable(seed, k):
    """The first draw of the generator of point k that can be built."""
    random = np.random.default_rng([seed, k])
    return next(p.tolist() for p in (random.random(3) for _ in range(99)) if p[2] < 0.5)


def test_arguments_by_default():
    task = Bowl()
    found = search(task, PLANE)
    assert len(found.evaluations) == 300
    assert {(length, washout) for length, _, washout in task.asked} == {(3000, 200)}
    seeds = [seed for _, seed, _ in task.asked]
    assert seeds == [1000] * 300 + [1001, 1002, 1003] * 5
    drawn = [evaluation.point == buildable(0, k) for k, evaluation in enumerate(found.evaluations)]
    assert drawn == [k < 60 for k in range(300)]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"length": 77}, (77, 50, 20)),
        ({"washout": 5}, (400, 50, 5)),
        ({"validation_seeds": (9, 8)}, (400, 9, 20)),
    ],
)
def test_a_task_is_asked_for_what_the_search_was_given(change, expected):
    task = Bowl()
    search(task, PLANE, **{**SHORT, **change})
    assert set(task.asked[:30]) == {expected}


@pytest.mark.parametrize("change", [{"exploration": 5}, {"seed": 4}])
def test_points_depend_on_exploration_and_seed(change):
    found = search(Bowl(), PLANE, **{**SHORT, **change})
    first = change.get("exploration", 8)
    drawn = [evaluation.point == buildable(change.get("seed", 0), k) for k, evaluation in enumerate(found.evaluations)]
    assert drawn == [k < first for k in range(30)]


@pytest.mark.parametrize("finalists", [1, 3])
def test_finalists_are_the_best_on_the_first_seed_and_scored_on_all(finalists):
    found = search(Bowl(), PLANE, **SHORT, finalists=finalists)
    of_first = [evaluation.scores[0] for evaluation in found.evaluations]
    best = sorted(range(30), key=of_first.__getitem__)[:finalists]
    assert [k for k in range(30) if len(found.evaluations[k].scores) == 2] == sorted(best)
    assert found.validation == min(found.evaluations[k].score for k in best)
    assert found.evaluations[best[0]].score == pytest.approx(np.mean(found.evaluations[best[0]].scores))
    assert found.values == PLANE.at(np.array(found.evaluations[best[0]].point))
    assert found.reservoir == (found.values["x"], found.values["y"])


def test_the_best_finalist_is_the_best_in_the_mean():
    """The one that leads on the first seed falls behind on the second."""

    class Turning(Bowl):
        def attempt(self, reservoir, *, length, seed, washout):
            x, _ = reservoir
            return Solution(x if seed == 50 else -10 * x)

    found = search(Turning(), PLANE, **SHORT, finalists=3)
    three = sorted(evaluation.scores[0] for evaluation in found.evaluations)[:3]
    assert found.values["x"] == three[2]
    assert found.validation == pytest.approx(-4.5 * three[2])


@pytest.mark.parametrize("change", [{"washout": 21}, {"length": 401}, {"exploration": 9}, {"seed": 1}])
def test_a_search_resumed_with_another_argument_is_refused(tmp_path, change):
    file = tmp_path / "search.json"
    search(Bowl(), PLANE, file=file, **SHORT)
    [(name, value)] = change.items()
    with pytest.raises(ValueError, match=rf"{name} must be {SHORT.get(name, 0)} to go on with .*, got {value}$"):
        search(Bowl(), PLANE, file=file, **{**SHORT, **change})
    with pytest.raises(ValueError, match=r"validation_seeds must be \[50, 51\] to go on with .*, got \[50, 52\]$"):
        search(Bowl(), PLANE, file=file, **{**SHORT, "validation_seeds": (50, 52)})


def test_what_may_differ_when_a_search_goes_on(tmp_path):
    file = tmp_path / "search.json"
    search(Bowl(), PLANE, file=file, **SHORT, finalists=1)
    again = search(Bowl(), PLANE, file=file, **{**SHORT, "evaluations": 20}, finalists=4, seconds=99.0)
    whole = search(Bowl(), PLANE, **{**SHORT, "evaluations": 20}, finalists=4)
    assert [evaluation.point for evaluation in again.evaluations] == [
        evaluation.point for evaluation in whole.evaluations
    ]
    assert (again.values, again.validation) == (whole.values, whole.validation)
    kept = json.loads(file.read_text(encoding="utf-8"))
    assert kept["settings"] == {
        "task": "Bowl(more=False)",
        "space": {
            "x": "Range(low=-1, high=1, log=False)",
            "y": "Range(low=0.01, high=100, log=True)",
            "kind": "Choice(values='ab')",
        },
        "build": "<lambda>",
        "seed": 0,
        "exploration": 8,
        "validation_seeds": [50, 51],
        "length": 400,
        "washout": 20,
    }
    assert len(kept["evaluations"]) == 30
    assert set(kept["evaluations"][0]) == {"point", "scores"}


def test_the_points_of_a_search_do_not_move():
    """By NumPy's generator and this search alone: what is kept of searches is resumed from them."""
    points = np.array([evaluation.point for evaluation in search(Bowl(), PLANE, **SHORT).evaluations])
    np.testing.assert_allclose(points[[8, 15, 29]], GOLDEN_POINTS, rtol=0, atol=1e-9)


GOLDEN_POINTS = [
    [0.7679342072, 0.2285926718, 0.4106465957],
    [0.7679342072, 0.3435884559, 0.4106465957],
    [0.4012995047, 0.5663209919, 0.4114381378],
]


def test_a_varied_point_stays_in_the_cube_and_choices_are_redrawn():
    found = search(
        Bowl(), PLANE, evaluations=200, exploration=8, finalists=1, validation_seeds=(50,), length=9, washout=0
    )
    points = np.array([evaluation.point for evaluation in found.evaluations])
    assert ((points >= 0) & (points <= 1)).all()
    # A dimension with an order moves in 4 of 10 points, a choice is redrawn in 1 of 10.
    same = np.array([[(points[:k, d] == points[k, d]).any() for d in range(3)] for k in range(8, 200)]).mean(axis=0)
    assert same[:2] == pytest.approx([0.6, 0.6], abs=0.12)
    assert same[2] == pytest.approx(0.9, abs=0.1)


def test_time_is_up_after_the_seconds_that_were_given(monkeypatch):
    now = iter(range(1000))
    monkeypatch.setattr("stickslip.studies.search.evolution.time.monotonic", lambda: float(next(now)))
    found = search(Bowl(), PLANE, **SHORT, seconds=7.5)
    # Asked once before the first point and once before each one after it: at 0 for the start, and at 1 to 8.
    assert len(found.evaluations) == 8


def test_an_evaluation_without_scores_has_none():
    assert math.isnan(Evaluation([0.5], None).score)
    assert math.isnan(Evaluation([0.5], []).score)
    assert Evaluation([0.5], [1.0, 2.0]).score == 1.5


def test_held_out_scores_argument_by_argument():
    task = Bowl()
    scores, estimate = held_out_scores(task, (0.3, 2.0), range(3))
    assert task.asked == [(4000, seed, 200) for seed in range(3)]
    assert scores == pytest.approx([0.0, 1e-9, 2e-9], abs=1e-15)
    task.asked.clear()
    held_out_scores(task, (0.3, 2.0), [4, 5], validation_seeds=[6], length=10, washout=3)
    assert task.asked == [(10, 4, 3), (10, 5, 3)]
    assert estimate == mean_score(task, scores)
    assert isinstance(estimate, Estimate)
    with pytest.raises(ValueError, match="seeds must hold one seed at least and none twice, got"):
        held_out_scores(task, (0.3, 2.0), [4, 4])

    class Counted:
        features = 3

        def __call__(self, series, seed):
            return np.zeros((len(series), 3))

    @dataclass
    class Full(Bowl):
        def attempt(self, reservoir, *, length, seed, washout):
            return Solution(2.9 - 0.1 * seed)

    # No more can be remembered than there are features.
    assert held_out_scores(Full(True), Counted(), [0, 1, 2])[1].high == 3.0


BODY = {
    "segments": Choice([1, 2, 3, 5, 6, 10, 15, 20, 30, 60]),
    "ground": Choice(("anchored", "ratchet", "free")),
    "readings": Choice(("deformation", "velocity", "deformation, velocity", "deformation, velocity, pressure")),
    "encoding": Choice(("threshold", "pulse_width", "sigma_delta")),
    "holds_per_sample": Choice((1, 2, 4)),
    "sample_time": Range(0.03, 10.0, log=True),
    "tube_mass": Range(0.1, 300.0, log=True),
    "slope": Range(-0.5, 0.5),
    "duffing": Range(1e-3, 10.0, log=True),
    "damping_ratio": Range(1e-4, 3.0, log=True),
    "deborah": Range(5e-3, 5.0, log=True),
    "radial_coupling": Range(1e-3, 2.0, log=True),
    "foot_mass_fraction": Range(0.02, 0.98),
    "static_friction": Range(1e-3, 1.0, log=True),
    "kinetic_share": Range(0.0, 1.0),
}


def test_the_space_of_bodies_number_by_number():
    assert dict(body_space(60).dimensions) == BODY
    assert body_space(9).dimensions["segments"] == Choice([1, 2, 3, 5, 6])
    assert dict(echo_state_space(9).dimensions) == {
        "spectral_radius": Range(0.1, 1.3),
        "input_scaling": Range(0.01, 5.0, log=True),
        "leak": Range(0.1, 1.0),
        "topology": Choice(("random", "cycle", "orthogonal")),
        "centred": Choice((False, True)),
    }


VALUES = {
    "segments": 3,
    "ground": "ratchet",
    "readings": "deformation, velocity",
    "encoding": "sigma_delta",
    "holds_per_sample": 4,
    "sample_time": 2.0,
    "tube_mass": 5.0,
    "slope": -0.25,
    "duffing": 1.5,
    "damping_ratio": 0.1,
    "deborah": 0.75,
    "radial_coupling": 0.3,
    "foot_mass_fraction": 0.4,
    "static_friction": 0.8,
    "kinetic_share": 0.25,
}
GROUPS = Groups(
    duffing=1.5,
    damping_ratio=0.1,
    deborah=0.75,
    radial_coupling=0.3,
    foot_mass_fraction=0.4,
    static_friction=0.8,
    kinetic_friction=0.2,
)


@pytest.mark.parametrize(
    ("change", "scene", "readings", "nodes"),
    [
        ({}, Scene(ratchet=True, slope=-0.25, segments=3, tube_mass=5.0), ("deformation", "velocity"), 2),
        (
            {"ground": "free"},
            Scene(ratchet=False, slope=-0.25, segments=3, tube_mass=5.0),
            ("deformation", "velocity"),
            2,
        ),
        (
            {"ground": "anchored"},
            Scene(anchored=True, slope=-0.25, segments=3, tube_mass=5.0),
            ("deformation", "velocity"),
            2,
        ),
        ({"segments": 1}, Scene(slope=-0.25), ("deformation", "velocity"), 6),
        ({"readings": "deformation"}, Scene(slope=-0.25, segments=3, tube_mass=5.0), ("deformation",), 4),
        (
            {"readings": "deformation, velocity, pressure"},
            Scene(slope=-0.25, segments=3, tube_mass=5.0),
            ("deformation", "velocity", "pressure"),
            1,
        ),
    ],
)
def test_a_body_of_given_values(change, scene, readings, nodes):
    assert body_space(13).build({**VALUES, **change}) == BodyReservoir(
        GROUPS,
        scene,
        hold=0.5,
        encoding="sigma_delta",
        holds_per_sample=4,
        virtual_nodes=nodes,
        readings=readings,
        tolerance=1e-7,
    )


@pytest.mark.parametrize(
    ("change", "built"),
    [
        # 2 segments / sqrt(mass) radians a unit of time: 12 in a sample at most.
        ({"tube_mass": 1.0, "sample_time": 1.99, "damping_ratio": 1e-4}, True),
        ({"tube_mass": 1.0, "sample_time": 2.01, "damping_ratio": 1e-4}, False),
        # 8 damping segments^2 / mass time constants a unit of time: 30 in a sample at most.
        ({"damping_ratio": 30 * 5 / (2 * 8 * 9) - 0.01}, True),
        ({"damping_ratio": 30 * 5 / (2 * 8 * 9) + 0.01}, False),
        ({"segments": 15}, False),  # of more readings than 13 features
        ({"segments": 6, "readings": "deformation, velocity, pressure"}, True),
    ],
)
def test_bodies_that_cost_too_much_are_left_out(change, built):
    assert (body_space(13).build({**VALUES, **change}) is not None) == built


def test_the_numbers_of_one_body_are_a_space_in_the_words_of_randomize():
    body = BodyReservoir(scene={"ratchet": False}, virtual_nodes=2)
    space = crawler_space(body, {"slope": (-0.1, 0.1), "hold": Range(0.1, 10, log=True), "kinetic_friction": (0, 1)})
    assert space.dimensions == {
        "hold": Range(0.1, 10, log=True), "kinetic_friction": Range(0, 1), "slope": Range(-0.1, 0.1)
    }  # fmt: skip
    found = space.build(space.at(np.array([0.5, 0.25, 1.0])))
    assert found.hold == pytest.approx(1.0)
    world = {"ratchet": False, "slope": 0.1}
    assert replace(found, hold=0.5) == BodyReservoir({"kinetic_friction": 0.25}, world, virtual_nodes=2)
    assert space.build(space.at(np.array([0.5, 0.31, 1.0]))) is None  # more than static friction
    assert crawler_space(body, {"static_friction": (0, 1)}).build({"static_friction": 0.1}) is None
    assert (
        crawler_space(body, {"static_friction": (0, 1)}).build({"static_friction": 0.2}).groups.static_friction == 0.2
    )
    with pytest.raises(ValueError, match="varying has no 'wheels'"):
        crawler_space(body, {"wheels": (1, 2)})
    best = search(
        TASKS["memory capacity"], crawler_space(BodyReservoir(), {"hold": (0.3, 0.9)}), **{**SHORT, "evaluations": 4}
    )
    assert 0.3 <= best.reservoir.hold <= 0.9


def test_a_range_at_its_ends_and_a_choice_of_none():
    assert (Range(2.0, 8.0).at(0.0), Range(2.0, 8.0).at(1.0), Range(2.0, 8.0).at(0.25)) == (2.0, 8.0, 3.5)
    assert Range(2.0, 8.0, log=True).at(0.5) == pytest.approx(4.0)
    assert Range(2.0, 8.0) == Range(2.0, 8.0, log=False)
    with pytest.raises(ValueError, match="values must hold one at least to choose from, got none"):
        Choice(())


def test_a_space_where_some_are_fixed():
    space = PLANE.where(x=0.25)
    assert space.dimensions == {**PLANE.dimensions, "x": Choice([0.25])}
    assert list(space.dimensions) == list(PLANE.dimensions)
    assert space.build is PLANE.build
    with pytest.raises(TypeError, match="x must be a number in"):
        PLANE.where(x="a")
    with pytest.raises(ValueError, match="kind has no 'c'"):
        PLANE.where(kind="c")
    with pytest.raises(ValueError, match="space has no 'z'"):
        PLANE.where(z=1)


def test_a_registered_task_is_kept_by_its_name(tmp_path):
    file = tmp_path / "search.json"
    of = {"evaluations": 1, "exploration": 4, "finalists": 1, "validation_seeds": (50,), "length": 400, "washout": 20}
    search(TASKS["NARMA-2 NRMSE"], echo_state_space(3), file=file, **of)
    assert json.loads(file.read_text(encoding="utf-8"))["settings"]["task"] == "NARMA-2 NRMSE"


def test_every_optional_argument_is_tried_here():
    """A new one is to be tried too."""
    assert list(inspect.signature(search).parameters) == [
        "task", "space", "evaluations", "exploration", "seed", "validation_seeds", "finalists", "length", "washout",
        "seconds", "file", "on_progress",
    ]  # fmt: skip
