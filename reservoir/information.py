"""Information processing capacity: all that a linear readout can compute of the past input, function by function."""

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, known_names, number_within, whole_number
from .bootstrap import usual_block
from .decomposition import intervals, sequential_capacity
from .function_search import cutoff_of_surrogates, Found, search
from .orthonormal import of_usual_size, orthonormal_basis
from .product_basis import legendre_polynomials, products, Term, walsh
from .sensor_noise import with_sensor_noise
from .significance import events_needed

Array = NDArray[np.float64]
Basis = Literal["walsh", "legendre"]
Threshold = Literal["chi-squared", "surrogates"]

# Samples per independent state below which it is said that there are few.
_FEW = 10


@dataclass(frozen=True, eq=False)
class InformationCapacity:
    """What a linear readout of the states can compute of the past inputs.

    Attributes
    ----------
    terms : tuple of Term
        The functions found, each a tuple of pairs (delay, degree): ``((0, 1), (3, 1))`` is the product of the input
        with that of three steps ago.
    capacity : ndarray of shape (terms,)
        Share of each function's variance that the best readout explains, in [0, 1], after the functions before it have
        been taken out of it. What chance explains has been taken off.
    chance : ndarray of shape (terms,)
        Share that a function would be explained by chance alone: ``1 - (1 - capacity) (1 - chance)`` is what least
        squares explain in this sample.
    capacity_interval : ndarray of shape (2, terms)
        Ends of the interval of confidence of each capacity.
    total_interval : tuple of two floats
        Of the sum of the capacities of the functions found: what was too small to be found is not in it.
    degree : ndarray of shape (terms,)
        Sum of the degrees of the factors: 1 is linear memory.
    delay : ndarray of shape (terms,)
        The largest in the term: how far it reaches back.
    thresholds : dict of int to float
        What a function had to explain at least to be counted, by degree. One whose square is not constant had to
        explain more.
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
    chance: Array
    capacity_interval: Array
    total_interval: tuple[float, float]
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
    surrogates: int | None = None,
    patience: int | None = 10,
    budget: int = 100_000,
    support: tuple[float, float] | None = None,
    noise: float | None = None,
    confidence: float = 0.95,
    seed: int = 0,
) -> InformationCapacity:
    """Find which functions of the past inputs a linear readout of the states computes, and how well.

    For a function y of the inputs and an orthonormal basis Q of the centred states, the capacity is the share of its
    variance that least squares explain [1]_::

        C = ||Q^T y||^2 / ||y||^2

    Functions are tried by degree, and within a degree by how far they reach back. Of what passes the threshold, each
    is orthogonalized to those before it and counted for what is left: the functions are orthonormal in the mean but
    not quite in a finite sample, and only so can the total not be above the rank.

    Chance explains a share of any function, rank / samples if its square is constant. Of those found it is taken off
    as in an adjusted coefficient of determination, ``(C - c) / (1 - c)`` with ``c = (rank - 2 C') / samples``, C' being
    the sum of the capacities before it: directions of the states that are explained already are not left to chance.
    The threshold tells what chance does not explain:

    - ``"chi-squared"``: samples x C of a function that is independent of the states follows a chi-squared law with
      as many degrees of freedom as the rank [1]_. A function that is merely uncorrelated with them may scatter far
      more, where its square is not constant: each is compared with the law of its own, see
      `stickslip.reservoir.significance`.
    - ``"surrogates"`` [2]_: in addition, what functions of shuffled inputs explain. The capacities of up to 500
      functions of a degree are pooled over all the shuffles; their quantile, by a fitted tail where it lies beyond
      them, is the threshold. It assumes nothing of the inputs' law.

    Whatever the threshold, a capacity must rest on enough samples. Where flips are rare, the product of three of them
    can be told from that of four only after the fourth has had its chances to fall on the three: the effective number
    of samples, the products of a function with its prediction being their weights, must reach
    ``-2 ln(significance) E f^4``, with f the function of one input. It is 18 for fair bits at 1e-4, 150 at a dither of
    0.1, 880 at 0.02. A warning tells how many functions were left out for it.

    The intervals are Student's, of the influence of blocks of samples on a capacity; of its logit for a single one.

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
        Probability that a function uncorrelated with the states passes the threshold.
    surrogates : int, optional
        Shuffles of the input. By default 20, or as many more as a degree needs for its functions to give enough values
        for the significance: a thousand, or a hundredth of its inverse.
    patience : int or None
        A degree is left when so many delays in a row have added no function. None tries them all.
    budget : int
        Functions that are tried in all. A warning tells what was not tried for it. A degree costs at delay d about
        ``d^(degree - 1) / (degree - 1)!`` functions, and a function 2 x samples x features operations: with 10,000
        samples of 50 states a thousand functions take some 0.2 s.
    support : tuple of two floats, optional
        Interval in which the inputs are uniform, for Legendre; theirs from the least to the largest by default.
    noise : float, optional
        Signal-to-noise ratio of the sensors that read the states, in decibels; see
        `stickslip.reservoir.sensor_noise`. None by default.
    confidence : float, in (0, 1)
        Of the intervals.
    seed : int
        Of the shuffles and the noise.

    Returns
    -------
    InformationCapacity

    Raises
    ------
    TypeError
        If an argument that counts is not an integer.
    ValueError
        If an array has a wrong shape, is not finite or too short, the inputs do not suit the basis, an argument is
        out of range, or there are too few surrogates for the significance.

    Warns
    -----
    UserWarning
        If the budget was spent, the series is so short that the threshold is above 1/2 or that there are fewer than ten
        samples a state, or functions were left out because they rest on too few events.

    References
    ----------
    .. [1] J. Dambre, D. Verstraeten, B. Schrauwen and S. Massar, "Information processing capacity of dynamical
       systems", Scientific Reports 2, 514, 2012.
    .. [2] T. Kubota, H. Takahashi and K. Nakajima, "Unifying framework for information processing in stochastically
       driven dynamical systems", Physical Review Research 3, 043135, 2021.
    """
    # Imported where it is used: it takes a fifth of a second, and whoever only steps an environment needs none of it.
    from scipy.special import betaincinv

    x = of_usual_size(finite_array("states", states, 2))
    u = finite_array("inputs", inputs, 1)
    known_names("basis", [basis], ["walsh", "legendre"])
    known_names("threshold", [threshold], ["chi-squared", "surrogates"])
    max_degree = whole_number("max_degree", max_degree, 1)
    reach = _delays_by_degree(delays, max_degree)
    washout = whole_number("washout", washout, 0)
    significance = number_within("significance", significance, "(0, 1)")
    surrogates = None if surrogates is None else whole_number("surrogates", surrogates, 1)
    patience = max(reach) if patience is None else whole_number("patience", patience, 1)
    budget = whole_number("budget", budget, 1)
    confidence = number_within("confidence", confidence, "(0, 1)")
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
    q = orthonormal_basis(with_sensor_noise(x[start:], noise, seed))
    rank, samples = q.shape[1], len(q)
    cutoff = float(betaincinv(rank / 2, (samples - 1 - rank) / 2, 1 - significance)) if 0 < rank < samples - 1 else 1.0
    _warn_of_few_samples(samples, rank, cutoff)
    cutoffs = [cutoff] * max_degree
    if threshold == "surrogates":
        cutoffs = [
            max(cutoff, cutoff_of_surrogates(q, functions, start, d, reach[d - 1], surrogates, seed, significance))
            for d in range(1, len(reach) + 1)
        ]
    needed_events = events_needed(functions, significance)
    found = search(q, functions, start, reach, cutoffs, patience, budget, significance, needed_events)
    _warn_of_what_was_left_out(found, needed_events, budget)
    delay = np.array([term[-1][0] for term in found.terms], dtype=np.int64)
    block = usual_block(samples, delay) if len(delay) else 1
    each = sequential_capacity(q, products(functions, found.terms, start), block)
    ends, total_interval = intervals(each, confidence, rank)
    return InformationCapacity(
        terms=tuple(found.terms),
        capacity=each.capacity,
        chance=each.chance,
        capacity_interval=ends,
        total_interval=total_interval,
        degree=np.array([sum(degree for _, degree in term) for term in found.terms], dtype=np.int64),
        delay=delay,
        thresholds=dict(enumerate(cutoffs, 1)),
        rank=rank,
        tried=found.tried,
        reach=found.reach,
    )


def _warn_of_few_samples(samples: int, rank: int, cutoff: float) -> None:
    if rank and cutoff > 0.5:
        warnings.warn(
            f"no capacity below {cutoff:.2f} can be told from chance with {samples} samples of {rank} independent "
            f"states: what is found is a lower bound",
            stacklevel=3,
        )
    elif samples < _FEW * rank:
        warnings.warn(
            f"{samples} samples are few for {rank} independent states: chance explains {rank / samples:.0%} of any "
            f"function, and what it adds to those found is taken off only in the mean",
            stacklevel=3,
        )


def _warn_of_what_was_left_out(found: Found, needed_events: float, budget: int) -> None:
    if found.rare:
        warnings.warn(
            f"{found.rare} functions explain more than chance, but on fewer than {needed_events:.0f} effective "
            f"samples: they cannot be told from products with one more input, and are not counted. "
            f"Longer series or less rare inputs would tell",
            stacklevel=3,
        )
    if found.left:
        left = ", ".join(f"degree {degree} from delay {found.reach[degree] + 1} on" for degree in found.left)
        warnings.warn(f"the budget of {budget} functions was spent; not tried: {left}", stacklevel=3)


def _delays_by_degree(delays: int | Sequence[int], max_degree: int) -> list[int]:
    if not isinstance(delays, Iterable):
        return [whole_number("delays", delays, 1)] * max_degree
    each = [whole_number("delays", count, 1) for count in delays]
    if len(each) != max_degree:
        raise ValueError(f"delays must be one number or one for each of {max_degree} degrees, got {len(each)}")
    return each
