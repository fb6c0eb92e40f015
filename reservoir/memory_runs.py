"""Memory capacity over independent runs."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .bootstrap import Estimate, mean_over_runs
from .delayed import Delays
from .memory import MemoryCapacity
from .orthonormal import Array


@dataclass(frozen=True, eq=False)
class MemoryOverRuns:
    """The memory of a reservoir over independent runs.

    Attributes
    ----------
    delays : ndarray of shape (delays,)
    profile : ndarray of shape (delays,)
        Mean capacity at each delay.
    profile_interval : ndarray of shape (2, delays)
    total, corrected : Estimate
        Means of the totals, with their intervals.
    bound : int
        The largest.
    """

    delays: Delays
    profile: Array
    profile_interval: Array
    total: Estimate
    corrected: Estimate
    bound: int


def memory_over_runs(memories: Sequence[MemoryCapacity], confidence: float = 0.95) -> MemoryOverRuns:
    """Combine runs that differ in their seeds alone.

    Parameters
    ----------
    memories : sequence of MemoryCapacity
        Two at least, over the same delays. Their own intervals are not used: what differs within a run differs
        between runs too.
    confidence : float, in (0, 1)

    Returns
    -------
    MemoryOverRuns

    Raises
    ------
    ValueError
        If there are fewer than two runs, or their delays differ.
    """
    runs = list(memories)
    for run in runs:
        if not np.array_equal(run.delays, runs[0].delays):
            raise ValueError(f"memories must share their delays, got {runs[0].delays} and {run.delays}")
    sums = (0.0, float(len(runs[0].delays)) if runs else math.inf)
    bound = max((run.bound for run in runs), default=0)
    corrected = mean_over_runs([run.corrected for run in runs], confidence, bounds=sums)
    total = mean_over_runs([run.total for run in runs], confidence, bounds=sums)
    profiles = np.transpose([run.profile for run in runs])
    at_delays = [mean_over_runs(values, confidence, bounds=(0.0, 1.0)) for values in profiles]
    # Less what chance adds, a total is no more than the rank.
    return MemoryOverRuns(
        delays=runs[0].delays.copy(),
        profile=np.array([at.mean for at in at_delays]),
        profile_interval=np.array([[at.low for at in at_delays], [at.high for at in at_delays]]),
        total=total,
        corrected=corrected.at_most(bound),
        bound=bound,
    )
