"""Random numbers of NumPy's own generators in compiled code, drawn as Python draws them.

Every generator tells where its state lies and which C function takes the next number from it
(https://numpy.org/doc/stable/reference/random/extending.html). Drawn so, the numbers of thousands of generators cost
as much as the function alone, and each generator is always where its owner finds it.
"""

import ctypes
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["next_uniform", "whereabouts"]

_instruction: Any = intrinsic  # compiled code calls what it makes with one argument less
_POINTER = ir.IntType(8).as_pointer()


def whereabouts(generator: np.random.Generator) -> tuple[int, int]:
    """Addresses of a generator's function for uniform numbers and of its state, for as long as it lives."""
    interface = generator.bit_generator.ctypes
    return ctypes.cast(interface.next_double, ctypes.c_void_p).value or 0, interface.state_address


@_instruction
def next_uniform(_typing: Any, function: Any, state: Any) -> Any:
    """``generator.random()`` of the generator at these addresses, each a uint64."""

    def codegen(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.DoubleType(), [_POINTER])
        called = builder.inttoptr(arguments[0], kind.as_pointer())
        return builder.call(called, [builder.inttoptr(arguments[1], _POINTER)])

    return types.float64(types.uint64, types.uint64), codegen
