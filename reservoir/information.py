"""Information processing capacity: all that a linear readout can compute of the past input, function by function."""

import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from typing import Literal, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..validation import finite_array, known_names, number_within, whole_number
from .orthonormal import of_usual_size, orthonormal_basis
from .product_basis import count_terms, legendre_polynomials, products, Term, terms, walsh

Array = NDArray[np.float64]
Basis = Literal["walsh", "legendre"]
Threshold = Literal["chi-squared", "surrogates"]

# Numbers of a batch of products: a few megabytes.
_BATCH = 2**19
# What a function of an input scatters about a state that holds another function of it, relative to independent ones:
# 11/7 for the first two Legendre polynomials.
_DEPENDENCE = 2.0
# Functions of a degree whose capacities are pooled over the shuffles.
_POOLED = 500
# Share of a function left by those before it below which it is one of them, but for rounding.
_NEW = 1e-6


@dataclass(frozen=True, eq=False)
class InformationCapacity:
    """What a linear readout of the states can compute of the past inputs.

    Attributes
    ----------
    terms : tuple of Term
        The functions found, each a tuple of pairs (delay, degree): ``((0, 1), (3, 1))`` is the product of the input
        with that of three steps ago.
    capacity : ndarray of shape (terms,)
        Share of each function's variance that the readout explains, in [0, 1], after the functions before it have been
        taken out of it.
    degree : ndarray of shape (terms,)
        Sum of the degrees of the factors: 1 is linear memory.
    delay : ndarray of shape (terms,)
        The largest in the term: how far it reaches back.
    thresholds : dict of int to float
        What a function had to explain to be counted, by degree.
    rank : int
        Rank of the centred states. The total is this if the states are functions of the input alone, if all the
        functions that they are made of were tried, and if there were samples enough to tell each from chance.
    tried : dict of int to int
        Functions tried, by degree.
    reach : dict of int to int
        Largest delay tried, by degree.
    """

    terms: tuple[Term, ...]
    capacity: Array
    degree: NDArray[np.int64]
    delay: NDArray[np.int64]
    thresholds: dict[int, float]
    rank: int
    tried: dict[int, int]
    reach: dict[int, int]

    @property
    def total(self) -> float:
        """Sum of the capacities: at most `rank`, to rounding, in any sample."""
        return float(self.capacity.sum())

    @property
    def nonlinear_share(self) -> float:
        """Share of the total that is not of degree 1; not a number if there is none at all."""
        return float(self.capacity[self.degree > 1].sum() / self.total) if self.terms else float("nan")

    def by_degree(self) -> dict[int, float]:
        """Capacity of each degree that was tried."""
        return {degree: float(self.capacity[self.degree == degree].sum()) for degree in self.tried}

    def profile(self) -> dict[int, Array]:
        """Capacity of each degree by largest delay: where memory is traded for nonlinearity.

        Returns
        -------
        dict of int to ndarray of shape (largest delay tried + 1,)
        """
        profiles = {degree: np.zeros(self.reach[degree] + 1) for degree in self.tried}
        for degree, delay, capacity in zip(self.degree, self.delay, self.capacity, strict=True):
            profiles[int(degree)][delay] += capacity
        return profiles


def information_processing_capacity(
    states: ArrayLike,
    inputs: ArrayLike,
    *,
    basis: Basis = "walsh",
    max_degree: int = 3,
    delays: int | Sequence[int] = 50,
    washout: int = 200,
    threshold: Threshold = "chi-squared",
    significance: float = 1e-4,
    surrogates: int = 20,
    patience: int | None = 10,
    budget: int = 100_000,
    support: tuple[float, float] | None = None,
    seed: int = 0,
) -> InformationCapacity:
    """Find which functions of the past inputs a linear readout of the states computes, and how well.

    For a function y of the inputs and an orthonormal basis Q of the centred states, the capacity is the share of its
    variance that least squares explain [1]_::

        C = ||Q^T y||^2 / ||y||^2

    Functions are tried by degree, and within a degree by how far they reach back. Of what passes the threshold, each
    is orthogonalized to those before it and counted for what is left: the functions are orthonormal in the mean but
    not quite in a finite sample, and only so can the total not be above the rank.

    Chance explains rank / samples of any function. The threshold tells what chance does not explain:

    - ``"chi-squared"`` [1]_: samples x C of a function that is independent of the states follows a chi-squared law with
      as many degrees of freedom as the rank. Its quantile is doubled, since functions that share an input with the
      states without being correlated with them scatter more.
    - ``"surrogates"`` [2]_: what functions of shuffled inputs explain. The capacities of up to 500 functions of a
      degree are pooled over all the shuffles; their quantile is the threshold. It assumes nothing of the inputs' law.

    Parameters
    ----------
    states : array_like of shape (samples, features)
        Row k is the state after it absorbed input k.
    inputs : array_like of shape (samples,)
        Independent from step to step, and with the law that the basis is for. The innovations of a dithered valve are
        such inputs, its states are not.
    basis : {"walsh", "legendre"}
        Products of bits, complete for inputs of two values, biased or not; or Legendre polynomials and their products,
        complete for uniform inputs. See `stickslip.reservoir.product_basis`.
    max_degree : int, at least 1
    delays : int or sequence of int
        Delays 0 to ``delays - 1`` are tried; one number for all degrees, or one for each.
    washout : int
        Samples at the start that are left out, at least as many as the state takes to forget its start.
    threshold : {"chi-squared", "surrogates"}
    significance : float, in (0, 1)
        Probability that a function independent of the states passes the quantile.
    surrogates : int
        Shuffles of the input. A significance of 1e-4 asks for 20 of them.
    patience : int or None
        A degree is left when so many delays in a row have added no function. None tries them all.
    budget : int
        Functions that are tried in all. A warning tells what was not tried for it. A degree costs at delay d about
        ``d^(degree - 1) / (degree - 1)!`` functions, and a function 2 x samples x features operations: with 10,000
        samples of 50 states a thousand functions take some 0.2 s.
    support : tuple of two floats, optional
        Interval in which the inputs are uniform, for Legendre; theirs from the least to the largest by default.
    seed : int
        Of the shuffles.

    Returns
    -------
    InformationCapacity

    Raises
    ------
    TypeError
        If an argument that counts is not an integer.
    ValueError
        If an array has a wrong shape, is not finite or too short, the inputs do not suit the basis, or an argument is
        out of range.

    Warns
    -----
    UserWarning
        If the budget was spent, or the series is so short that the threshold is above 1/2.

    References
    ----------
    .. [1] J. Dambre, D. Verstraeten, B. Schrauwen and S. Massar, "Information processing capacity of dynamical
       systems", Scientific Reports 2, 514, 2012.
    .. [2] T. Kubota, H. Takahashi and K. Nakajima, "Unifying framework for information processing in stochastically
       driven dynamical systems", Physical Review Research 3, 043135, 2021.
    """
    # Imported where it is used: it takes a fifth of a second, and whoever only steps an environment needs none of it.
    from scipy.special import chdtri

    x = of_usual_size(finite_array("states", states, 2))
    u = finite_array("inputs", inputs, 1)
    known_names("basis", [basis], ["walsh", "legendre"])
    known_names("threshold", [threshold], ["chi-squared", "surrogates"])
    max_degree = whole_number("max_degree", max_degree, 1)
    reach = _delays_by_degree(delays, max_degree)
    washout = whole_number("washout", washout, 0)
    significance = number_within("significance", significance, "(0, 1)")
    surrogates = whole_number("surrogates", surrogates, 1)
    patience = max(reach) if patience is None else whole_number("patience", patience, 1)
    budget = whole_number("budget", budget, 1)
    seed = whole_number("seed", seed, 0)
    start = max(washout, max(reach) - 1)
    needed = start + x.shape[1] + 2
    if len(u) != len(x):
        raise ValueError(f"inputs must have as many samples as states, {len(x)}, got {len(u)}")
    if len(x) < needed:
        raise ValueError(
            f"states must have at least {needed} samples for {x.shape[1]} features, washout={washout} and "
            f"{max(reach)} delays, got {len(x)}"
        )
    if np.ptp(u) == 0:
        raise ValueError(f"inputs must vary, or there is nothing to compute with, got {u[0]} throughout")

    functions = walsh(u) if basis == "walsh" else legendre_polynomials(u, max_degree, support)
    q = orthonormal_basis(x[start:])
    rank, samples = q.shape[1], len(q)
    cutoff = min(1.0, _DEPENDENCE * float(chdtri(rank, significance)) / samples) if rank else 1.0
    if rank and cutoff > 0.5:
        warnings.warn(
            f"no capacity below {cutoff:.2f} can be told from chance with {samples} samples of {rank} independent "
            f"states: what is found is a lower bound",
            stacklevel=2,
        )
    cutoffs = [cutoff] * max_degree
    if threshold == "surrogates":
        shuffles = [np.random.default_rng([seed, i]).permutation(len(u)) for i in range(surrogates)]
        cutoffs = [
            _chance(q, functions, start, d, reach[d - 1], shuffles, significance) for d in range(1, len(reach) + 1)
        ]
    found = _search(q, functions, start, reach, cutoffs, patience, budget)
    if found.left:
        left = ", ".join(f"degree {degree} from delay {found.reach[degree] + 1} on" for degree in found.left)
        warnings.warn(f"the budget of {budget} functions was spent; not tried: {left}", stacklevel=2)
    return InformationCapacity(
        terms=tuple(found.terms),
        capacity=_capacity_in_turn(q, products(functions, found.terms, start)),
        degree=np.array([sum(degree for _, degree in term) for term in found.terms], dtype=np.int64),
        delay=np.array([term[-1][0] for term in found.terms], dtype=np.int64),
        thresholds=dict(enumerate(cutoffs, 1)),
        rank=rank,
        tried=found.tried,
        reach=found.reach,
    )


class _Found(NamedTuple):
    terms: list[Term]
    tried: dict[int, int]
    reach: dict[int, int]
    left: list[int]


def _search(
    q: Array, functions: Array, start: int, reach: list[int], cutoffs: list[float], patience: int, budget: int
) -> _Found:
    found = _Found([], {}, {}, [])
    highest = len(functions)
    for degree, (delays, cutoff) in enumerate(zip(reach, cutoffs, strict=True), 1):
        found.tried[degree], found.reach[degree] = 0, -1
        quiet = 0
        for latest in range(delays):
            count = count_terms(degree, latest, highest)
            if sum(found.tried.values()) + count > budget:
                found.left.append(degree)
                break
            passed = 0
            window = terms(degree, latest, highest)
            for batch, capacity in _capacities(q, functions, start, window):
                chosen = [term for term, c in zip(batch, capacity, strict=True) if c > cutoff]
                found.terms.extend(chosen)
                passed += len(chosen)
            found.tried[degree] += count
            found.reach[degree] = latest
            # The first bits have no product of many.
            quiet = 0 if passed else quiet + (count > 0)
            if quiet >= patience:
                break
    return found


def _capacities(q: Array, functions: Array, start: int, wanted: Iterator[Term]) -> Iterator[tuple[list[Term], Array]]:
    size = max(1, _BATCH // len(q))
    while batch := list(islice(wanted, size)):
        rows = products(functions, batch, start)
        variance = np.vecdot(rows, rows) - rows.sum(axis=1) ** 2 / rows.shape[1]
        projected = rows @ q
        explained = np.vecdot(projected, projected)
        yield batch, np.divide(explained, variance, out=np.zeros_like(explained), where=variance > 0)


def _chance(
    q: Array,
    functions: Array,
    start: int,
    degree: int,
    delays: int,
    shuffles: list[NDArray[np.int64]],
    significance: float,
) -> float:
    highest = len(functions)
    pooled = list(islice(chain.from_iterable(terms(degree, latest, highest) for latest in range(delays)), _POOLED))
    values = [
        capacity for order in shuffles for _, capacity in _capacities(q, functions[:, order], start, iter(pooled))
    ]
    return float(np.quantile(np.concatenate(values), 1 - significance)) if values else 1.0


def _capacity_in_turn(q: Array, rows: Array) -> Array:
    """Capacity of what each function adds to those before it: a decomposition of the trace of two projections."""
    if rows.size == 0:
        return np.zeros(len(rows))
    moved = (rows - rows.mean(axis=1, keepdims=True)).T
    norms = np.linalg.norm(moved, axis=0)
    turned, triangle = scipy.linalg.qr(moved, mode="economic", check_finite=False)
    projected = q.T @ turned
    capacity = np.zeros(len(rows))
    new = np.abs(triangle.diagonal()) > _NEW * norms[: len(triangle)]
    capacity[: len(new)][new] = np.einsum("ij,ij->j", projected, projected)[new]
    return np.minimum(capacity, 1)


def _delays_by_degree(delays: int | Sequence[int], max_degree: int) -> list[int]:
    if not isinstance(delays, Iterable):
        return [whole_number("delays", delays, 1)] * max_degree
    each = [whole_number("delays", count, 1) for count in delays]
    if len(each) != max_degree:
        raise ValueError(f"delays must be one number or one for each of {max_degree} degrees, got {len(each)}")
    return each
