"""What a file was made for, and how what it was not made for is refused."""

import json
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from stickslip.common.fingerprint import described, Difference, differences, refuse_other, rounded
from stickslip.crawler import Groups


def scale(factor, number):
    return factor * number


class Pair(NamedTuple):
    left: object
    right: object


@dataclass(frozen=True)
class Thing:
    size: float
    made_by: object = None
    cache: list = field(default_factory=list, compare=False)


class Plain:
    pass


def closure(enclosed):
    return lambda: enclosed


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (np.float64(0.5), 0.5),
        (np.int64(3), 3),
        (float("inf"), "inf"),
        (range(3), [0, 1, 2]),
        ({"a": (1, None), 2: True}, {"a": [1, None], "2": True}),
        ({"b", "a"}, ["a", "b"]),
        (Path("runs") / "bench", "runs/bench"),
        (partial(scale, 2.0, number=3), {"function": "scale", "factor": 2.0, "number": 3}),
        (Thing(1.0, partial(scale, 2), cache=[1]), "Thing(size=1.0, made_by=scale(2))"),
        (Pair(Plain(), scale), "Pair(left=Plain, right=scale)"),
        (closure(60), "closure.<locals>.<lambda>[enclosed=60]"),
        (Plain, "Plain"),
    ],
)
def test_descriptions_by_hand(value, expected):
    assert described(value) == expected
    assert json.loads(json.dumps(described(value))) == expected


def test_a_description_does_not_depend_on_the_place_in_memory_and_tells_values_apart():
    assert described([Plain(), closure(Plain())]) == described([Plain(), closure(Plain())])
    one, other = np.arange(3.0), np.array([0.0, 1.0, 3.0])
    assert described(one) == described(one.copy()) != described(other)
    assert described(Groups()) == described(Groups()) != described(Groups(duffing=0.6))
    assert described(closure(one)) != described(closure(other))


def test_differences_are_named_to_the_last_entry():
    kept = {"seed": 0, "body": {"hold": 0.5, "scene": {}}, "list": [1, 2], "old": None}
    asked = {"seed": 1, "body": {"hold": 0.5, "scene": {"slope": 0.1}}, "list": [1, 3]}
    found = differences(kept, asked)
    assert [name for name, _, _ in found] == ["seed", "body.scene.slope", "list", "old"]
    assert found[0] == Difference("seed", 0, 1)
    assert differences(kept, kept) == []
    assert [name for name, _, _ in differences({"flag": 1}, {"flag": True})] == ["flag"]


def test_what_may_grow_is_compared_where_both_have_it():
    kept = {"tasks": {"a": {"score": 1.0}, "b": 2}}
    assert differences(kept, {"tasks": {"b": 2, "c": 3}}, growing=["tasks"]) == []
    found = differences(kept, {"tasks": {"a": {"score": 1.5}, "c": 3}}, growing=["tasks"])
    assert found == [Difference("tasks.a.score", 1.0, 1.5)]


def test_a_refusal_names_every_difference():
    with pytest.raises(
        ValueError, match=r"^a must be 1 to go on with it, got 2; b must be absent to go on with it, got 'x'$"
    ):
        refuse_other("to go on with it", {"a": 1}, {"a": 2, "b": "x"})
    refuse_other("to go on with it", {"a": 1}, {"a": 1})


def test_rounding_forgets_rounding_errors_and_nothing_more():
    assert rounded(1 / 3) == rounded(1 / 3 + 1e-13) == 0.333333
    assert rounded(0.33334) != rounded(1 / 3)
    assert rounded(-1e-9) == rounded(1e-300) == 0.0
    assert rounded(float("nan")) == "nan"


def test_measured_numbers_are_the_same_where_another_computer_would_make_them():
    def differ(kept, asked, name="probe"):
        return differences({"tasks": {name: kept}}, {"tasks": {name: asked}}) != []

    assert not differ(0.647278, 0.647309)
    assert not differ([1.0, 2.0], [1.0005, 2.0])
    assert not differ("nan", "nan")
    assert differ(0.647278, 0.649)
    assert differ([1.0, 2.0], [1.0, 2.01])
    assert differ([1.0], [1.0, 1.0])
    assert differ("nan", 1.0)
    assert differ(0.5, 0.50001, name="hold"), "a setting is no measurement"
