"""Numbers known when the code runs, whose arithmetic writes the instructions."""

import math
from collections.abc import Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils

__all__ = ["DOUBLE", "INTEGER", "Traced", "repeated"]

DOUBLE = ir.DoubleType()
INTEGER = ir.IntType(64)
_LANE = ir.IntType(32)
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
        if isinstance(other, list):  # a series, whose own rule holds
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
            return ir.Constant(kind, float(value) if repeats is None else [ir.Constant(DOUBLE, float(value))] * repeats)
        return value if value.type == kind else repeated(self.builder, value, kind.count)

    def _shaped(self, kind: ir.Type) -> ir.Type:
        """That type, or a vector of it where this is a vector."""
        return ir.VectorType(kind, self.value.type.count) if isinstance(self.value.type, ir.VectorType) else kind

    def _bits(self) -> "Traced":
        return Traced(self.builder, self.builder.bitcast(self.value, self._shaped(INTEGER)))

    def _number(self) -> "Traced":
        """The number whose bits these are."""
        return Traced(self.builder, self.builder.bitcast(self.value, self._shaped(DOUBLE)))

    def _integer(self, instruction: str, constant: int) -> "Traced":
        kind = self.value.type
        repeats = getattr(kind, "count", None)
        same = ir.Constant(kind, constant if repeats is None else [ir.Constant(INTEGER, constant)] * repeats)
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
        kind = self._shaped(DOUBLE)
        values = (self._as(kind, each.value if isinstance(each, Traced) else each) for each in (yes, no))
        return Traced(self.builder, self.builder.select(self.value, *values))

    def mask(self) -> ir.Value:
        """The truths of a vector as the bits of an integer, the first lowest."""
        bits = self.builder.bitcast(self.value, ir.IntType(self.value.type.count))
        return self.builder.zext(bits, INTEGER)

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
        return Traced(self.builder, self.builder.uitofp(bits.value, self._shaped(DOUBLE))).fma(2.0**-52, -1022.957)

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


def repeated(builder: ir.IRBuilder, scalar: ir.Value, count: int) -> ir.Value:
    """The vector of `count` times one number."""
    kind = ir.VectorType(DOUBLE, count)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), scalar, ir.Constant(_LANE, 0))
    lanes = ir.Constant(ir.VectorType(_LANE, count), [0] * count)
    return builder.shuffle_vector(first, ir.Constant(kind, ir.Undefined), lanes)


def _constants(numbers: Sequence[float]) -> ir.Constant:
    return ir.Constant(ir.VectorType(DOUBLE, len(numbers)), [ir.Constant(DOUBLE, float(each)) for each in numbers])
