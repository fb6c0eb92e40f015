"""Batches that one crawler of theirs can spoil."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from ..crawler import SolverError

__all__ = ["by_halves"]

Item = TypeVar("Item")
Result = TypeVar("Result")


def by_halves(
    work: Callable[[Sequence[Item]], Result], items: Sequence[Item], first: int = 0
) -> Iterator[tuple[slice, Result]]:
    """Do work on all items at once, and by halves where the solver gives one of them up, which is left out.

    Parameters
    ----------
    work : callable
        Raises `SolverError` if one of the items cannot be done.
    items : sequence
    first : int
        Place of the first of them.

    Yields
    ------
    places : slice
        Of some of the items.
    result : object
        Of the work on these.
    """
    if not items:
        return
    try:
        result = work(items)
    except SolverError:
        half = len(items) // 2
        if half:
            yield from by_halves(work, items[:half], first)
            yield from by_halves(work, items[half:], first + half)
        return
    yield slice(first, first + len(items)), result
