"""Whether trajectories from many starts meet under one input: echo index, consistency and Lyapunov exponent."""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within, whole_number

Array = NDArray[np.float64]

# Distances, in units of the states' spread, between which they grow or shrink as a linear system's would: above, they
# saturate; below, they are rounding.
_LINEAR, _ROUNDING = 0.01, 1e-11
# Least number of steps in that range from which a rate is told.
_STEPS = 10


@dataclass(frozen=True, eq=False)
class EchoStateProperty:
    """Whether a driven system forgets where it started.

    Attributes
    ----------
    echo_index : int
        Trajectories that are still apart at the end, those within `tolerance` of each other counting as one [1]_. 1 is
        the echo-state property, as far as these starts, this input and this length can tell.
    distance : ndarray of shape (samples,)
        The largest between two trajectories at each sample, in units of the states' spread.
    consistency : float
        Mean correlation between the same feature in two trajectories, over pairs and features, without the washout
        [2]_. 1 if all respond alike.
    exponent : float
        Conditional Lyapunov exponent per sample: mean rate at which neighbours part, negative if they meet. Not a
        number if they were never both close enough to count and far enough to be told apart.
    exponent_error : float
        Its standard error.
    """

    echo_index: int
    distance: Array
    consistency: float
    exponent: float
    exponent_error: float


def echo_state_property(states: ArrayLike, *, washout: int = 0, tolerance: float = 1e-3) -> EchoStateProperty:
    """Compare trajectories that start apart and are driven by one input.

    Distances are Euclidean over the features, each in units of its standard deviation over samples and trajectories,
    divided by the square root of the number of features.

    The exponent is the mean growth of the logarithm of the distance to the first trajectory, while that distance is
    for the first time between the rounding of the states (1e-11) and a hundredth of their spread. There the difference
    obeys the linearized equations, and turns of itself towards the direction that grows most or shrinks least. So it
    is had from starts that are far apart, if they meet, and from starts that are close, if they part. To measure
    chaos, start within 1e-8 of each other; it is over after ``ln(1e6) / exponent`` samples, so the error is large.

    Parameters
    ----------
    states : array_like of shape (starts, samples, features)
        At least two starts.
    washout : int
        Samples at the start that consistency leaves out. Distances and the exponent need them.
    tolerance : float, in (0, inf)
        Distance up to which trajectories count as met, in units of the states' spread.

    Returns
    -------
    EchoStateProperty

    Raises
    ------
    ValueError
        If `states` has a wrong shape or is not finite, the washout leaves fewer than two samples, or no state ever
        moves.

    Warns
    -----
    UserWarning
        If there was too little to tell the exponent from; it is then not a number.

    References
    ----------
    .. [1] A. Ceni, P. Ashwin, L. Livi and C. Postlethwaite, "The echo index and multistability in input-driven
       recurrent neural networks", Physica D 412, 132609, 2020.
    .. [2] A. Uchida, R. McAllister and R. Roy, "Consistency of nonlinear system response to complex drive signals",
       Physical Review Letters 93, 244102, 2004.
    """
    # Imported where it is used: it takes a fifth of a second, and whoever only steps an environment needs none of it.
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import pdist

    x = finite_array("states", states, 3)
    starts, samples, _ = x.shape
    washout = whole_number("washout", washout, 0)
    tolerance = number_within("tolerance", tolerance, "(0, inf)")
    if starts < 2:
        raise ValueError(f"states must hold two starts at least, got {starts}")
    if samples < washout + 2:
        raise ValueError(f"states must have at least {washout + 2} samples for washout={washout}, got {samples}")
    moved = x - x[0, 0]
    spread = moved.std(axis=(0, 1))
    moving = spread > 0
    if not moving.any():
        raise ValueError("states must move, or there is nothing to compare, got constants throughout")
    scaled = moved[:, :, moving] / (spread[moving] * np.sqrt(moving.sum()))

    pairs = np.array([pdist(scaled[:, sample]) for sample in range(samples)])
    exponent, error = _exponent(np.linalg.norm(scaled[1:] - scaled[0], axis=2))
    if np.isnan(exponent):
        warnings.warn(
            f"fewer than {_STEPS} samples have distances between rounding and a hundredth of the states' spread: no "
            f"Lyapunov exponent can be told from them",
            stacklevel=2,
        )
    return EchoStateProperty(
        echo_index=int(fcluster(linkage(pairs[-1], "single"), tolerance, "distance").max()),
        distance=pairs.max(axis=1),
        consistency=_consistency(scaled[:, washout:]),
        exponent=exponent,
        exponent_error=error,
    )


def _exponent(distance: Array) -> tuple[float, float]:
    """Mean and standard error of the growth of ``log(distance)``, of shape (pairs, samples), in the linear range."""
    before, after = distance[:, :-1], distance[:, 1:]
    linear = (before > _ROUNDING) & (before < _LINEAR) & (after > 0)
    # The step that leaves the range counts: without it the large ones would be missing, and the mean too small (Wald's
    # identity). Whoever has left and comes back does so by chance, and at places where neighbours are about to part.
    left = np.logical_or.accumulate(~linear & np.logical_or.accumulate(linear, axis=1), axis=1)
    counted = linear & ~left
    if counted.sum() < _STEPS:
        return float("nan"), float("nan")
    growth = np.log(np.divide(after, before, out=np.ones_like(after), where=counted))
    # All pairs are driven by one input, so that they are no independent witnesses of it: what counts is its samples.
    pairs = counted.sum(axis=0)
    at_samples = growth.sum(axis=0)[pairs > 0] / pairs[pairs > 0]
    error = at_samples.std(ddof=1) / np.sqrt(len(at_samples)) if len(at_samples) > 1 else np.nan
    return float(growth.sum() / counted.sum()), float(error)


def _consistency(scaled: Array) -> float:
    moved = scaled - scaled.mean(axis=1, keepdims=True)
    norms = np.linalg.norm(moved, axis=1)
    # A feature that stands still in one trajectory has no correlation; it says nothing of consistency.
    moving = (norms > 0).all(axis=0)
    if not moving.any():
        return float("nan")
    unit = moved[:, :, moving] / norms[:, None, moving]
    starts = len(unit)
    # The mean over pairs, from the square of the sum.
    together = (unit.sum(axis=0) ** 2).sum(axis=0)
    return float(np.mean((together - starts) / (starts * (starts - 1))))
