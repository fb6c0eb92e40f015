"""Straight-line machine code from a recurrence written in Python.

A recurrence of fixed order is a few hundred dependent multiplications and additions. As loops over an array they wait
for memory and for each other; written out, with every number in a register, they take less than half the time. The
recurrence is an ordinary function over anything that adds and multiplies: floats, mpmath's numbers, or the `Traced`
values below, whose arithmetic writes the instructions.
"""

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload

__all__ = ["fma", "sum_of_products", "unrolled"]

_DOUBLE = ir.DoubleType()
_INTEGER = ir.IntType(64)
# Additions wait four cycles for each other and two can begin in each; more chains than this gain nothing.
_CHAINS = 4


class Traced:
    """A number that will be known when the code runs; its arithmetic appends instructions."""

    def __init__(self, builder: ir.IRBuilder, value: ir.Value) -> None:
        self.builder = builder
        self.value = value

    def _with(self, instruction: str, *others: Any) -> "Traced":
        values = [other.value if isinstance(other, Traced) else ir.Constant(_DOUBLE, float(other)) for other in others]
        return Traced(self.builder, getattr(self.builder, instruction)(self.value, *values))

    def __add__(self, other: Any) -> "Traced":
        return self._with("fadd", other)

    def __sub__(self, other: Any) -> "Traced":
        return self._with("fsub", other)

    def __mul__(self, other: Any) -> "Traced":
        return self._with("fmul", other)

    def __truediv__(self, other: Any) -> "Traced":
        return self._with("fdiv", other)

    def __abs__(self) -> "Traced":
        magnitude = self.builder.and_(self.builder.bitcast(self.value, _INTEGER), ir.Constant(_INTEGER, 2**63 - 1))
        return Traced(self.builder, self.builder.bitcast(magnitude, _DOUBLE))

    def fma(self, factor: Any, addend: Any) -> "Traced":
        """The number times a factor plus an addend, rounded once."""
        return self._with("fma", factor, addend)

    def smaller(self, other: Any) -> "Traced":
        """The lesser of two numbers; `other` where this is NaN."""
        return self._chosen("<", other)

    def larger(self, other: Any) -> "Traced":
        """The greater of two numbers; `other` where this is NaN."""
        return self._chosen(">", other)

    def _chosen(self, relation: str, other: Any) -> "Traced":
        right = other.value if isinstance(other, Traced) else ir.Constant(_DOUBLE, float(other))
        kept = self.builder.fcmp_ordered(relation, self.value, right)
        return Traced(self.builder, self.builder.select(kept, self.value, right))

    def log2(self) -> "Traced":
        """Binary logarithm of a number >= 0, to 0.05: its exponent and, as if logarithms were linear, its mantissa."""
        bits = self.builder.sitofp(self.builder.bitcast(self.value, _INTEGER), _DOUBLE)
        return Traced(self.builder, bits).fma(2.0**-52, -1022.957)

    def exp2(self) -> "Traced":
        """Power of two of a number in (-1023, 1024), to 0.4%: its whole part exactly, its fraction by a parabola."""
        biased = self + 1023.0
        whole = self.builder.fptosi(biased.value, _INTEGER)
        power = self.builder.bitcast(self.builder.shl(whole, ir.Constant(_INTEGER, 52)), _DOUBLE)
        fraction = biased - Traced(self.builder, self.builder.sitofp(whole, _DOUBLE))
        return (fraction * fraction.fma(1.0 / 3.0, 2.0 / 3.0) + 1.0) * Traced(self.builder, power)


def fma(x: Any, y: Any, z: Any) -> Any:
    """Compute x y + z; in compiled code it is rounded once."""
    return x.fma(y, z) if isinstance(x, Traced) else x * y + z


@intrinsic  # type: ignore[misc]
def _fused(_typing: Any, x: Any, y: Any, z: Any) -> Any:
    def codegen(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), codegen


@overload(fma)
def _compiled_fma(x: Any, y: Any, z: Any) -> Any:
    def implementation(x: Any, y: Any, z: Any) -> Any:
        return _fused(x, y, z)

    return implementation


def sum_of_products(left: Sequence[Any], right: Sequence[Any], start: Any = None) -> Any:
    """`start`, if any, plus the sum of left[i] right[i], of which the last pair is the last to be known.

    Parameters
    ----------
    left, right : sequence of numbers, of the same length
        Not empty unless there is a `start`.
    start : number, optional

    Returns
    -------
    number
        Summed in a few chains that do not wait for one another, the last pair after all others.
    """
    pairs = list(zip(left, right, strict=True))
    early, last = pairs[:-1], pairs[-1:]
    count = max(1, min(_CHAINS, len(early) // 2))
    chains = [_plus_products(start if k == 0 else None, early[k::count]) for k in range(count)]
    while len(chains) > 1:
        chains = [sum(chains[i + 1 : i + 2], chains[i]) for i in range(0, len(chains), 2)]
    return _plus_products(chains[0], last)


def _plus_products(total: Any, pairs: Sequence[tuple[Any, Any]]) -> Any:
    for x, y in pairs:
        total = x * y if total is None else fma(x, y, total)
    return total


def unrolled(recurrence: Callable[..., Sequence[Sequence[Any]]]) -> Any:
    """Make `kernel(order, inputs, rows)` out of `recurrence(order, *inputs)`, for use in compiled code.

    Parameters
    ----------
    recurrence : callable
        Takes an int and numbers; gives lists of numbers, in any arithmetic.

    Returns
    -------
    numba intrinsic
        `order` must be a literal, `inputs` a tuple of floats, `rows` a C-contiguous array of float64 whose row i
        receives list i.
    """

    @intrinsic  # type: ignore[misc]
    def kernel(_typing: Any, order: Any, inputs: Any, rows: Any) -> Any:
        if not isinstance(order, types.IntegerLiteral) or not isinstance(rows, types.Array) or rows.layout != "C":
            return None

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            numbers = [Traced(builder, value) for value in cgutils.unpack_tuple(builder, arguments[1])]
            array = context.make_array(signature.args[2])(context, builder, arguments[2])
            width = builder.extract_value(array.shape, 1)
            for i, row in enumerate(recurrence(order.literal_value, *numbers)):
                start = builder.gep(array.data, [builder.mul(width, ir.Constant(_INTEGER, i))])
                for n, number in enumerate(row):
                    builder.store(number.value, builder.gep(start, [ir.Constant(_INTEGER, n)]))
            return context.get_dummy_value()

        return types.void(order, inputs, rows), codegen

    return kernel
