"""Arithmetic that recurrences are written in: the same over floats, mpmath's numbers and traced values.

Compiled, each function gives the bits that its traced twin gives in lanes.
"""

import math
from collections.abc import Sequence
from typing import Any

from numba import types
from numba.extending import intrinsic, overload

from .traced import Traced

__all__ = ["Series", "exp", "fma", "sum_of_products", "where"]

# Additions wait four cycles for each other and two can begin in each; more chains than this gain nothing.
_CHAINS = 4


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
