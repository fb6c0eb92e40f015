"""Kernel rank and generalisation rank: telling inputs apart, and knowing when not to."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within, whole_number
from .sensor_noise import noise_over_signal

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class KernelQuality:
    """How a reservoir separates inputs, and how it generalises over them.

    Attributes
    ----------
    kernel_rank : int
        Directions in which states differ after different inputs: how many linear separations are possible.
    generalisation_rank : float
        Directions in which they differ after inputs that ended alike, mean over the endings: how much of that is spent
        on what is past.
    kernel_singular_values : ndarray of shape (values,)
    generalisation_singular_values : ndarray of shape (values,) or (endings, values)
        Of the states in units of their standard deviation over the different inputs, divided by the square root of the
        number of inputs. What the ranks count, for other thresholds.
    threshold : float
        Share of the largest kernel singular value above which a direction counts; with `noise`, that of its ratio.
    """

    kernel_rank: int
    generalisation_rank: float
    kernel_singular_values: Array
    generalisation_singular_values: Array
    threshold: float

    @property
    def difference(self) -> float:
        """Kernel rank less generalisation rank, by which [1]_ of `kernel_quality` predicts performance."""
        return self.kernel_rank - self.generalisation_rank


def ranks(
    different: ArrayLike, similar: ArrayLike, *, threshold: float = 1e-3, noise: float | None = None
) -> KernelQuality:
    """Compute the kernel and the generalisation rank of states that are given.

    Both matrices of states are put in units of the standard deviations over the different inputs, less their own
    mean, which a readout's constant supplies. (Where it is left in, as some do, a rank may come out higher by one.)
    The ranks are numerical: without noise a reservoir that forgets geometrically has full rank for ever, at ever
    smaller singular values. So a direction counts if its singular value, over the square root of the number of
    inputs, is above a share of the largest that different inputs make. Or give the noise of the sensors: then a
    direction counts if the states differ in it by more than the noise does, which is alike in all directions.

    Parameters
    ----------
    different : array_like of shape (inputs, features)
        States reached after inputs that were drawn independently.
    similar : array_like of shape (inputs, features) or (endings, inputs, features)
        States reached after inputs that differ only in what a reservoir ought to ignore: far back, or by noise. The
        rank depends on what they have in common, so it is averaged over several such ends.
    threshold : float, in (0, 1)
        Of no matter where `noise` is given.
    noise : float, optional
        Signal-to-noise ratio of the sensors in decibels, the signal being what different inputs make of a feature.

    Returns
    -------
    KernelQuality

    Raises
    ------
    ValueError
        If an array has a wrong shape or is not finite, or `threshold` is out of range.

    Warns
    -----
    UserWarning
        If there are so few inputs that they bound a rank, and not the reservoir.
    """
    kernel = finite_array("different", different, 2)
    generalisation = finite_array("similar", similar, (2, 3))
    endings = generalisation.reshape(-1, *generalisation.shape[-2:])
    threshold = number_within("threshold", threshold, "(0, 1)")
    if kernel.shape[1] != generalisation.shape[-1]:
        raise ValueError(
            f"similar must have as many features as different, {kernel.shape[1]}, got {generalisation.shape[-1]}"
        )
    for name, states in (("different", kernel), ("similar", endings[0])):
        if len(states) < 2:
            raise ValueError(f"{name} must hold the states of two inputs at least, got {len(states)}")
    spread = (kernel - kernel[0]).std(axis=0)
    # What never moves over different inputs is no feature, and has no unit.
    moving = spread > 0
    scale = np.where(moving, spread, 1)
    kernel_values = _singular_values((kernel - kernel[0])[:, moving] / scale[moving])
    similar_values = np.array([_singular_values((each - kernel[0])[:, moving] / scale[moving]) for each in endings])
    floor = threshold * kernel_values[0] if kernel_values.size else np.inf
    if noise is not None:
        floor = noise_over_signal(noise)
        threshold = floor / float(kernel_values[0]) if kernel_values.size else floor
    kernel_rank, similar_ranks = int((kernel_values > floor).sum()), (similar_values > floor).sum(axis=1)
    quality = KernelQuality(
        kernel_rank,
        float(similar_ranks.mean()),
        kernel_values,
        similar_values if generalisation.ndim == 3 else similar_values[0],
        threshold,
    )
    for name, states, rank in (("different", kernel, kernel_rank), ("similar", endings[0], int(similar_ranks.max()))):
        if rank == len(states) - 1 < moving.sum():
            warnings.warn(
                f"{name} has {len(states)} inputs, whose states cannot span more than {rank} directions: the rank is a "
                f"lower bound",
                stacklevel=2,
            )
    return quality


def kernel_quality(
    reservoir: Callable[[Array], ArrayLike],
    *,
    inputs: int,
    length: int = 100,
    shared: int = 10,
    endings: int = 5,
    threshold: float = 1e-3,
    noise: float | None = None,
    seed: int = 0,
) -> KernelQuality:
    """Measure the kernel and the generalisation rank of a reservoir with random bits.

    The kernel rank is that of the states after independent streams of bits [1]_; the generalisation rank that of the
    states after streams with one common end and independent beginnings [2]_, averaged over such ends, which are
    drawn too. See `ranks`.

    Parameters
    ----------
    reservoir : callable
        Takes inputs (length,), starts from rest and returns states (length, features); the last row is used. It is
        called ``(1 + endings) * inputs`` times.
    inputs : int, at least 2
        Streams of each kind: more than the features, or they bound the ranks.
    length : int, at least 1
    shared : int, in [0, length]
        Bits at the end that are the same in all the similar streams.
    endings : int, at least 1
        Common ends that the generalisation rank is averaged over.
    threshold, noise
        As in `ranks`.
    seed : int

    Returns
    -------
    KernelQuality

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid or the reservoir returns another shape.

    References
    ----------
    .. [1] R. Legenstein and W. Maass, "Edge of chaos and prediction of computational performance for neural circuit
       models", Neural Networks 20, 323, 2007.
    .. [2] L. Büsing, B. Schrauwen and R. Legenstein, "Connectivity, dynamics, and memory in reservoir computing with
       binary and analog neurons", Neural Computation 22, 1272, 2010.
    """
    inputs = whole_number("inputs", inputs, 2)
    length = whole_number("length", length, 1)
    shared = whole_number("shared", shared, 0, length)
    random = np.random.default_rng(whole_number("seed", seed, 0))
    endings = whole_number("endings", endings, 1)
    different, *similar = random.integers(0, 2, (1 + endings, inputs, length)).astype(np.float64)
    for streams in similar:
        streams[:, length - shared :] = streams[0, length - shared :]
    return ranks(
        [_last_state(reservoir, stream) for stream in different],
        [[_last_state(reservoir, stream) for stream in streams] for streams in similar],
        threshold=threshold,
        noise=noise,
    )


def _last_state(reservoir: Callable[[Array], ArrayLike], stream: Array) -> Array:
    states = finite_array("the reservoir's states", reservoir(stream.copy()), 2)
    if len(states) != len(stream):
        raise ValueError(f"the reservoir must return a row of states an input, {len(stream)}, got {len(states)}")
    # A reservoir may write all its states into one array.
    return states[-1].copy()


def _singular_values(states: Array) -> Array:
    if states.shape[1] == 0:
        return np.zeros(0)
    values: Array = np.linalg.svd(states - states.mean(axis=0), compute_uv=False)
    return values / np.sqrt(len(states))
