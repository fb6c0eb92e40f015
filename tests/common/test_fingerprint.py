"""What a file was made for, and how what it was not made for is refused."""

import json
from dataclasses import dataclass, field
from functools import partial
from hashlib import sha256
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


def test_a_refusal_can_be_read_however_much_differs():
    numbers = list(range(100_000))
    with pytest.raises(ValueError, match=r"^a must be 1 again, got \[0, 1, 2, .* \.\.\. .*, 99999\]$") as refused:
        refuse_other("again", {"a": 1}, {"a": numbers})
    assert len(str(refused.value)) < 300


def test_a_refusal_names_every_difference():
    with pytest.raises(
        ValueError, match=r"^a must be 1 to go on with it, got 2; b must be absent to go on with it, got 'x'$"
    ):
        refuse_other("to go on with it", {"a": 1}, {"a": 2, "b": "x"})
    refuse_other("to go on with it", {"a": 1}, {"a": 1})


@pytest.mark.parametrize(
    ("was", "now"), [(1.0, 2.0), ({"speed": 1.0}, {"speed": 2.0}), ({"speed": 1.0}, {"work": 1.0})]
)
def test_what_was_measured_is_named_where_nothing_else_differs(was, now):
    with pytest.raises(ValueError, match=r"^hold must be 1 again, got 2$"):
        refuse_other("again", {"hold": 1, "probe": was}, {"hold": 2, "probe": now})
    with pytest.raises(ValueError, match=r"^probe.* must be .* again, got "):
        refuse_other("again", {"hold": 1, "probe": was}, {"hold": 1, "probe": now})


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
    assert not differ({"speed": 0.647278}, {"speed": 0.647309})
    assert differ(0.647278, 0.649)
    assert differ([1.0, 2.0], [1.0, 2.01])
    assert differ([1.0], [1.0, 1.0])
    assert differ("nan", 1.0)
    assert differ(0.5, 0.50001, name="hold"), "a setting is no measurement"


class Spoken:
    def __repr__(self):
        return "spoken"


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (None, None),
        (False, False),
        (np.True_, True),
        ("text", "text"),
        (-float("inf"), "-inf"),
        (float("nan"), "nan"),
        ([(1,), {2}], [[1], [2]]),
        (frozenset({3, 1, 2}), [1, 2, 3]),
        (partial(scale, number=Plain()), {"function": "scale", "number": "Plain"}),
        (Pair(1, partial(scale, 2, number=3.0)), "Pair(left=1, right=scale(2, number=3.0))"),
        (Pair((1, Path("a")), {"b": {1}}), "Pair(left=[1, 'a'], right={'b': [1]})"),
        (Pair(np.float64(0.5), range(2)), "Pair(left=0.5, right=[0, 1])"),
        (Pair(np.float64, frozenset({2, 1})), "Pair(left=float64, right=[1, 2])"),
        (Spoken(), "spoken"),
        (scale, "scale"),
        (Plain(), "Plain"),
    ],
)
def test_further_descriptions_by_hand(value, expected):
    found = described(value)
    assert found == expected
    assert type(found) is type(expected)


def test_an_array_is_told_by_shape_kind_and_content():
    line = np.arange(6.0)
    assert described(line) == "array(shape=(6,), dtype=float64, sha256=" + sha256(line.tobytes()).hexdigest()[:12] + ")"
    others = [line.reshape(2, 3), line.astype(np.float32), line[::-1], np.arange(6)]
    assert len({described(each) for each in [line, *others]}) == 5
    assert described(np.arange(12.0).reshape(3, 4).T) == described(np.arange(12.0).reshape(3, 4).T.copy())


@pytest.mark.parametrize(
    ("measured", "expected"),
    [
        (123456.4, 123456.0),
        (1234567.0, 1234570.0),
        (-2 / 3, -0.666667),
        (2e-6, 2e-6),
        (-2e-6, -2e-6),
        (0.9e-6, 0.0),
        (-0.9e-6, 0.0),
        (float("inf"), "inf"),
        (-float("inf"), "-inf"),
    ],
)
def test_rounding_by_hand(measured, expected):
    assert rounded(measured) == expected
    assert str(rounded(measured)) == str(expected), "0, not -0"


def test_the_same_is_told_from_nearly_the_same():
    def differ(kept, asked, name="a.probe"):
        one, other = kept, asked
        for key in reversed(name.split(".")):
            one, other = {key: one}, {key: other}
        return [(each.name, each.kept, each.asked) for each in differences(one, other)]

    # A thousandth of the larger, or a thousandth where both are small.
    assert differ(1000.0, 1000.9) == []
    assert differ(1000.0, 1001.1) == [("a.probe", 1000.0, 1001.1)]
    assert differ(1e-4, 9e-4) == []
    assert differ(1e-4, 1.2e-3) != []
    # Whole numbers and text are not measured, and names that merely end alike are no probes.
    assert differ(1000, 1001) != []
    assert differ(1000, 1000.5) != []
    assert differ(1.0, 1.0001, name="a.other_probe") != []
    assert differ(1.0, 1.0001, name="probe.a") == []
    assert differ([[1.0, "x"]], [[1.0005, "x"]]) == []
    assert differ([[1.0, "x"]], [[1.0005, "y"]]) != []
    assert differ([1.0], 1.0) != []
    assert differ({}, 1.0) == [("a.probe", {}, 1.0)]
    assert differ([True], [1]) != []


def test_what_is_absent_is_said_and_comes_after_what_is_asked_for():
    found = differences({"old": 1, "both": 1}, {"new": None, "both": 2})
    assert [name for name, _, _ in found] == ["new", "both", "old"]
    assert [repr(each) for each in found[0]] == ["'new'", "absent", "None"]
    with pytest.raises(ValueError, match=r"^old must be 1 again, got absent$"):
        refuse_other("again", {"old": 1}, {})
    # What grows at one level does not at another.
    assert differences({"a": {"tasks": {"b": 1}}}, {"a": {"tasks": {"c": 1}}}, growing=["tasks"]) != []
    assert differences({"a": {"tasks": {"b": 1}}}, {"a": {"tasks": {"c": 1}}}, growing=["a.tasks"]) == []
    refuse_other("again", {"tasks": {"b": 1}}, {"tasks": {"c": 1}}, growing=["tasks"])
