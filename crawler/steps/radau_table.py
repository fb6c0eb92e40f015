"""Tables of the Radau IIA methods of 5, 7, 9 and 11 stages, made once in 50-digit arithmetic and then rounded.

Collocation at the zeros of the Radau polynomial d^(s-1)/dt^(s-1) [t^(s-1) (1 - t)^s]: order 2s - 1, L-stable, and
stiffly accurate since the last node is 1 (E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 2nd
ed., IV.5; J. Comput. Appl. Math. 111 (1999) 93).
"""

import math
from collections.abc import Sequence
from decimal import Decimal, localcontext
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["CHECKS", "STAGES", "TABLES", "Tables"]

STAGES = (5, 7, 9, 11)
# Points between the nodes at which a step is checked.
CHECKS = 2

_DIGITS = 50
_WIDEST = STAGES[-1]


class Tables(NamedTuple):
    """What a step needs of each method; entry m belongs to the method of STAGES[m], the rest is zero."""

    nodes: NDArray[np.float64]  # (M, s + 1): the start, 0, and the s nodes
    gaps: NDArray[np.float64]  # (M, s + 1, s + 1): [i, k] is 1 / (node i - node i-k)
    integral: NDArray[np.float64]  # (M, s, s): Butcher's A, its last row the weights b
    twice: NDArray[np.float64]  # (M, s, s): A A
    eigenvalues: NDArray[np.complex128]  # (M, (s + 1) / 2): of A, the real one and one of each pair
    left: NDArray[np.float64]  # (M, s, s): left eigenvectors by rows, real and imaginary part
    right: NDArray[np.float64]  # (M, s, s): right ones by columns, twice the real and minus twice the imaginary part
    backward: NDArray[np.float64]  # (M, s): values at the nodes to their polynomial's value at the start
    checks: NDArray[np.float64]  # (M, CHECKS): where the polynomials through the start and the nodes err most
    between: NDArray[np.float64]  # (M, CHECKS, s + 1): values at the start and the nodes to those at the checks
    dense: NDArray[np.float64]  # (M,): largest error of the integral of a derivative that errs by 1 at the start
    monic: NDArray[np.float64]  # (M, s + 1): ascending coefficients of the product of (t - node)
    check_product: NDArray[np.float64]  # (M,): largest distance from the start and the nodes, multiplied


def _radau_nodes(stages: int) -> list[Decimal]:
    """Zeros of the Radau polynomial in (0, 1], ascending."""
    lost = stages - 1
    # Leibniz: t^(s-1) (1 - t)^s differentiated s - 1 times, term by term.
    polynomial = [Decimal((-1) ** k * math.comb(stages, k) * math.perm(lost + k, lost)) for k in range(stages + 1)]
    slope = _derivative(polynomial)
    nodes = []
    for guess in sorted(np.roots([float(c) for c in reversed(polynomial)]).real):
        node = Decimal(float(guess))
        for _ in range(8):
            node -= _value(polynomial, node) / _value(slope, node)
        nodes.append(node)
    nodes[-1] = Decimal(1)
    return nodes


def _value(polynomial: Sequence[Decimal], t: Decimal) -> Decimal:
    total = Decimal(0)
    for coefficient in reversed(polynomial):
        total = total * t + coefficient
    return total


def _derivative(polynomial: Sequence[Decimal]) -> list[Decimal]:
    return [n * c for n, c in enumerate(polynomial)][1:]


def _antiderivative(polynomial: Sequence[Decimal]) -> list[Decimal]:
    return [Decimal(0), *(c / (n + 1) for n, c in enumerate(polynomial))]


def _with_zeros(zeros: Sequence[Decimal]) -> list[Decimal]:
    """Ascending coefficients of the monic polynomial with the given zeros."""
    polynomial = [Decimal(1)]
    for zero in zeros:
        shifted = [Decimal(0), *polynomial]
        polynomial = [high - zero * low for high, low in zip(shifted, [*polynomial, Decimal(0)], strict=True)]
    return polynomial


def _lagrange(nodes: Sequence[Decimal]) -> list[list[Decimal]]:
    """Polynomials that are 1 at one node and 0 at the others."""
    basis = []
    for j, node in enumerate(nodes):
        product = _with_zeros([other for i, other in enumerate(nodes) if i != j])
        height = _value(product, node)
        basis.append([c / height for c in product])
    return basis


def _peaks(polynomial: Sequence[Decimal]) -> list[tuple[Decimal, Decimal]]:
    """Where a polynomial with all its zeros in [0, 1] is farthest from 0 between them, and how far; farthest first."""
    turns = [Decimal(float(t)) for t in np.roots([float(c) for c in reversed(_derivative(polynomial))]).real]
    return sorted(((abs(_value(polynomial, t)), t) for t in turns), reverse=True)


def _tables() -> Tables:
    count = len(STAGES)
    tables = Tables(
        nodes=np.zeros((count, _WIDEST + 1)),
        gaps=np.zeros((count, _WIDEST + 1, _WIDEST + 1)),
        integral=np.zeros((count, _WIDEST, _WIDEST)),
        twice=np.zeros((count, _WIDEST, _WIDEST)),
        eigenvalues=np.zeros((count, _WIDEST // 2 + 1), np.complex128),
        left=np.zeros((count, _WIDEST, _WIDEST)),
        right=np.zeros((count, _WIDEST, _WIDEST)),
        backward=np.zeros((count, _WIDEST)),
        checks=np.zeros((count, CHECKS)),
        between=np.zeros((count, CHECKS, _WIDEST + 1)),
        dense=np.zeros(count),
        monic=np.zeros((count, _WIDEST + 1)),
        check_product=np.zeros(count),
    )
    with localcontext() as context:
        context.prec = _DIGITS
        for m, stages in enumerate(STAGES):
            _fill(tables, m, stages)
    return tables


def _fill(tables: Tables, m: int, s: int) -> None:
    nodes = _radau_nodes(s)
    everywhere = [Decimal(0), *nodes]
    tables.nodes[m, : s + 1] = [float(node) for node in everywhere]
    for i in range(s + 1):
        for k in range(1, i + 1):
            tables.gaps[m, i, k] = float(1 / (everywhere[i] - everywhere[i - k]))

    basis = _lagrange(nodes)
    integrals = [_antiderivative(polynomial) for polynomial in basis]
    rows = [[_value(integral, node) for integral in integrals] for node in nodes]
    tables.integral[m, :s, :s] = [[float(entry) for entry in row] for row in rows]
    tables.twice[m, :s, :s] = [[float(sum(row[k] * rows[k][j] for k in range(s))) for j in range(s)] for row in rows]
    tables.backward[m, :s] = [float(polynomial[0]) for polynomial in basis]

    # Rounding of the eigenvectors slows Newton's iteration, if anything; it does not move its limit.
    values, vectors = np.linalg.eig(tables.integral[m, :s, :s])
    duals = np.linalg.inv(vectors)
    kept = [int(np.argmin(abs(values.imag))), *np.flatnonzero(values.imag > 1e-8)]
    for k, index in enumerate(kept):
        tables.eigenvalues[m, k] = values[index]
        if k == 0:
            tables.left[m, 0, :s] = (duals[index] * vectors[0, index]).real
            tables.right[m, :s, 0] = (vectors[:, index] / vectors[0, index]).real
        else:
            tables.left[m, 2 * k - 1, :s] = duals[index].real
            tables.left[m, 2 * k, :s] = duals[index].imag
            tables.right[m, :s, 2 * k - 1] = 2.0 * vectors[:, index].real
            tables.right[m, :s, 2 * k] = -2.0 * vectors[:, index].imag

    monic = _with_zeros(nodes)
    tables.monic[m, : s + 1] = [float(coefficient) for coefficient in monic]
    tables.dense[m] = float(max(abs(_value(_antiderivative(monic), node)) for node in nodes) / abs(monic[0]))
    whole = _lagrange(everywhere)
    peaks = _peaks(_with_zeros(everywhere))
    tables.check_product[m] = float(peaks[0][0])
    for k, (_, moment) in enumerate(peaks[:CHECKS]):
        tables.checks[m, k] = float(moment)
        tables.between[m, k, : s + 1] = [float(_value(polynomial, moment)) for polynomial in whole]


TABLES = _tables()
