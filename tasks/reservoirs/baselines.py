"""What the body is compared with: a shift register, and echo-state networks."""

from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...common.validation import finite_array, whole_number
from ...reservoir import delay_line, EchoStateNetwork
from .reservoir import Step

__all__ = ["DelayLine", "EchoState"]


@dataclass(frozen=True)
class DelayLine:
    """The shift register with so many taps: perfect memory, and no computation.

    Attributes
    ----------
    features : int, at least 1
    """

    features: int

    def __post_init__(self) -> None:
        whole_number("features", self.features, 1)

    def __call__(self, series: ArrayLike, seed: int = 0) -> NDArray[np.float64]:
        """States (samples, features) under `series` (samples,); nothing in it is random."""
        return delay_line(series, self.features)

    def stepper(self, series: ArrayLike, seed: int = 0) -> Step:
        """Go on from the end of a series."""
        taps = self(series, seed)[-1]

        def step(value: float) -> NDArray[np.float64]:
            nonlocal taps
            taps = np.concatenate([[value], taps[:-1]])
            return taps

        return step


_RADII = (0.5, 0.7, 0.9, 0.99)
_SCALINGS = (0.01, 0.05, 0.2, 1.0)


@dataclass(frozen=True)
class EchoState:
    """An echo-state network of so many nodes.

    Left at a default it is no fair baseline: what is best differs from task to task and from size to size. With `tune`
    it has `candidates`, of which the benchmark takes, for every task and seed, the one that does best within the
    training data.

    Attributes
    ----------
    features : int, at least 1
    spectral_radius, input_scaling : float
        As in `stickslip.reservoir.EchoStateNetwork`.
    tune : bool
        Whether the two are to be chosen.
    leak : float, in (0, 1]
        As in `stickslip.reservoir.EchoStateNetwork`.
    topology : {"random", "cycle", "orthogonal"}
        As in `stickslip.reservoir.EchoStateNetwork`: "cycle" is the simple cycle reservoir.
    centred : bool
        Whether the series u drives the network as 2 u - 1, so that tanh is odd about its middle.
    """

    features: int
    spectral_radius: float = 0.9
    input_scaling: float = 0.1
    tune: bool = False
    leak: float = 1.0
    topology: str = "random"
    centred: bool = False

    def __post_init__(self) -> None:
        self._network(0)

    @property
    def candidates(self) -> tuple["EchoState", ...]:
        """Networks of as many nodes over a grid of radii, input scalings and centred or not; none without `tune`."""
        if not self.tune:
            return ()
        return tuple(
            replace(self, spectral_radius=radius, input_scaling=scaling, centred=centred, tune=False)
            for radius, scaling, centred in product(_RADII, _SCALINGS, (False, True))
        )

    def __call__(self, series: ArrayLike, seed: int) -> NDArray[np.float64]:
        """States (samples, features) under `series` (samples,); the seed fixes the weights."""
        return self._network(seed).states(self._heard(finite_array("series", series, 1)))

    def stepper(self, series: ArrayLike, seed: int) -> Step:
        """Go on from the end of a series."""
        step = self._network(seed).stepper(self._heard(finite_array("series", series, 1)))
        return lambda value: step(self._heard(value))

    def _heard(self, series: Any) -> Any:
        return 2 * series - 1 if self.centred else series

    def _network(self, seed: int) -> EchoStateNetwork:
        return EchoStateNetwork(
            self.features,
            spectral_radius=self.spectral_radius,
            input_scaling=self.input_scaling,
            leak=self.leak,
            seed=seed,
            topology=self.topology,
        )
