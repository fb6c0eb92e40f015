"""Straight-line machine code from a recurrence written in Python.

A recurrence of fixed order is a few hundred dependent multiplications and additions. As loops over an array they wait
for memory and for each other; written out, with every number in a register, they take less than half the time. The
recurrence is an ordinary function over anything that adds and multiplies: floats, mpmath's numbers, or the `Traced`
values of `stickslip.compiling.traced`, whose arithmetic writes the instructions.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .traced import DOUBLE, INTEGER, Traced

__all__ = ["unrolled", "unrolled_in_lanes"]

# Arrays of numbers begin at multiples of a number's size, vectors among them too.
_ALIGNMENT = 8


class Row:
    """A row of the array that the code works on; its elements are loaded where they are used."""

    def __init__(self, builder: ir.IRBuilder, start: ir.Value, lanes: int) -> None:
        self.builder = builder
        self.start = start
        self.lanes = lanes

    def _place(self, n: int) -> ir.Value:
        return self.builder.gep(self.start, [ir.Constant(INTEGER, n * self.lanes)])

    def __getitem__(self, n: int) -> Traced:
        place = self._place(n)
        if self.lanes > 1:
            place = self.builder.bitcast(place, ir.VectorType(DOUBLE, self.lanes).as_pointer())
        return Traced(self.builder, self.builder.load(place, align=_ALIGNMENT))

    def __setitem__(self, n: int, number: Traced) -> None:
        place = self._place(n)
        if self.lanes > 1:
            place = self.builder.bitcast(place, number.value.type.as_pointer())
        self.builder.store(number.value, place, align=_ALIGNMENT)


class Rows:
    """The array that the code works on, row by row."""

    def __init__(self, builder: ir.IRBuilder, data: ir.Value, width: ir.Value, lanes: int) -> None:
        self.builder = builder
        self.data = data
        self.width = width
        self.lanes = lanes

    def __getitem__(self, i: int) -> Row:
        start = self.builder.mul(self.width, ir.Constant(INTEGER, i * self.lanes))
        return Row(self.builder, self.builder.gep(self.data, [start]), self.lanes)


def unrolled(recurrence: Callable[..., Mapping[int, Sequence[Any]]]) -> Any:
    """Make `kernel(order, inputs, rows)` out of `recurrence(order, rows, *inputs)`, for use in compiled code.

    Parameters
    ----------
    recurrence : callable
        Takes an int, rows of numbers to read, and numbers; gives lists of numbers by the row that they are to fill.

    Returns
    -------
    numba intrinsic
        `order` must be a literal or a named tuple of a class that has a static `order()`, `inputs` a tuple of floats,
        `rows` a C-contiguous array of float64.
    """

    @intrinsic
    def kernel(_typing: Any, order: Any, inputs: Any, rows: Any) -> Any:
        if not _can_trace(order, rows, 2):
            return None

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            _write(*_traced(recurrence, 1, context, builder, signature, arguments))
            return context.get_dummy_value()

        return types.void(order, inputs, rows), codegen

    return kernel


def unrolled_in_lanes(
    recurrence: Callable[..., tuple[Mapping[int, Sequence[Any]], Sequence[Any]]], lanes: int, masks: int
) -> Any:
    """Make `kernel(order, inputs, rows)` that does the work of `recurrence` for several sets of numbers at once.

    Each set gets, to the last bit, what a recurrence of the same arithmetic gives it alone by `unrolled`.

    Parameters
    ----------
    recurrence : callable
        As for `unrolled`; besides the rows to fill it gives truths.
    lanes : int
        Sets of numbers.
    masks : int
        Truths that `recurrence` gives.

    Returns
    -------
    numba intrinsic
        `order` must be a literal or a named tuple of a class that has a static `order()`, `inputs` a tuple of floats
        that all sets share, `rows` a C-contiguous array of float64 whose third and last axis runs over the sets. It
        returns a tuple of ints, a bit a lane, by truth.
    """

    @intrinsic
    def kernel(_typing: Any, order: Any, inputs: Any, rows: Any) -> Any:
        if not _can_trace(order, rows, 3):
            return None
        answer = types.UniTuple(types.int64, masks)

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            workspace, (results, truths) = _traced(recurrence, lanes, context, builder, signature, arguments)
            _write(workspace, results)
            return context.make_tuple(builder, answer, [truth.mask() for truth in truths])

        return answer(order, inputs, rows), codegen

    return kernel


def _order_of(order: Any) -> int | None:
    """The order that a type tells: a literal's, or what a named tuple's class says its `order()` is."""
    if isinstance(order, types.IntegerLiteral):
        return int(order.literal_value)
    told = getattr(getattr(order, "instance_class", None), "order", None)
    return None if told is None else int(told())


def _can_trace(order: Any, rows: Any, dimensions: int) -> bool:
    if _order_of(order) is None or not isinstance(rows, types.Array):
        return False
    return rows.layout == "C" and rows.ndim == dimensions


def _traced(
    recurrence: Callable[..., Any], lanes: int, context: Any, builder: Any, signature: Any, arguments: Any
) -> tuple[Rows, Any]:
    """The array to work on, and what the recurrence gives."""
    order, _, rows = signature.args
    numbers = [Traced(builder, value) for value in cgutils.unpack_tuple(builder, arguments[1])]
    array = context.make_array(rows)(context, builder, arguments[2])
    workspace = Rows(builder, array.data, builder.extract_value(array.shape, 1), lanes)
    return workspace, recurrence(_order_of(order), workspace, *numbers)


def _write(workspace: Rows, results: Mapping[int, Sequence[Any]]) -> None:
    for i, numbers in results.items():
        row = workspace[i]
        for n, number in enumerate(numbers):
            row[n] = number
