from dataclasses import FrozenInstanceError

import pytest
from frozen import dataclasses_of, thawed

import stickslip.tasks
from stickslip.tasks import TASKS


def test_dataclasses_are_frozen():
    assert dataclasses_of(stickslip.tasks)
    assert thawed(stickslip.tasks) == []


def test_a_task_is_as_it_was_registered():
    with pytest.raises(FrozenInstanceError):
        TASKS["memory capacity"].metric = None
