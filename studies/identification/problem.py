"""How far bodies are from measurements: weighted residuals of whole runs, and their slopes.

The slopes are the sensitivities that ride along through every slip and stop (`stickslip.sensitivities`); of a chain of
segments, differences of neighbours in one batch.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...crawler import Scene, SolverError
from ...crawler.model.tube import is_chain
from .coordinates import Coordinates
from .measurements import Measurements
from .prediction import Body, predicted, slopes_of

__all__ = ["Problem"]

_STEP = 1e-5  # of differences, in units of the guess
_HUGE = 1e6  # residual of a body that cannot be simulated


class Problem:
    """Least squares of runs at points of the coordinates, each channel weighed by its errors."""

    def __init__(
        self, runs: Sequence[Measurements], guess: Body, names: tuple[str, ...], scene: Scene, tolerance: float
    ) -> None:
        self.runs, self.scene, self.tolerance = runs, scene, tolerance
        self.coordinates = Coordinates(guess, names)
        self.errors = {name: self._spread(name) for name in self._measured}
        self.samples = sum(int(np.isfinite(getattr(run, name)).sum()) for run in runs for name in run.measured)

    @property
    def _measured(self) -> list[str]:
        return list(dict.fromkeys(name for run in self.runs for name in run.measured))

    def _spread(self, name: str) -> float:
        """Standard deviation of a channel, to weigh it by until its errors are known."""
        values = [getattr(run, name) for run in self.runs if name in run.measured]
        spread = float(np.sqrt(np.mean([np.nanvar(each) for each in values])))
        return spread or 1.0

    def residuals(self, points: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """What is left of the first holds of every run, in units of the errors: (points, samples)."""
        bodies = [self.coordinates.body(point) for point in points]
        parts = []
        for whole in self.runs:
            run = whole.until(holds)
            for name, values in predicted(bodies, run, self.scene, self.tolerance).items():
                told = np.isfinite(getattr(run, name))
                left = (values[:, told] - getattr(run, name)[told]) / self.errors[name]
                parts.append(np.nan_to_num(left, nan=_HUGE, posinf=_HUGE, neginf=-_HUGE))
        return np.concatenate(parts, axis=1)

    def costs(self, points: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """Mean square of what is left; inf where the body cannot be simulated."""
        costs = np.mean(self.residuals(points, holds) ** 2, axis=1)
        return np.where(costs < 1e-3 * _HUGE**2, costs, np.inf)

    def slopes(self, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """Slopes of the residuals in the parameters, (samples, free)."""
        if is_chain(self.scene):
            return self._differences(point, holds)
        parts, body = [], self.coordinates.body(point)
        try:
            for whole in self.runs:
                run = whole.until(holds)
                for name, slopes in slopes_of(body, run, self.scene, self.tolerance, self.coordinates.names).items():
                    parts.append(slopes[np.isfinite(getattr(run, name))] / self.errors[name])
        except SolverError:  # where the residuals are those of no body, which has no slopes
            return self._differences(point, holds)
        return np.concatenate(parts) @ self.coordinates.turned(point)

    def _differences(self, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """The same by central differences of bodies in one batch."""
        low, high = self.coordinates.bounds()
        ahead = np.minimum(point + _STEP, high)
        behind = np.maximum(point - _STEP, low)
        n = len(point)
        points = np.tile(point, (2 * n, 1))
        points[np.arange(n), np.arange(n)] = ahead
        points[n + np.arange(n), np.arange(n)] = behind
        left = self.residuals(points, holds)
        return ((left[:n] - left[n:]) / (ahead - behind)[:, np.newaxis]).T

    def structure(self, point: NDArray[np.float64]) -> float:
        """Correlation of what is left from one sample to the next, the largest of all channels, in standard errors."""
        found = [0.0]
        for run in self.runs:
            for name, values in predicted([self.coordinates.body(point)], run, self.scene, self.tolerance).items():
                left = values[0] - getattr(run, name)
                products = left[1:] * left[:-1]
                told = np.isfinite(products)
                if told.any():
                    found.append(float(products[told].mean() / np.nanmean(left**2) * np.sqrt(told.sum())))
        return max(found)

    def weigh(self, point: NDArray[np.float64]) -> None:
        """Take the errors of the channels from what a body leaves of them."""
        self.errors = {name: left or 1.0 for name, left in self.left(point).items()}

    def left(self, point: NDArray[np.float64]) -> dict[str, float]:
        """Root mean square of what a body leaves of each channel."""
        squares: dict[str, list[NDArray[np.float64]]] = {name: [] for name in self._measured}
        for run in self.runs:
            for name, values in predicted([self.coordinates.body(point)], run, self.scene, self.tolerance).items():
                squares[name].append((values[0] - getattr(run, name)) ** 2)
        return {name: float(np.sqrt(np.nanmean(np.concatenate(each)))) for name, each in squares.items()}
