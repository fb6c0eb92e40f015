"""What a reservoir is, beside what it can do: measures that the benchmark takes as it runs a task, and never tunes."""

import math
import warnings
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..common.validation import known_names, whole_number
from ..reservoir import echo_state_property, information_processing_capacity, KernelQuality, ranks
from .reservoirs import Reservoir
from .streams import random_bits
from .task import Metric, Solution, Task

__all__ = ["MEASURES", "EchoIndex", "InformationCapacityOfBits", "KernelRank"]

_REACH = (40, 30, 20)
"""Delays at which functions of degree 1, 2 and 3 are tried: some 1600 in all."""

_STARTS = 5
_STREAM, _SHARED, _ENDINGS = 100, 10, 5
_THRESHOLD = 1e-3
"""Share of the largest singular value above which a direction counts in the ranks."""


def _information(states: NDArray[np.float64], targets: NDArray[np.float64], start: int) -> Solution:
    found = information_processing_capacity(states, targets, max_degree=len(_REACH), delays=_REACH, washout=start)
    by_degree = {str(degree): capacity for degree, capacity in found.by_degree().items()}
    return Solution(found.total, details={"by degree": by_degree, "rank": found.rank})


def _ranks(states: NDArray[np.float64], targets: NDArray[np.float64]) -> KernelQuality:
    """Of states after different streams where the target is 0, and after those of each common end from 1 on."""
    similar = [states[targets == ending] for ending in np.unique(targets[targets > 0])]
    return ranks(states[targets == 0], similar, threshold=_THRESHOLD)


def _kernel_rank(states: NDArray[np.float64], targets: NDArray[np.float64], start: int) -> Solution:
    return Solution(float(_ranks(states, targets).kernel_rank), details={"threshold": _THRESHOLD})


def _generalisation_rank(states: NDArray[np.float64], targets: NDArray[np.float64], start: int) -> Solution:
    return Solution(_ranks(states, targets).generalisation_rank, details={"threshold": _THRESHOLD})


def _echo_index(states: NDArray[np.float64], targets: NDArray[np.float64], start: int) -> Solution:
    with warnings.catch_warnings():
        # A reservoir that forgets all at once, as a delay line does, has no exponent.
        warnings.filterwarnings("ignore", message=".*Lyapunov", category=UserWarning)
        found = echo_state_property(states)
    exponent = None if math.isnan(found.exponent) else found.exponent
    return Solution(float(found.echo_index), details={"exponent": exponent, "consistency": found.consistency})


_INFORMATION = Metric("capacity", _information, more_is_better=True, chance=0.0)
_KERNEL_RANK = Metric("rank", _kernel_rank, more_is_better=True, chance=0.0)
_GENERALISATION_RANK = Metric("rank", _generalisation_rank, more_is_better=False, chance=0.0)
_ECHO_INDEX = Metric("index", _echo_index, more_is_better=False, chance=1.0)


@dataclass(frozen=True)
class InformationCapacityOfBits:
    """Information processing capacity of random bits up to degree 3: the total, and what each degree adds to it.

    The rank of the states is its bound. A function counts that explains more than chance does (chi-squared).
    """

    metric: Metric = _INFORMATION

    def attempt(self, reservoir: Reservoir, *, length: int, seed: int, washout: int) -> Solution:
        """Measure one reservoir as it is, on `length` bits.

        Raises
        ------
        TypeError, ValueError
            If an argument is invalid, or the length too short for the washout and the features.
        """
        bits = random_bits(length, seed).astype(np.float64)
        return self.metric.solve(reservoir(bits, seed), bits, washout)


@dataclass(frozen=True)
class KernelRank:
    """Directions in which states differ after streams of bits: twice as many streams as features, and two more.

    Attributes
    ----------
    which : {"kernel", "generalisation"}
        Whether the streams are different throughout, or have their last 10 of 100 bits in common; the rank of these is
        averaged over five such ends.

    Raises
    ------
    ValueError
        If `which` is neither.
    """

    which: Literal["kernel", "generalisation"] = "kernel"

    def __post_init__(self) -> None:
        known_names("which", [self.which], ["kernel", "generalisation"])

    @property
    def metric(self) -> Metric:
        """The rank; of inputs that ought to be alike a reservoir had better tell few apart."""
        return _KERNEL_RANK if self.which == "kernel" else _GENERALISATION_RANK

    def attempt(self, reservoir: Reservoir, *, length: int, seed: int, washout: int) -> Solution:
        """Measure one reservoir as it is; `length` and `washout` are of no matter, every stream being 100 bits."""
        random = np.random.default_rng(whole_number("seed", seed, 0))
        first = random.integers(0, 2, _STREAM).astype(np.float64)
        inputs = 2 * reservoir(first, seed).shape[1] + 2
        # Only the similar streams have several kinds.
        kinds = 1 + (_ENDINGS if self.which == "generalisation" else 1)
        streams = random.integers(0, 2, (kinds, inputs, _STREAM)).astype(np.float64)
        streams[1:, :, -_SHARED:] = streams[1:, :1, -_SHARED:]
        last = np.array([reservoir(stream, seed)[-1] for stream in streams.reshape(-1, _STREAM)])
        return self.metric.solve(last, np.repeat(np.arange(float(kinds)), inputs), 0)


@dataclass(frozen=True)
class EchoIndex:
    """Trajectories still apart at the end, of 5 whose inputs differ in the washout and are the same after it.

    1 is the echo-state property. Kept beside it are the conditional Lyapunov exponent per sample, where there is one,
    and the consistency.
    """

    metric: Metric = _ECHO_INDEX

    def attempt(self, reservoir: Reservoir, *, length: int, seed: int, washout: int) -> Solution:
        """Measure one reservoir as it is, on `length` bits.

        Raises
        ------
        ValueError
            If the washout is 0, so that all trajectories are one, or leaves fewer than two samples.
        """
        washout = whole_number("washout", washout, 1)
        length = whole_number("length", length, washout + 2)
        bits = random_bits(length, seed).astype(np.float64)
        starts = np.random.default_rng([seed, length]).integers(0, 2, (_STARTS, washout)).astype(np.float64)
        driven = [reservoir(np.concatenate([start, bits[washout:]]), seed)[washout - 1 :] for start in starts]
        return self.metric.solve(np.array(driven), bits, 0)


MEASURES: dict[str, Task] = {
    "information capacity": InformationCapacityOfBits(),
    f"kernel rank above {_THRESHOLD:g}": KernelRank("kernel"),
    f"generalisation rank above {_THRESHOLD:g}": KernelRank("generalisation"),
    "echo index": EchoIndex(),
}
"""The measures known by name, for the benchmark to run beside the `TASKS`. Add your own."""
