"""Straight-line machine code from a recurrence written in Python.

A recurrence of fixed order is a few hundred dependent multiplications and additions. As loops over an array they wait
for memory and for each other; written out, with every number in a register, they take less than half the time. The
recurrence is an ordinary function over anything that adds and multiplies: floats, mpmath's numbers, or the `Traced`
values below, whose arithmetic writes the instructions.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload

__all__ = ["Series", "exp", "fma", "repeated", "sum_of_products", "unrolled", "unrolled_in_lanes", "where"]

_DOUBLE = ir.DoubleType()
_INTEGER = ir.IntType(64)
_LANE = ir.IntType(32)
# Additions wait four cycles for each other and two can begin in each; more chains than this gain nothing.
_CHAINS = 4
# Arrays of numbers begin at multiples of a number's size, vectors among them too.
_ALIGNMENT = 8
# A number this large has no fraction: adding it rounds, and leaves the whole number in the lowest bits.
_ROUNDER = 1.5 * 2.0**52
# ln(2) in two parts, the first so short that its product with any exponent is exact.
_LN2_HIGH = float.fromhex("0x1.62e42fefap-1")
_LN2_LOW = float.fromhex("0x1.cf79abc9e3b3ap-40")


class Traced:
    """A number, a truth, or a vector of either, known when the code runs; its arithmetic appends instructions.

    Numbers join a vector's arithmetic as if repeated.
    """

    def __init__(self, builder: ir.IRBuilder, value: ir.Value) -> None:
        self.builder = builder
        self.value = value

    def _with(self, instruction: str, other: Any) -> "Traced":
        if isinstance(other, Series):
            return NotImplemented
        return Traced(self.builder, getattr(self.builder, instruction)(*self._alike(self, other)))

    def _alike(self, *numbers: Any) -> list[ir.Value]:
        """Values of numbers, repeated where one of them is a vector."""
        values = [each.value if isinstance(each, Traced) else each for each in numbers]
        kinds = [each.type for each in values if isinstance(each, ir.Value)]
        kind = next((each for each in kinds if isinstance(each, ir.VectorType)), kinds[0])
        return [self._as(kind, each) for each in values]

    def _as(self, kind: ir.Type, value: Any) -> ir.Value:
        if not isinstance(value, ir.Value):
            repeats = getattr(kind, "count", None)
            return ir.Constant(
                kind, float(value) if repeats is None else [ir.Constant(_DOUBLE, float(value))] * repeats
            )
        return value if value.type == kind else repeated(self.builder, value, kind.count)

    def _shaped(self, kind: ir.Type) -> ir.Type:
        """That type, or a vector of it where this is a vector."""
        return ir.VectorType(kind, self.value.type.count) if isinstance(self.value.type, ir.VectorType) else kind

    def _bits(self) -> "Traced":
        return Traced(self.builder, self.builder.bitcast(self.value, self._shaped(_INTEGER)))

    def _number(self) -> "Traced":
        """The number whose bits these are."""
        return Traced(self.builder, self.builder.bitcast(self.value, self._shaped(_DOUBLE)))

    def _integer(self, instruction: str, constant: int) -> "Traced":
        kind = self.value.type
        repeats = getattr(kind, "count", None)
        same = ir.Constant(kind, constant if repeats is None else [ir.Constant(_INTEGER, constant)] * repeats)
        return Traced(self.builder, getattr(self.builder, instruction)(self.value, same))

    def times_each(self, factors: Sequence[float]) -> "Traced":
        """The vector of the number's products with constants."""
        vector = Traced(self.builder, repeated(self.builder, self.value, len(factors)))
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

    def __radd__(self, other: float) -> "Traced":
        return self._constant(other) + self

    def __rsub__(self, other: float) -> "Traced":
        return self._constant(other) - self

    def __rmul__(self, other: float) -> "Traced":
        return self._constant(other) * self

    def __rtruediv__(self, other: float) -> "Traced":
        return self._constant(other) / self

    def _constant(self, number: float) -> "Traced":
        return Traced(self.builder, self._as(self.value.type, number))

    def __neg__(self) -> "Traced":
        return Traced(self.builder, self.builder.fneg(self.value))

    def __abs__(self) -> "Traced":
        return self._bits()._integer("and_", 2**63 - 1)._number()

    def fma(self, factor: Any, addend: Any) -> "Traced":
        """The number times a factor plus an addend, rounded once."""
        return self._intrinsic("fma", factor, addend)

    def _floor(self) -> "Traced":
        return self._intrinsic("floor")

    def _intrinsic(self, name: str, *others: Any) -> "Traced":
        """What LLVM has for numbers and vectors alike."""
        values = self._alike(self, *others)
        kind = values[0].type
        suffix = f"v{kind.count}f64" if isinstance(kind, ir.VectorType) else "f64"
        signature = ir.FunctionType(kind, [kind] * len(values))
        function = cgutils.get_or_insert_function(self.builder.module, signature, f"llvm.{name}.{suffix}")
        return Traced(self.builder, self.builder.call(function, values))

    def _compared(self, relation: str, other: Any) -> "Traced":
        return Traced(self.builder, self.builder.fcmp_ordered(relation, *self._alike(self, other)))

    def __lt__(self, other: Any) -> "Traced":
        return self._compared("<", other)

    def __le__(self, other: Any) -> "Traced":
        return self._compared("<=", other)

    def __gt__(self, other: Any) -> "Traced":
        return self._compared(">", other)

    def __ge__(self, other: Any) -> "Traced":
        return self._compared(">=", other)

    def __eq__(self, other: object) -> "Traced":  # type: ignore[override]
        return self._compared("==", other)

    def __ne__(self, other: object) -> "Traced":  # type: ignore[override]
        return Traced(self.builder, self.builder.fcmp_unordered("!=", *self._alike(self, other)))

    __hash__ = None  # type: ignore[assignment]

    def __and__(self, other: "Traced") -> "Traced":
        return Traced(self.builder, self.builder.and_(self.value, other.value))

    def __or__(self, other: "Traced") -> "Traced":
        return Traced(self.builder, self.builder.or_(self.value, other.value))

    def chosen(self, yes: Any, no: Any) -> "Traced":
        """One number where this truth holds, the other where it does not."""
        kind = self._shaped(_DOUBLE)
        values = (self._as(kind, each.value if isinstance(each, Traced) else each) for each in (yes, no))
        return Traced(self.builder, self.builder.select(self.value, *values))

    def mask(self) -> ir.Value:
        """The truths of a vector as the bits of an integer, the first lowest."""
        bits = self.builder.bitcast(self.value, ir.IntType(self.value.type.count))
        return self.builder.zext(bits, _INTEGER)

    def smaller(self, other: Any) -> "Traced":
        """The lesser of two numbers; `other` where this is NaN."""
        return (self < other).chosen(self, other)

    def larger(self, other: Any) -> "Traced":
        """The greater of two numbers; `other` where this is NaN."""
        return (self > other).chosen(self, other)

    def log2(self) -> "Traced":
        """Binary logarithm of a number >= 0, to 0.05: its exponent and, as if logarithms were linear, its mantissa."""
        bits = self._bits()
        # Without a sign: processors convert that in vectors.
        return Traced(self.builder, self.builder.uitofp(bits.value, self._shaped(_DOUBLE))).fma(2.0**-52, -1022.957)

    def exp2(self) -> "Traced":
        """Power of two of a number in (-1023, 1024), to 0.4%: its whole part exactly, its fraction by a parabola."""
        biased = self + 1023.0
        whole = biased._floor()
        fraction = biased - whole
        power = (whole + _ROUNDER)._bits()._integer("shl", 52)._number()
        return (fraction * fraction.fma(1.0 / 3.0, 2.0 / 3.0) + 1.0) * power

    def exp(self) -> "Traced":
        """Exponential within one unit in the last place; that of the nearest of [-708, 709] beyond, of -708 for NaN.

        2^k e^r with |r| <= ln(2) / 2 and Taylor's series of e^r - 1 to order 13, which leaves out less than 2^-57.
        """
        x = self.larger(-708.0).smaller(709.0)
        shifted = x.fma(1.0 / math.log(2.0), _ROUNDER)
        k = shifted - _ROUNDER
        r = k.fma(-_LN2_LOW, k.fma(-_LN2_HIGH, x))
        square = r * r
        # Pairs of terms, then pairs of pairs: none waits long for another.
        terms = [1.0 / math.factorial(n) for n in range(2, 14)]
        pairs = [r.fma(terms[i + 1], terms[i]) for i in range(0, 12, 2)]
        fourth = square * square
        quads = [pairs[i + 1].fma(square, pairs[i]) for i in range(0, 6, 2)]
        tail = quads[2].fma(fourth, quads[1]).fma(fourth, quads[0])
        significand = square.fma(tail, r) + 1.0
        scaled = self.builder.add(significand._bits().value, shifted._bits()._integer("shl", 52).value)
        return Traced(self.builder, scaled)._number()


def where(condition: Any, yes: Any, no: Any) -> Any:
    """`yes` where the condition holds, else `no`; both are computed."""
    if isinstance(condition, Traced):
        return condition.chosen(yes, no)
    return yes if condition else no


@overload(where)
def _compiled_where(condition: Any, yes: Any, no: Any) -> Any:
    def implementation(condition: Any, yes: Any, no: Any) -> Any:
        return yes if condition else no

    return implementation


def exp(x: Any) -> Any:
    """Exponential; compiled, it is `Traced.exp`, with the same bits for a number and for lanes."""
    return x.exp() if isinstance(x, Traced) else math.exp(x)


@intrinsic
def _exponential(_typing: Any, x: Any) -> Any:
    def codegen(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return Traced(builder, arguments[0]).exp().value

    return types.float64(types.float64), codegen


@overload(exp)
def _compiled_exp(x: Any) -> Any:
    def implementation(x: Any) -> Any:
        exponential: Any = _exponential
        return exponential(x)

    return implementation


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


def repeated(builder: ir.IRBuilder, scalar: ir.Value, count: int) -> ir.Value:
    """The vector of `count` times one number."""
    kind = ir.VectorType(_DOUBLE, count)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), scalar, ir.Constant(_LANE, 0))
    lanes = ir.Constant(ir.VectorType(_LANE, count), [0] * count)
    return builder.shuffle_vector(first, ir.Constant(kind, ir.Undefined), lanes)


def _constants(numbers: Sequence[float]) -> ir.Constant:
    return ir.Constant(ir.VectorType(_DOUBLE, len(numbers)), [ir.Constant(_DOUBLE, float(each)) for each in numbers])


class Series(list[Any]):
    """A power series cut off after as many terms as it has: a number whose product is Cauchy's rule.

    Others in its arithmetic are numbers, or series of as many terms.
    """

    def __add__(self, other: Any) -> "Series":
        if isinstance(other, Series):
            return Series(x + y for x, y in zip(self, other, strict=True))
        return Series([self[0] + other, *self[1:]])

    def __sub__(self, other: Any) -> "Series":
        return self + other * -1.0

    def __mul__(self, other: Any) -> "Series":
        if isinstance(other, Series):
            return Series(sum_of_products(self[: n + 1], other[n::-1]) for n in range(len(self)))
        return Series(each * other for each in self)

    def __radd__(self, other: Any) -> "Series":
        return self + other

    def __rmul__(self, other: Any) -> "Series":
        return self * other


class Row:
    """A row of the array that the code works on; its elements are loaded where they are used."""

    def __init__(self, builder: ir.IRBuilder, start: ir.Value, lanes: int) -> None:
        self.builder = builder
        self.start = start
        self.lanes = lanes

    def _place(self, n: int) -> ir.Value:
        return self.builder.gep(self.start, [ir.Constant(_INTEGER, n * self.lanes)])

    def __getitem__(self, n: int) -> Traced:
        place = self._place(n)
        if self.lanes > 1:
            place = self.builder.bitcast(place, ir.VectorType(_DOUBLE, self.lanes).as_pointer())
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
        start = self.builder.mul(self.width, ir.Constant(_INTEGER, i * self.lanes))
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
