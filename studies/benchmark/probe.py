"""Small measurements by which a changed task, measure or reservoir is told from the one that a file was made with."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...common.fingerprint import described, rounded
from ...tasks.reservoirs import BodyReservoir, Reservoir
from ...tasks.streams import random_uniform
from ...tasks.task import Task

__all__ = ["probes", "reservoir_probe", "task_probe"]

_BODY = BodyReservoir(hold=1.0, virtual_nodes=2)
_LENGTH, _WASHOUT, _SAMPLES = 700, 60, 40


def task_probe(task: Task) -> float | str:
    """What a small crawler scores on a short draw of a task, rounded.

    It changes with the task's series and target, with the measure that scores it, and with the body's motion.
    """
    return rounded(task.attempt(_BODY, length=_LENGTH, seed=0, washout=_WASHOUT).score)


def reservoir_probe(reservoir: Reservoir) -> list[float | str]:
    """The mean size of a reservoir's states on a short series, rounded, and likewise of its candidates."""
    series = random_uniform(_SAMPLES, 0)
    each = [reservoir, *getattr(reservoir, "candidates", ())]
    return [rounded(float(np.abs(one(series, 0)).mean())) for one in each]


def probes(tasks: Mapping[str, Task], reservoirs: Mapping[str, Reservoir]) -> dict[str, Any]:
    """What tasks and reservoirs are, by name: a description of each, and what it measures by.

    Parameters
    ----------
    tasks : mapping of str to Task
    reservoirs : mapping of str to Reservoir

    Returns
    -------
    dict
        Ready for JSON, as in `stickslip.common.fingerprint`.
    """
    return {
        "tasks": {name: {"made of": described(task), "probe": task_probe(task)} for name, task in tasks.items()},
        "reservoirs": {
            name: {"made of": described(each), "probe": reservoir_probe(each)} for name, each in reservoirs.items()
        },
    }
