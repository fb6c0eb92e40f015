"""How far bodies are from measurements: weighted residuals of whole runs, and their slopes.

The slopes are the sensitivities that ride along through every slip and stop (`stickslip.sensitivities`); of a chain of
segments, differences of neighbours in one batch.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ...crawler import Scene, SolverError
from ...crawler.model.tube import is_chain
from .coordinates import Coordinates
from .measurements import Measurements
from .prediction import predicted, slopes_of

__all__ = ["Problem", "mean_squares"]

_STEP = 1e-5  # of differences, in units of the guess
_HUGE = 1e6  # residual of a body that cannot be simulated


@dataclass(frozen=True, eq=False)
class Problem:
    """Least squares of runs at points of the coordinates.

    Attributes
    ----------
    runs : tuple of Measurements
    coordinates : Coordinates
    scene : Scene
    tolerance : float
        Of `simulate`.
    errors : dict of str to float
        Of each channel, which is weighed by them.
    """

    runs: tuple[Measurements, ...]
    coordinates: Coordinates
    scene: Scene
    tolerance: float
    errors: dict[str, float]

    @classmethod
    def of(cls, runs: Sequence[Measurements], coordinates: Coordinates, scene: Scene, tolerance: float) -> Self:
        """A problem whose channels are weighed by their standard deviations until their errors are known."""
        names = dict.fromkeys(name for run in runs for name in run.measured)
        errors = {}
        for name in names:
            values = [getattr(run, name) for run in runs if name in run.measured]
            errors[name] = float(np.sqrt(np.mean([np.nanvar(each) for each in values]))) or 1.0
        return cls(tuple(runs), coordinates, scene, tolerance, errors)

    @property
    def holds(self) -> int:
        """Of the longest run."""
        return max(run.valve.size for run in self.runs)

    @property
    def samples(self) -> int:
        """Numbers that were measured."""
        return sum(int(np.isfinite(getattr(run, name)).sum()) for run in self.runs for name in run.measured)

    def until(self, holds: int) -> Self:
        """The problem of the first holds of every run, or of more, where these have no more samples than are free."""
        part = replace(self, runs=tuple(each for run in self.runs if (each := run.until(holds)) is not None))
        enough = part.samples > len(self.coordinates.names) or holds >= self.holds
        return part if enough else self.until(2 * holds)

    def weighed(self, point: NDArray[np.float64]) -> Self:
        """The problem with the errors of the channels taken from what the body at a point leaves of them."""
        return replace(self, errors={name: left or 1.0 for name, left in self.noise(point).items()})

    def residuals(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """What bodies leave of every run, in units of the errors: (points, samples)."""
        bodies = [self.coordinates.body(point) for point in points]
        parts = []
        for run in self.runs:
            for name, values in predicted(bodies, run, self.scene, self.tolerance).items():
                told = np.isfinite(getattr(run, name))
                left = (values[:, told] - getattr(run, name)[told]) / self.errors[name]
                parts.append(np.nan_to_num(left, nan=_HUGE, posinf=_HUGE, neginf=-_HUGE))
        return np.concatenate(parts, axis=1)

    def slopes(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """Slopes of the residuals in the coordinates, (samples, free)."""
        if is_chain(self.scene):
            return self._differences(point)
        parts, body = [], self.coordinates.body(point)
        try:
            for run in self.runs:
                slopes_of_run = slopes_of(body, run, self.scene, self.tolerance, self.coordinates.names)
                for name, slopes in slopes_of_run.items():
                    parts.append(slopes[np.isfinite(getattr(run, name))] / self.errors[name])
        except SolverError:  # where the residuals are those of no body, which has no slopes
            return self._differences(point)
        return np.concatenate(parts) @ self.coordinates.jacobian(point)

    def _differences(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same by central differences of bodies in one batch."""
        low, high = self.coordinates.bounds()
        ahead = np.minimum(point + _STEP, high)
        behind = np.maximum(point - _STEP, low)
        n = len(point)
        points = np.tile(point, (2 * n, 1))
        points[np.arange(n), np.arange(n)] = ahead
        points[n + np.arange(n), np.arange(n)] = behind
        left = self.residuals(points)
        return ((left[:n] - left[n:]) / (ahead - behind)[:, np.newaxis]).T

    def noise(self, point: NDArray[np.float64]) -> dict[str, float]:
        """Root mean square of what the body at a point leaves of each channel."""
        squares: dict[str, list[NDArray[np.float64]]] = {name: [] for name in self.errors}
        for name, left in self._left(point):
            squares[name].append(left**2)
        return {name: float(np.sqrt(np.nanmean(np.concatenate(each)))) for name, each in squares.items()}

    def structure(self, point: NDArray[np.float64]) -> float:
        """Correlation of what is left from one sample to the next, the largest of all channels, in standard errors."""
        found = [0.0]
        for _, left in self._left(point):
            products = left[1:] * left[:-1]
            told = np.isfinite(products)
            if told.any():
                found.append(float(products[told].mean() / np.nanmean(left**2) * np.sqrt(told.sum())))
        return max(found)

    def _left(self, point: NDArray[np.float64]) -> Iterator[tuple[str, NDArray[np.float64]]]:
        """What the body at a point leaves of each channel of each run, unweighted, NaN in gaps."""
        for run in self.runs:
            for name, values in predicted([self.coordinates.body(point)], run, self.scene, self.tolerance).items():
                yield name, values[0] - getattr(run, name)


def mean_squares(residuals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean square of the residuals of each body, (...) of (..., samples); inf where it cannot be simulated."""
    found: NDArray[np.float64] = np.mean(residuals**2, axis=-1)
    return np.where(found < 1e-3 * _HUGE**2, found, np.inf)
