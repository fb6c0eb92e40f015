"""Crawlers as columns of arrays: what a batch is made of, in structures of arrays."""

from collections.abc import Sequence
from itertools import chain, repeat
from operator import attrgetter, is_
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import NDArray

from ...compiling.compilation import compiled
from .groups import Groups, NONLINEAR
from .scene import Scene
from .state import Body, Coefficients, coefficients_of
from .tube import as_crawler, is_chain

__all__ = [
    "Crawlers",
    "Share",
    "body_of",
    "chains_of_each",
    "coefficients_at",
    "coefficients_in",
    "coefficients_of_each",
    "coefficients_of_one",
    "columns_of",
    "different",
    "is_linear_at",
    "linear_of_each",
    "units_of",
    "write_body",
]


class Crawlers(NamedTuple):
    """n crawlers on their way through a hold, and what is written down of it."""

    bodies: NDArray[np.float64]  # (7, n): the fields of `Body`, updated
    coefficients: NDArray[np.float64]  # (11, n): the fields of `Coefficients`
    valves: NDArray[np.int64]  # (n,): 0 or 1
    samples: NDArray[np.float64]  # (3, V, n): z, v, p at the times hold (j + 1) / V
    statuses: NDArray[np.int8]  # (n,): FINISHED, DIVERGED or OUT_OF_STEPS
    elapsed: NDArray[np.float64]  # (n,): time into the hold that was reached


class Share(NamedTuple):
    """Some of n crawlers: those of a slice that are not skipped."""

    begin: int
    end: int
    skip: NDArray[np.bool_]  # (n,)


_as_tuple: Any = to_fixed_tuple  # whose types numba does not tell
_FIELDS = len(Coefficients._fields)
_NONLINEAR = tuple(Coefficients._fields.index(name) for name in NONLINEAR)


def coefficients_of_each(groups: Sequence[Groups], scenes: Sequence[Scene]) -> NDArray[np.float64]:
    """Coefficients of many crawlers' equations: those that `coefficients_of` gives each.

    Parameters
    ----------
    groups, scenes : sequences of length n
        Of crawlers of one body, see `units_of`.

    Returns
    -------
    (11, n) array
        Fields of `Coefficients` in order, a crawler a column.
    """
    return columns_of(_together(groups, Groups.__slots__), _together(scenes, Scene.__slots__), len(groups))


def coefficients_of_one(columns: NDArray[np.float64], i: int) -> Coefficients:
    """Those of a column, for Python to pass to compiled code."""
    numbers = columns[:, i].tolist()
    return Coefficients(*numbers[:-2], *map(bool, numbers[-2:]))


def columns_of(groups: Any, scene: Any, count: int) -> NDArray[np.float64]:
    """Coefficients of many crawlers' equations, from all their groups and scenes at once.

    Parameters
    ----------
    groups, scene : object
        With the attributes of `Groups` and `Scene`: each an array (count,), or a number that holds for all.
    count : int

    Returns
    -------
    (11, count) array
    """
    columns = np.empty((_FIELDS, count))
    with np.errstate(all="ignore"):
        for row, values in enumerate(coefficients_of(groups, scene)):
            columns[row] = values
    return columns


def units_of(
    groups: Sequence[Groups], scenes: Sequence[Scene]
) -> tuple[Sequence[Groups], Sequence[Scene], NDArray[np.float64]]:
    """Each crawler as `as_crawler` has it, and its unit of time; a chain is left as it is."""
    units = np.ones(len(groups))
    if not any(scene.tube_mass > 0.0 for scene in different(scenes)):
        return groups, scenes, units
    bodies = [
        (own, scene, 1.0) if is_chain(scene) else as_crawler(own, scene)
        for own, scene in zip(groups, scenes, strict=True)
    ]
    units[:] = [unit for _, _, unit in bodies]
    return [own for own, _, _ in bodies], [scene for _, scene, _ in bodies], units


def _together(each: Sequence[Any], names: tuple[str, ...]) -> Any:
    """One object whose attributes are those of each, as arrays; the first itself where all are one."""
    first = each[0]
    if all(map(is_, each, repeat(first))):
        return first
    numbers = chain.from_iterable(map(attrgetter(*names), each))
    table = np.fromiter(numbers, np.float64, len(each) * len(names)).reshape(len(each), len(names))
    return SimpleNamespace(**dict(zip(names, table.T, strict=True)))


def different(each: Sequence[Any]) -> list[Any]:
    """The objects in a sequence, each once."""
    return list({id(one): one for one in each}.values())


def chains_of_each(scenes: Sequence[Scene]) -> NDArray[np.bool_]:
    """Which of the scenes make a chain of the body, shape (n,)."""
    chains = np.zeros(len(scenes), np.bool_)
    if any(map(is_chain, different(scenes))):
        chains[:] = list(map(is_chain, scenes))
    return chains


def linear_of_each(columns: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of the crawlers in the columns of `coefficients_of_each` are linear, shape (n,)."""
    return (columns[list(_NONLINEAR)] == 0.0).all(axis=0)


@compiled
def is_linear_at(columns: NDArray[np.float64], i: int) -> bool:
    """Whether the crawler in a column is linear."""
    linear = True
    for k in range(len(_NONLINEAR)):
        linear = linear and columns[_NONLINEAR[k], i] == 0.0
    return linear


@compiled
def body_of(bodies: NDArray[np.float64], i: int) -> Body:
    """The body in a column."""
    return Body(
        bodies[0, i], bodies[1, i], bodies[2, i], bodies[3, i], bodies[4, i], int(bodies[5, i]), int(bodies[6, i])
    )


@compiled
def write_body(body: Body, bodies: NDArray[np.float64], i: int) -> None:
    """Put the body into a column."""
    bodies[0, i] = body.deformation
    bodies[1, i] = body.velocity
    bodies[2, i] = body.pressure
    bodies[3, i] = body.foot
    bodies[4, i] = body.foot_velocity
    bodies[5, i] = body.mode
    bodies[6, i] = body.slips


@compiled
def coefficients_at(columns: NDArray[np.float64], i: int) -> Coefficients:
    """The coefficients in a column."""
    return coefficients_in(columns[:, i])


@compiled
def coefficients_in(numbers: NDArray[np.float64]) -> Coefficients:
    """The coefficients whose fields are these numbers, in order."""
    fields = _as_tuple(numbers, _FIELDS)
    return Coefficients(*(*fields[:-2], fields[-2] != 0.0, fields[-1] != 0.0))
