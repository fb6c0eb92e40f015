"""Chaotic series foretold in a closed loop: the reservoir hears its own prediction, as long as it holds."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.validation import number_within, whole_number
from .reservoirs import Reservoir, Step
from .task import Metric, Solution, tuned

__all__ = ["VALID_TIME", "ClosedLoopTask", "stepper"]

_Array = NDArray[np.float64]


def stepper(reservoir: Reservoir, series: _Array, seed: int) -> Step:
    """Step a reservoir on from the end of a series.

    Parameters
    ----------
    reservoir : Reservoir
        One without a `stepper` of its own is driven anew by the whole series at every step.
    series : ndarray of shape (samples,), in [0, 1]
    seed : int

    Returns
    -------
    Step
    """
    own: Callable[[_Array, int], Step] | None = getattr(reservoir, "stepper", None)
    if own is not None:
        return own(series, seed)
    heard = list(series)

    def step(value: float) -> _Array:
        heard.append(value)
        states: _Array = reservoir(np.array(heard), seed)[-1]
        return states

    return step


def _mean(valid: _Array, _: _Array, start: int) -> Solution:
    return Solution(float(valid.mean()), details={"valid times": valid.ravel().tolist()})


VALID_TIME = Metric("valid time", _mean, more_is_better=True, chance=0.0)
"""Mean valid prediction time of some forecasts, in Lyapunov times: in each the distance of two motions grows by e."""


@dataclass(frozen=True)
class ClosedLoopTask:
    """A series to be foretold by a reservoir that hears its own predictions [1]_.

    A linear readout is fitted to tell the next sample of the first half of what the washout leaves, while a little
    noise on what the reservoir hears teaches it to come back to the series [2]_. In the second half some forecasts
    begin, evenly spaced: up to there the series drives the reservoir, from there on the readout, clipped to [0, 1].
    A forecast is valid as long as it is off by no more than `tolerance` of the series' standard deviation.

    Attributes
    ----------
    draw : callable
        Takes a length and a seed, gives a series in [0, 1].
    exponent : float, in (0, inf)
        Largest Lyapunov exponent of the series, per sample.
    forecasts : int, at least 1
    horizon : float, in (0, inf)
        Lyapunov times after which a forecast ends. A valid time is no more; where the length is too short, half of what
        is foretold in.
    tolerance : float, in (0, inf)
        0.4 is usual [1]_.
    noise : float, in [0, inf)
        Its standard deviation while the readout is fitted, in those of the series. Without it a network of 300 nodes
        errs by 1e-6 a sample at Lorenz's x, and its loop leaves the attractor within one Lyapunov time.

    Raises
    ------
    TypeError, ValueError
        If an attribute is invalid.

    References
    ----------
    .. [1] J. Pathak, A. Wikner, R. Fussell, S. Chandra, B. R. Hunt, M. Girvan and E. Ott, "Hybrid forecasting of
       chaotic processes: using machine learning in conjunction with a knowledge-based model", Chaos 28, 041101, 2018.
    .. [2] H. Jaeger and H. Haas, "Harnessing nonlinearity: predicting chaotic systems and saving energy in wireless
       communication", Science 304, 78, 2004.
    """

    draw: Callable[[int, int], _Array]
    exponent: float
    forecasts: int = 10
    horizon: float = 8.0
    tolerance: float = 0.4
    noise: float = 1e-4

    metric: Metric = VALID_TIME

    def __post_init__(self) -> None:
        whole_number("forecasts", self.forecasts, 1)
        for name in ("exponent", "horizon", "tolerance"):
            number_within(name, getattr(self, name), "(0, inf)")
        number_within("noise", self.noise, "[0, inf)")

    def attempt(self, reservoir: Reservoir, *, length: int, seed: int, washout: int) -> Solution:
        """Score one reservoir on one draw.

        Parameters
        ----------
        reservoir : Reservoir
            Starts at rest. One with `candidates` is tuned first: each foretells the second half of the samples that the
            readout is fitted on from the first.
        length : int, at least 1
            Samples.
        seed : int, at least 0
            Of the series, and of what is random in the reservoir.
        washout : int, at least 0
            Samples at the start that the readout is not fitted on.

        Returns
        -------
        Solution
            The mean valid time in Lyapunov times; that of each forecast is among the details.

        Raises
        ------
        TypeError, ValueError
            If an argument is invalid, or the length too short for the washout and the features.
        """
        start = whole_number("washout", washout, 0)
        length = whole_number("length", length, start + 8)
        series = self.draw(length, seed)
        training = start + (length - start) // 2

        def validation(candidate: Reservoir) -> float:
            return self._foretold(candidate, series[:training], start, start + (training - start) // 2, seed).score

        best = tuned(reservoir, validation, self.metric)
        return self._foretold(best, series, start, training, seed)

    def _foretold(self, reservoir: Reservoir, series: _Array, start: int, training: int, seed: int) -> Solution:
        # Imported where it is used: scikit-learn takes a second.
        from ..reservoir import RidgeReadout

        heard = series[: training - 1]
        random = np.random.default_rng([seed, len(series)])
        noisy = np.clip(heard + self.noise * series.std() * random.standard_normal(len(heard)), 0.0, 1.0)
        readout = RidgeReadout().fit(reservoir(noisy, seed)[start:], series[start + 1 : training])
        samples = min(math.ceil(self.horizon / self.exponent), max(1, (len(series) - training) // 2))
        begins = np.linspace(training, len(series) - samples, self.forecasts).round().astype(int)
        weights, constant = np.ravel(readout.coef_), float(np.ravel(readout.intercept_)[0])
        valid = [
            _valid_samples(
                stepper(reservoir, series[: begin - 1], seed),
                lambda states: float(states @ weights) + constant,
                series[begin - 1 : begin + samples],
                self.tolerance * float(series.std()),
            )
            for begin in begins.tolist()
        ]
        return self.metric.solve(self.exponent * np.array(valid, dtype=np.float64)[:, None], series, 0)


def _valid_samples(step: Step, read: Callable[[_Array], float], truth: _Array, tolerance: float) -> int:
    """For how many samples a closed loop stays within a tolerance of the truth, whose first sample it is given."""
    value = float(truth[0])
    for count, true in enumerate(truth[1:].tolist()):
        value = min(1.0, max(0.0, read(step(value))))
        if not abs(value - true) <= tolerance:
            return count
    return len(truth) - 1
