"""What tasks and studies give cannot be written over by who reads it."""

from dataclasses import FrozenInstanceError, is_dataclass
from importlib import import_module
from pkgutil import walk_packages

import pytest

import stickslip.studies
import stickslip.tasks
from stickslip.tasks import TASKS


def classes():
    for package in (stickslip.tasks, stickslip.studies):
        for module in walk_packages(package.__path__, f"{package.__name__}."):
            for name, each in vars(import_module(module.name)).items():
                if isinstance(each, type) and is_dataclass(each) and each.__module__ == module.name:
                    yield pytest.param(each, id=f"{module.name}.{name}")


@pytest.mark.parametrize("each", list(classes()))
def test_dataclasses_are_frozen(each):
    assert each.__dataclass_params__.frozen


def test_a_task_is_as_it_was_registered():
    with pytest.raises(FrozenInstanceError):
        TASKS["memory capacity"].metric = None
