"""Straight-line machine code from a recurrence written in Python.

A recurrence of fixed order is a few hundred dependent multiplications and additions. As loops over an array they wait
for memory and for each other; written out, with every number in a register, they take less than half the time. The
recurrence is an ordinary function over anything that adds and multiplies: floats, mpmath's numbers, or the `Traced`
values below, whose arithmetic writes the instructions.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload

__all__ = ["fma", "sum_of_products", "unrolled"]

_DOUBLE = ir.DoubleType()
_INTEGER = ir.IntType(64)
_LANE = ir.IntType(32)
# Additions wait four cycles for each other and two can begin in each; more chains than this gain nothing.
_CHAINS = 4


class Traced:
    """A number, or a vector of them, that will be known when the code runs; its arithmetic appends instructions.

    Numbers join a vector's arithmetic as if repeated, but only on its right.
    """

    def __init__(self, builder: ir.IRBuilder, value: ir.Value) -> None:
        self.builder = builder
        self.value = value

    def _with(self, instruction: str, *others: Any) -> "Traced":
        return Traced(self.builder, getattr(self.builder, instruction)(self.value, *map(self._like, others)))

    def _like(self, other: Any) -> ir.Value:
        """The value of another number, repeated where this is a vector."""
        scalar = other.value if isinstance(other, Traced) else ir.Constant(_DOUBLE, float(other))
        if scalar.type == self.value.type:
            return scalar
        return self._repeated(scalar, self.value.type.count)

    def _repeated(self, scalar: ir.Value, count: int) -> ir.Value:
        kind = ir.VectorType(_DOUBLE, count)
        first = self.builder.insert_element(ir.Constant(kind, ir.Undefined), scalar, ir.Constant(_LANE, 0))
        lanes = ir.Constant(ir.VectorType(_LANE, count), [0] * count)
        return self.builder.shuffle_vector(first, ir.Constant(kind, ir.Undefined), lanes)

    def times_each(self, factors: Sequence[float]) -> "Traced":
        """The vector of the number's products with constants."""
        vector = Traced(self.builder, self._repeated(self.value, len(factors)))
        return Traced(self.builder, self.builder.fmul(vector.value, _constants(factors)))

    def weighted_sum(self, weights: Sequence[float]) -> "Traced":
        """The sum of the vector's elements times constants."""
        products = self.builder.fmul(self.value, _constants(weights))
        elements = [
            Traced(self.builder, self.builder.extract_element(products, ir.Constant(_LANE, i)))
            for i in range(len(weights))
        ]
        return sum(elements[1:], elements[0])

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
        if isinstance(self.value.type, ir.DoubleType):
            return self._with("fma", factor, addend)
        # The builder's own is for numbers only.
        kind = self.value.type
        name = f"llvm.fma.v{kind.count}f64"
        function = cgutils.get_or_insert_function(self.builder.module, ir.FunctionType(kind, [kind] * 3), name)
        arguments = [self.value, self._like(factor), self._like(addend)]
        return Traced(self.builder, self.builder.call(function, arguments))

    def smaller(self, other: Any) -> "Traced":
        """The lesser of two numbers; `other` where this is NaN."""
        return self._chosen("<", other)

    def larger(self, other: Any) -> "Traced":
        """The greater of two numbers; `other` where this is NaN."""
        return self._chosen(">", other)

    def _chosen(self, relation: str, other: Any) -> "Traced":
        right = self._like(other)
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


@intrinsic
def _fused(_typing: Any, x: Any, y: Any, z: Any) -> Any:
    def codegen(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), codegen


@overload(fma)
def _compiled_fma(x: Any, y: Any, z: Any) -> Any:
    def implementation(x: Any, y: Any, z: Any) -> Any:
        fused: Any = _fused
        return fused(x, y, z)

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


def _constants(numbers: Sequence[float]) -> ir.Constant:
    return ir.Constant(ir.VectorType(_DOUBLE, len(numbers)), [ir.Constant(_DOUBLE, float(each)) for each in numbers])


class Row:
    """A row of the array that the code works on; its elements are loaded where they are used."""

    def __init__(self, builder: ir.IRBuilder, start: ir.Value) -> None:
        self.builder = builder
        self.start = start

    def _place(self, n: int) -> ir.Value:
        return self.builder.gep(self.start, [ir.Constant(_INTEGER, n)])

    def __getitem__(self, n: int) -> Traced:
        return Traced(self.builder, self.builder.load(self._place(n)))

    def __setitem__(self, n: int, number: Traced) -> None:
        self.builder.store(number.value, self._place(n))


class Rows:
    """The array that the code works on, row by row."""

    def __init__(self, builder: ir.IRBuilder, data: ir.Value, width: ir.Value) -> None:
        self.builder = builder
        self.data = data
        self.width = width

    def __getitem__(self, i: int) -> Row:
        start = self.builder.mul(self.width, ir.Constant(_INTEGER, i))
        return Row(self.builder, self.builder.gep(self.data, [start]))


def unrolled(recurrence: Callable[..., Mapping[int, Sequence[Any]]]) -> Any:
    """Make `kernel(order, inputs, rows)` out of `recurrence(order, rows, *inputs)`, for use in compiled code.

    Parameters
    ----------
    recurrence : callable
        Takes an int, rows of numbers to read, and numbers; gives lists of numbers by the row that they are to fill.

    Returns
    -------
    numba intrinsic
        `order` must be a literal, `inputs` a tuple of floats, `rows` a C-contiguous array of float64.
    """

    @intrinsic
    def kernel(_typing: Any, order: Any, inputs: Any, rows: Any) -> Any:
        if not isinstance(order, types.IntegerLiteral) or not isinstance(rows, types.Array) or rows.layout != "C":
            return None

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            numbers = [Traced(builder, value) for value in cgutils.unpack_tuple(builder, arguments[1])]
            array = context.make_array(signature.args[2])(context, builder, arguments[2])
            workspace = Rows(builder, array.data, builder.extract_value(array.shape, 1))
            for i, results in recurrence(order.literal_value, workspace, *numbers).items():
                row = workspace[i]
                for n, number in enumerate(results):
                    row[n] = number
            return context.get_dummy_value()

        return types.void(order, inputs, rows), codegen

    return kernel
