"""What a map varies: one number an axis, in the words of sweeps, searches and randomized episodes."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...common.validation import finite_array, known_names, number_within
from ...crawler.model.variations import VARIED
from ..benchmark.sweep import parse_sweep

__all__ = ["NUMBERS", "Axis", "AxisLike", "axis_of"]

NUMBERS = {**VARIED, "dither": "[0, 0.5]"}
"""What an axis may vary, and the values that it may take: what a sweep may, and the dither of the input."""

AxisLike = str | tuple[str, ArrayLike]
"""What a function takes for an axis: see :func:`axis_of`."""


class Axis(NamedTuple):
    """A number and its values, ascending."""

    name: str
    values: tuple[float, ...]


def axis_of(argument: str, given: Any) -> Axis:
    """An axis, from text such as ``deborah=0.05:8:64:log`` or ``hold=0.25,0.5,1``, or from a name and its values.

    Parameters
    ----------
    argument : str
        What the caller calls it.
    given : str or (str, array_like of shape (values,))
        The text is that of :func:`stickslip.studies.benchmark.sweep.parse_sweep`; of values given otherwise one is
        enough.

    Returns
    -------
    Axis

    Raises
    ------
    ValueError
        If there is no number of that name, a range is upside down, or a value is out of range or does not ascend.
    TypeError
        If `given` is of another type.
    """
    if isinstance(given, str):
        name, values = parse_sweep(given, argument, NUMBERS)
    elif isinstance(given, Sequence) and len(given) == 2 and isinstance(given[0], str):
        name = given[0]
        known_names(argument, [name], NUMBERS)
        values = finite_array(f"{argument} {name}", given[1], 1).tolist()
    else:
        raise TypeError(f"{argument} must be text such as 'duffing=0:200:64' or a name and values, got {given!r}")
    numbers = tuple(number_within(f"{argument} {name}", value, NUMBERS[name]) for value in values)
    if (np.diff(numbers) <= 0.0).any():
        raise ValueError(f"{argument} {name} must ascend, got {list(values)}")
    return Axis(name, numbers)
