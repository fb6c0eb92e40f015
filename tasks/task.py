"""What a task is: inputs from a seed, targets, a score, and samples that are not scored."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..common.validation import whole_number
from ..reservoir import Estimate, mean_over_runs, memory_capacity, MemoryCapacity, nrmse
from ..reservoir.ridge import samples_needed, training_samples
from .reservoirs import Reservoir

__all__ = [
    "ACCURACY",
    "CAPACITY",
    "DELAYS",
    "NRMSE",
    "Metric",
    "Problem",
    "SeriesTask",
    "Solution",
    "Task",
    "mean_score",
    "tuned",
]

DELAYS = 40
"""Delays over which capacities are summed."""

_HOLDOUT = 0.5

_BOUNDS = {
    "accuracy": (0.0, 1.0),
    "index": (1.0, math.inf),
    **dict.fromkeys(("NRMSE", "capacity", "rank", "valid time"), (0.0, math.inf)),
}
"""By the metric's name."""
_DIRECTIONS = ("capacity", "rank")
"""Metrics that count directions of the states, of which there are as many as features at most."""


class Solution(NamedTuple):
    """A score, and what it was made of where there is such a thing."""

    score: float
    prediction: NDArray[np.float64] | None = None  # of the held-out samples
    target: NDArray[np.float64] | None = None
    memory: MemoryCapacity | None = None
    details: dict[str, Any] | None = None  # what else was measured, ready for JSON


class Metric(NamedTuple):
    """A way to score states: a readout fitted on the first half of what is scored, and judged on the second."""

    name: str
    solve: Callable[[NDArray[np.float64], NDArray[np.float64], int], Solution]  # states, targets, samples left out
    more_is_better: bool
    chance: float  # what a reservoir scores that knows nothing

    @property
    def bounds(self) -> tuple[float, float] | None:
        """Between which the score always lies, for `mean_over_runs`; None where it is not known."""
        return _BOUNDS.get(self.name)

    def prefers(self, score: float, to: float) -> bool:
        """Whether one score is better than another."""
        return score > to if self.more_is_better else score < to


def _held_out(states: NDArray[np.float64], targets: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Prediction and target of the last half, by a readout whose penalty was chosen within the first, one left out."""
    # Imported where it is used: scikit-learn takes a second.
    from ..reservoir import RidgeReadout

    samples, features = states.shape
    if samples < (needed := samples_needed(features, _HOLDOUT)):
        raise ValueError(
            f"states must have at least {needed} samples for {features} features to be scored, got {samples}"
        )
    training = training_samples(samples, _HOLDOUT)
    readout = RidgeReadout().fit(states[:training], targets[:training])
    return readout.predict(states[training:]), targets[training:]


def _nrmse(states: NDArray[np.float64], targets: NDArray[np.float64], start: int) -> Solution:
    prediction, target = _held_out(states[start:], targets[start:])
    return Solution(nrmse(prediction, target), prediction, target)


def _accuracy(states: NDArray[np.float64], targets: NDArray[np.float64], start: int) -> Solution:
    prediction, target = _held_out(states[start:], targets[start:])
    return Solution(float(np.mean((prediction >= 0.5) == (target >= 0.5))), prediction, target)


def _capacity(states: NDArray[np.float64], targets: NDArray[np.float64], start: int) -> Solution:
    memory = memory_capacity(states, targets, DELAYS, washout=start)
    return Solution(memory.corrected, memory=memory)


NRMSE = Metric("NRMSE", _nrmse, more_is_better=False, chance=1.0)
"""Root-mean-square error over the target's standard deviation; 1 is what its mean scores."""

ACCURACY = Metric("accuracy", _accuracy, more_is_better=True, chance=0.5)
"""Share of held-out samples whose kind, 0 or 1, a linear readout tells; of two equally frequent ones."""

CAPACITY = Metric("capacity", _capacity, more_is_better=True, chance=0.0)
"""Corrected total of `memory_capacity` of the targets over delays 0 to ``DELAYS - 1``."""


@dataclass(frozen=True, eq=False)
class Problem:
    """One draw of a task.

    Attributes
    ----------
    drive : ndarray of shape (length,), in [0, 1]
        What drives a reservoir: the inputs, shifted and scaled by constants of the task.
    inputs : ndarray of shape (length,)
        In the task's own unit.
    targets : ndarray of shape (length,)
        Entry k is to be read out of the state that has absorbed entry k of the inputs and none after it.
    warm_up : int
        Samples at the start whose targets depend on what was before the inputs; they are never scored.
    """

    drive: NDArray[np.float64]
    inputs: NDArray[np.float64]
    targets: NDArray[np.float64]
    warm_up: int


class Task(Protocol):
    """What the benchmark runs."""

    @property
    def metric(self) -> Metric:
        """How it is scored."""
        ...

    def attempt(self, reservoir: Reservoir, *, length: int, seed: int, washout: int) -> Solution:
        """Score one reservoir on one draw."""
        ...


@dataclass(frozen=True)
class SeriesTask:
    """A series drives the reservoir, and another is to be read out of its states.

    Attributes
    ----------
    draw : callable
        Takes a length and a seed, gives a :class:`Problem`.
    metric : Metric
    """

    draw: Callable[[int, int], Problem]
    metric: Metric

    def drive(self, length: int, seed: int) -> NDArray[np.float64]:
        """What an attempt drives its reservoir by."""
        return _drawn(self.draw, length, seed).drive

    def attempt(self, reservoir: Reservoir, *, length: int, seed: int, washout: int) -> Solution:
        """Score one reservoir on one draw.

        Parameters
        ----------
        reservoir : Reservoir
            Starts at rest. One with `candidates` is tuned first, on the samples that its readout is fitted on.
        length : int, at least 1
            Samples.
        seed : int, at least 0
            Of the inputs, and of what is random in the reservoir.
        washout : int, at least 0
            Samples at the start that are not scored; the problem's `warm_up` where that is more.

        Returns
        -------
        Solution

        Raises
        ------
        TypeError, ValueError
            If an argument is invalid, or the length too short for the washout, the delays and the features.
        """
        problem = _drawn(self.draw, length, seed)
        start = max(whole_number("washout", washout, 0), problem.warm_up)
        if length <= start:
            raise ValueError(
                f"length must be more than the {start} samples that are washed out or warm up, got {length}"
            )
        training = start + (length - start) // 2

        def validation(candidate: Reservoir) -> float:
            states = candidate(problem.drive, seed)
            return self.metric.solve(states[:training], problem.targets[:training], start).score

        best = tuned(reservoir, validation, self.metric)
        return self.metric.solve(best(problem.drive, seed), problem.targets, start)


def mean_score(task: Task, scores: Sequence[float], features: int | None = None) -> Estimate:
    """Average a task's scores over seeds, with an interval that keeps to where the true mean can lie.

    Parameters
    ----------
    task : Task
    scores : sequence of float
        Two at least.
    features : int, optional
        Of the reservoir: no capacity and no rank is more.

    Returns
    -------
    Estimate

    Raises
    ------
    ValueError
        As in `mean_over_runs`.
    """
    if task.metric.bounds is None:
        return mean_over_runs(scores)
    least, most = task.metric.bounds
    most = min(most, getattr(task, "horizon", math.inf))
    if features is not None and task.metric.name in _DIRECTIONS:
        most = min(most, features)
    # Chance may put the estimate of one seed, and rarely their mean, beyond what can be true.
    found = mean_over_runs(scores, bounds=(least, max(most, *scores)))
    return found.at_most(most)


@lru_cache(maxsize=32)
def _drawn(draw: Callable[[int, int], Problem], length: int, seed: int) -> Problem:
    """A draw, made once for the reservoirs that share it, none of which may write to it."""
    problem = draw(length, seed)
    for array in (problem.drive, problem.inputs, problem.targets):
        array.flags.writeable = False
    return problem


def tuned(reservoir: Reservoir, validation: Callable[[Reservoir], float], metric: Metric) -> Reservoir:
    """The best of a reservoir's candidates, or the reservoir itself where it has none.

    Parameters
    ----------
    reservoir : Reservoir
    validation : callable
        Scores a candidate without the data that the reservoir is judged on.
    metric : Metric
        Which score is better.

    Returns
    -------
    Reservoir
    """
    candidates: Sequence[Reservoir] = getattr(reservoir, "candidates", ())
    best, reached = reservoir, None
    for candidate in candidates:
        score = validation(candidate)
        if reached is None or metric.prefers(score, reached):
            best, reached = candidate, score
    return best
