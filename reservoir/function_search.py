"""The search for functions of past inputs that states compute, and the threshold by shuffled inputs."""

import math
from collections.abc import Iterator
from itertools import chain, islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .product_basis import count_terms, products, Term, terms
from .significance import chance, effective_events, tail_quantile, VALUES_FOR_A_TAIL

Array = NDArray[np.float64]

# Numbers of a batch of products: a few megabytes.
_BATCH = 2**19
# Functions of a degree whose capacities are pooled over the shuffles.
_POOLED = 500
_SHUFFLES = 20


class Found(NamedTuple):
    """What a search found.

    Attributes
    ----------
    terms : list of Term
        By degree, and within a degree by how far they reach back.
    tried : dict of int to int
        Functions tried, by degree.
    reach : dict of int to int
        Largest delay tried, by degree; -1 where there is none.
    left : list of int
        Degrees that the budget did not suffice for.
    rare : int
        Functions that explain more than chance, but on too few events.
    """

    terms: list[Term]
    tried: dict[int, int]
    reach: dict[int, int]
    left: list[int]
    rare: int


def search(
    q: Array,
    functions: Array,
    start: int,
    reach: list[int],
    cutoffs: list[float],
    patience: int,
    budget: int,
    significance: float,
    needed_events: float,
) -> Found:
    """Try products by degree, and within a degree by how far they reach back.

    Parameters
    ----------
    q : ndarray of shape (samples, rank)
        Orthonormal basis of the states, of zero mean.
    functions : ndarray of shape (degrees, start + samples)
        Functions of one input, as in `stickslip.reservoir.product_basis`.
    start : int
        Sample of the functions that the first of the states belongs to; at least the largest delay.
    reach : list of int
        Delays to try, by degree.
    cutoffs : list of float
        What a function has to explain at least, by degree.
    patience, budget, significance
        As in `stickslip.reservoir.information_processing_capacity`.
    needed_events : float
        Effective samples that a capacity has to rest on.

    Returns
    -------
    Found
    """
    found = Found([], {}, {}, [], 0)
    highest = len(functions)
    rare = 0
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
            for batch, capacity, rows in _capacities(q, functions, start, window):
                likely = np.flatnonzero(capacity > cutoff)
                if len(likely):
                    own = chance(q, rows[likely], significance, capacity[likely]).cutoff
                    likely = likely[capacity[likely] > own]
                    seen = effective_events(q, rows[likely]) > needed_events
                    rare += int((~seen).sum())
                    likely = likely[seen]
                found.terms.extend(batch[i] for i in likely)
                passed += len(likely)
            found.tried[degree] += count
            found.reach[degree] = latest
            # The first bits have no product of many.
            quiet = 0 if passed else quiet + (count > 0)
            if quiet >= patience:
                break
    return found._replace(rare=rare)


def cutoff_of_surrogates(
    q: Array,
    functions: Array,
    start: int,
    degree: int,
    delays: int,
    surrogates: int | None,
    seed: int,
    significance: float,
) -> float:
    """What functions of one degree of shuffled inputs explain no more often than `significance`.

    Parameters
    ----------
    q, functions, start
        As in `search`.
    degree, delays : int
        Of the functions.
    surrogates : int or None
        Shuffles; None is as many as the significance needs, and 20 at least.
    seed : int
    significance : float, in (0, 1)

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If there are too few surrogates for the significance.
    """
    highest = len(functions)
    pooled = list(islice(chain.from_iterable(terms(degree, latest, highest) for latest in range(delays)), _POOLED))
    if not pooled:
        return 1.0
    needed = math.ceil(max(VALUES_FOR_A_TAIL, 0.01 / significance) / len(pooled))
    shuffles = max(_SHUFFLES, needed) if surrogates is None else surrogates
    if shuffles < needed:
        raise ValueError(
            f"surrogates must be {needed} at least for a significance of {significance:g} with {len(pooled)} functions "
            f"of degree {degree}, got {shuffles}"
        )
    orders = (np.random.default_rng([seed, i]).permutation(functions.shape[1]) for i in range(shuffles))
    values = [
        capacity for order in orders for _, capacity, _ in _capacities(q, functions[:, order], start, iter(pooled))
    ]
    return tail_quantile(np.concatenate(values), significance)


def _capacities(
    q: Array, functions: Array, start: int, wanted: Iterator[Term]
) -> Iterator[tuple[list[Term], Array, Array]]:
    size = max(1, _BATCH // len(q))
    while batch := list(islice(wanted, size)):
        rows = products(functions, batch, start)
        variance = np.vecdot(rows, rows) - rows.sum(axis=1) ** 2 / rows.shape[1]
        projected = rows @ q
        explained = np.vecdot(projected, projected)
        yield batch, np.divide(explained, variance, out=np.zeros_like(explained), where=variance > 0), rows
