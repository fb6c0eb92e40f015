"""The search: the same by its seed, the same broken off and resumed, and blind to what it is tested on."""

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest

from stickslip.crawler import Scene, SolverError
from stickslip.studies.search import (
    body_space,
    Choice,
    echo_state_space,
    evolution,
    held_out_scores,
    Range,
    search,
    Space,
)
from stickslip.tasks import BodyReservoir, DelayLine, EchoState, Solution, TASKS
from stickslip.tasks.task import CAPACITY, NRMSE

SHORT = {
    "evaluations": 14,
    "exploration": 6,
    "finalists": 2,
    "validation_seeds": (50, 51),
    "length": 400,
    "washout": 20,
}


@dataclass
class Bowl:
    """A task whose least is known: the squared distance of a point from (0.3, 2), a little more by the seed."""

    more: bool = False

    def __post_init__(self):
        self.metric = CAPACITY if self.more else NRMSE
        self.asked = []

    def attempt(self, reservoir, *, length, seed, washout):
        self.asked.append(seed)
        x, y = reservoir
        distance = (x - 0.3) ** 2 + (math.log(y) - math.log(2)) ** 2 + 1e-9 * seed
        return Solution(-distance if self.more else distance)


PLANE = Space(
    {"x": Range(-1, 1), "y": Range(0.01, 100, log=True), "kind": Choice("ab")},
    lambda values: (values["x"], values["y"]) if values["kind"] == "a" else None,
)


@pytest.mark.parametrize("more", [False, True])
def test_the_optimum_is_found_and_what_cannot_be_built_is_not_tried(more):
    found = search(Bowl(more), PLANE, evaluations=400, exploration=40)
    assert found.values["x"] == pytest.approx(0.3, abs=0.01)
    assert found.values["y"] == pytest.approx(2, rel=0.02)
    assert found.values["kind"] == "a"
    assert len(found.evaluations) == 400


def test_ranges_and_choices_by_hand():
    assert [Range(1, 100, log=True).at(share) for share in (0, 0.5, 1)] == pytest.approx([1, 10, 100])
    assert Range(-1, 3).at(0.25) == 0
    assert [Choice("abc").at(share) for share in (0, 0.34, 0.99, 1)] == ["a", "b", "c", "c"]
    assert PLANE.where(kind="b", x=0.5).at(np.array([0.9, 0.5, 0.1])) == {"x": 0.5, "y": pytest.approx(1), "kind": "b"}


def test_equal_seeds_give_equal_searches():
    space = echo_state_space(8)
    first, again, other = (search(TASKS["NARMA-2 uniform NRMSE"], space, seed=seed, **SHORT) for seed in (1, 1, 2))
    assert first == again
    assert [e.point for e in first.evaluations] != [e.point for e in other.evaluations]


def test_a_search_broken_off_and_resumed_is_the_same(tmp_path, monkeypatch):
    """Broken off at any point, also after finalists were scored on more seeds, and in the middle of an evaluation."""
    whole = search(Bowl(), PLANE, **SHORT)
    file = tmp_path / "search.json"
    for evaluations in (3, 9, 11):
        search(Bowl(), PLANE, file=file, **{**SHORT, "evaluations": evaluations})

    def broken(self, reservoir, **which):
        self.asked.append(None)
        if len(self.asked) > 1:
            raise KeyboardInterrupt
        return attempt(self, reservoir, **which)

    attempt = Bowl.attempt
    monkeypatch.setattr(Bowl, "attempt", broken)
    with pytest.raises(KeyboardInterrupt):
        search(Bowl(), PLANE, file=file, **SHORT)
    monkeypatch.setattr(Bowl, "attempt", attempt)
    task = Bowl()
    resumed = search(task, PLANE, file=file, **SHORT)
    assert [e.point for e in resumed.evaluations] == [e.point for e in whole.evaluations]
    assert (resumed.values, resumed.validation) == (whole.values, whole.validation)
    assert task.asked.count(50) == 1 + 3  # of 14 points 11 were kept, and the first is scored again
    shorter = search(Bowl(), PLANE, file=file, **{**SHORT, "evaluations": 9})
    assert len(shorter.evaluations) == 9
    assert len(json.loads(file.read_text(encoding="utf-8"))["evaluations"]) == 14


def test_no_seed_but_those_of_validation_is_ever_asked_for():
    task = Bowl()
    search(task, PLANE, **SHORT)
    assert set(task.asked) == {50, 51}
    assert task.asked.count(50) == 14
    assert task.asked.count(51) == 2
    with pytest.raises(ValueError, match=r"seeds must hold none of the validation seeds, got \[51\]"):
        held_out_scores(task, (0, 1), range(40, 60, 11), validation_seeds=(50, 51))


def test_scores_of_held_out_seeds_are_the_tasks_own():
    task = TASKS["memory capacity"]
    scores, estimate = held_out_scores(task, DelayLine(5), [0, 1], length=900)
    assert scores == [task.attempt(DelayLine(5), length=900, seed=seed, washout=200).score for seed in (0, 1)]
    assert estimate.mean == pytest.approx(5, abs=1e-6)


def test_what_fails_is_passed_over():
    class Half(Bowl):
        def attempt(self, reservoir, **which):
            if reservoir[0] < 0:
                raise SolverError("stuck")
            if reservoir[0] < 0.1:
                return Solution(math.nan)
            return super().attempt(reservoir, **which)

    found = search(Half(), PLANE, **SHORT)
    assert found.values["x"] >= 0.1
    for evaluation in found.evaluations:
        assert (evaluation.scores is None) == (PLANE.at(np.array(evaluation.point))["x"] < 0.1)
        assert math.isnan(evaluation.score) == (evaluation.scores is None)


def test_a_search_that_runs_out_of_time_tells_the_best_so_far():
    found = search(Bowl(), PLANE, seconds=1e-9, **SHORT)
    assert len(found.evaluations) == 1


def test_progress_is_told():
    told = []
    search(Bowl(), PLANE, on_progress=lambda done, of: told.append((done, of)), **SHORT)
    assert told == [(k + 1, 14) for k in range(14)]


@pytest.mark.parametrize("features", [3, 4, 12, 60, 61])
def test_no_body_has_more_features_than_the_budget(features):
    space = body_space(features)
    random = np.random.default_rng(0)
    built = [space.build(space.at(random.random(len(space.dimensions)))) for _ in range(300)]
    bodies = [body for body in built if body is not None]
    assert len(bodies) > 30
    assert all(0 < body.features <= features for body in bodies)
    assert {body.scene.anchored for body in bodies} == {True, False}


def test_a_body_is_what_its_values_say():
    space = body_space(60)
    point = np.full(len(space.dimensions), 0.5)
    values = space.where(
        segments=10,
        ground="free",
        holds_per_sample=2,
        sample_time=1.0,
        tube_mass=9.0,
        readings="deformation, velocity, pressure",
    ).at(point)
    body = space.build(values)
    assert body.scene == Scene(segments=10, tube_mass=9.0, ratchet=False, slope=values["slope"])
    assert (body.hold, body.holds_per_sample) == (0.5, 2)
    assert body.groups.kinetic_friction == pytest.approx(values["kinetic_share"] * body.groups.static_friction)
    assert body.features == 42  # 2 x 10 + 1 readings, at two virtual nodes
    assert space.build({**values, "sample_time": 50.0}) is None
    assert space.build({**values, "damping_ratio": 100.0}) is None


def test_a_body_is_searched_for():
    found = search(TASKS["NARMA-2 uniform NRMSE"], body_space(6).where(segments=1), **{**SHORT, "evaluations": 8})
    assert isinstance(found.reservoir, BodyReservoir)
    assert found.validation < 0.9


def test_a_network_is_what_its_values_say():
    values = {"spectral_radius": 0.5, "input_scaling": 0.2, "leak": 0.3, "topology": "cycle", "centred": True}
    assert list(echo_state_space(9).dimensions) == list(values)
    network = echo_state_space(9).build(values)
    assert network == EchoState(9, 0.5, 0.2, leak=0.3, topology="cycle", centred=True)
    assert network(np.ones(3), 0).shape == (3, 9)
    assert all(candidate.leak == 0.3 for candidate in EchoState(9, tune=True, leak=0.3).candidates)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"evaluations": 0}, "evaluations must be a whole number >= 1, got 0"),
        ({"exploration": 3}, "exploration must be a whole number >= 4, got 3"),
        ({"finalists": 0}, "finalists must be a whole number >= 1, got 0"),
        ({"seed": -1}, "seed must be a whole number >= 0, got -1"),
        ({"seconds": 0}, r"seconds must be in \(0, inf\), got 0"),
        ({"length": 0}, "length must be a whole number >= 1, got 0"),
        ({"validation_seeds": ()}, r"validation_seeds must hold one seed at least and none twice, got \[\]"),
        ({"validation_seeds": (3, 3)}, "validation_seeds must hold one seed at least and none twice"),
        ({"space": Space({"x": Range(0, 1)}, lambda values: None)}, "space must hold reservoirs that can be built"),
    ],
)
def test_bad_input(arguments, message):
    with pytest.raises(ValueError, match=message):
        search(Bowl(), **{"space": PLANE, **SHORT, **arguments})


def test_a_space_none_of_which_can_do_the_task_is_refused():
    class Never(Bowl):
        def attempt(self, reservoir, **which):
            raise SolverError("stuck")

    with pytest.raises(ValueError, match="space must hold a reservoir that can do the task, got none in 14"):
        search(Never(), PLANE, **SHORT)


def test_a_file_of_another_search_is_refused(tmp_path):
    file = tmp_path / "search.json"
    search(Bowl(), PLANE, file=file, **SHORT)
    with pytest.raises(ValueError, match=r"seed must be 0 to go on with the search in .*, got 3; length must be 400"):
        search(Bowl(), PLANE, file=file, **{**SHORT, "seed": 3, "length": 401})
    with pytest.raises(ValueError, match=r"task must be 'Bowl\(more=False\)' to go on .*, got 'Bowl\(more=True\)'"):
        search(Bowl(True), PLANE, file=file, **SHORT)
    with pytest.raises(ValueError, match=r"space\.kind must be \"Choice\(values='ab'\)\" to go on"):
        search(Bowl(), PLANE.where(kind="a"), file=file, **SHORT)
    for text in ("", "[]", "{}", '{"settings": {}, "evaluations": [{"wheels": 4}]}'):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match="file must be one that a search has written, got"):
            search(Bowl(), PLANE, file=file, **SHORT)


@pytest.mark.parametrize("other", [name for name in TASKS if name != "memory capacity"])
def test_no_task_takes_the_scores_of_another(tmp_path, other):
    file = tmp_path / "search.json"
    small = {**SHORT, "evaluations": 1, "finalists": 1, "validation_seeds": (50,), "file": file}
    search(TASKS["memory capacity"], echo_state_space(3), **small)
    with pytest.raises(ValueError, match=rf"task must be 'memory capacity' to go on with .*, got '{other}'"):
        search(TASKS[other], echo_state_space(3), **small)


def test_a_budget_of_features_is_no_other(tmp_path):
    for space in (echo_state_space, lambda features: body_space(features).where(segments=1, sample_time=1.0)):
        file = tmp_path / f"{space.__name__}.json"
        search(TASKS["NARMA-2 NRMSE"], space(6), file=file, **SHORT)
        with pytest.raises(ValueError, match=r"build\.features must be 6 to go on with the search in .*, got 9"):
            search(TASKS["NARMA-2 NRMSE"], space(9), file=file, **SHORT)


def test_what_a_changed_measure_has_scored_is_not_gone_on_with(tmp_path, monkeypatch):
    file = tmp_path / "search.json"
    search(Bowl(), PLANE, file=file, **SHORT)
    attempt = Bowl.attempt

    def changed(self, reservoir, **which):
        return Solution(1.00001 * attempt(self, reservoir, **which).score)

    monkeypatch.setattr(Bowl, "attempt", changed)
    with pytest.raises(ValueError, match=r"the first score must be .* to go on .*: the task, its measure or the res"):
        search(Bowl(), PLANE, file=file, **SHORT)


@pytest.mark.parametrize(("kept", "today"), [(0.0, 9e-7), (2e-17, -9e-7), (1e6, 1e6 + 0.9), (-1e-6, -1.9e-6)])
def test_a_score_is_the_same_to_six_digits_of_itself_or_of_one(kept, today):
    """Rounding is another elsewhere, and of a score of nearly nothing it is all there is."""
    evaluations = [evolution.Evaluation([0.5], None), evolution.Evaluation([0.25], [kept, 3.0])]
    evolution._reproduce(None, evaluations, lambda each: [today, 7.0] if each is evaluations[1] else None)
    for other in ([today + 3 * (today - kept)], None):
        with pytest.raises(ValueError, match=r"^the first score must be "):
            evolution._reproduce(None, evaluations, lambda _, other=other: other)


def test_bad_spaces():
    with pytest.raises(ValueError, match=r"high must be in \[2\.0, inf\), got 1"):
        Range(2, 1)
    with pytest.raises(ValueError, match=r"low must be in \(0, inf\), got 0"):
        Range(0, 1, log=True)
    with pytest.raises(ValueError, match="values must hold one at least"):
        Choice([])
    with pytest.raises(ValueError, match="wheels"):
        PLANE.where(wheels=4)
    with pytest.raises(ValueError, match="features must be a whole number >= 3, got 1"):
        body_space(1)
