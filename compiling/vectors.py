"""Vectors of numbers side by side in compiled code, one lane a body.

What is done to many bodies alike is done to eight at once. Each lane's arithmetic is that of numbers, rounded as they
are, so that a lane and a loop over numbers agree to the last bit.
"""

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable
from numpy.typing import NDArray

from .traced import repeated

__all__ = ["LANES", "aligned_zeros", "broadcast", "clipped", "flush_to_zero", "load", "store"]

LANES = 8
_instruction: Any = intrinsic  # compiled code calls what it makes with one argument less
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_BYTES = 8 * LANES


def aligned_zeros(*shape: int) -> NDArray[np.float64]:
    """Zeros whose first element begins a line of the processor's cache, so that no vector straddles two."""
    count = int(np.prod(shape))
    room = np.zeros(count + LANES)
    offset = (-room.ctypes.data % _BYTES) // 8
    return room[offset : offset + count].reshape(shape)


class LanesType(types.Type):
    """Eight numbers side by side."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


lanes = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _arithmetic(function: Any, instruction: str) -> None:
    @type_callable(function)
    def _typer(_context: Any) -> Any:
        return lambda left, right: lanes if left == lanes and right == lanes else None

    @lower_builtin(function, lanes, lanes)
    def _lower(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return getattr(builder, instruction)(*arguments)


for _function, _operation in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _arithmetic(_function, _operation)


def _place(context: Any, builder: Any, kind: Any, array: Any, offset: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [offset]), _VECTOR.as_pointer())


@_instruction
def load(_typing: Any, array: Any, offset: Any) -> Any:
    """Eight neighbours of a C-contiguous array of float64, from an offset counted in elements over all axes."""
    if not isinstance(array, types.Array) or array.layout != "C" or array.dtype != types.float64:
        return None

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = builder.load(_place(context, builder, signature.args[0], *arguments))
        vector.align = 8  # a single crawler's arrays begin anywhere
        return vector

    return lanes(array, types.intp), codegen


@_instruction
def store(_typing: Any, array: Any, offset: Any, vector: Any) -> Any:
    """Write eight neighbours of a C-contiguous array of float64: see `load`."""
    if not isinstance(array, types.Array) or array.layout != "C" or array.dtype != types.float64:
        return None

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        written = builder.store(arguments[2], _place(context, builder, signature.args[0], *arguments[:2]))
        written.align = 8
        return context.get_dummy_value()

    return types.void(array, types.intp, lanes), codegen


@_instruction
def broadcast(_typing: Any, number: Any) -> Any:
    """One number in every lane."""

    def codegen(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return repeated(builder, arguments[0], LANES)

    return lanes(types.float64), codegen


@_instruction
def clipped(_typing: Any, vector: Any) -> Any:
    """Each number brought into [0, 1]."""

    def codegen(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        vector = arguments[0]
        for end, relation in ((0.0, ">"), (1.0, "<")):
            bound = ir.Constant(_VECTOR, [end] * LANES)
            vector = builder.select(builder.fcmp_ordered(relation, vector, bound), vector, bound)
        return vector

    return lanes(lanes), codegen


@_instruction
def flush_to_zero(_typing: Any, vector: Any, faintest: Any) -> Any:
    """Each number, or zero where its size does not exceed `faintest`."""

    def codegen(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        vector, faintest = arguments
        kept = builder.or_(
            builder.fcmp_ordered(">", vector, repeated(builder, faintest, LANES)),
            builder.fcmp_ordered("<", vector, repeated(builder, builder.fneg(faintest), LANES)),
        )
        return builder.select(kept, vector, ir.Constant(_VECTOR, [0.0] * LANES))

    return lanes(lanes, types.float64), codegen
