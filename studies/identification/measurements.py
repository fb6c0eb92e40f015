"""What was measured of a crawler while its valve was driven."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ...common.validation import finite_array, known_names, number_within, whole_number
from ...crawler import Groups, Trajectory
from ...crawler.model.channels import CHANNEL_UNITS

__all__ = ["CHANNELS", "Measurements", "several"]

CHANNELS = tuple(CHANNEL_UNITS)
"""What may be measured; each is an attribute of `Measurements` and of `Trajectory`."""


@dataclass(frozen=True, eq=False)
class Measurements:
    """One run that began at rest, in natural units or in SI.

    Parameters
    ----------
    valve : (holds,) array_like, in [0, 1]
        Duty cycle of the valve in each hold.
    hold : float
        Length of a hold, > 0.
    samples_per_hold : int, optional
        If samples are equally spaced, the last at the end of each hold, as in `simulate`.
    times : (samples,) array_like, optional
        Else: when the samples were taken, from 0 to the end, in ascending order.
    deformation, velocity, pressure, foot, foot_velocity, payload : (samples,) array_like, optional
        Those that were measured. NaN is a gap.

    Raises
    ------
    ValueError, TypeError
        If a number is out of range, both or neither of `samples_per_hold` and `times` are given, nothing was measured,
        or a channel has another number of samples than there are times; the message names it.
    """

    valve: NDArray[np.float64]
    hold: float
    samples_per_hold: int | None = None
    times: Any = None
    deformation: NDArray[np.float64] | None = None
    velocity: NDArray[np.float64] | None = None
    pressure: NDArray[np.float64] | None = None
    foot: NDArray[np.float64] | None = None
    foot_velocity: NDArray[np.float64] | None = None
    payload: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        valve = finite_array("valve", self.valve, 1)
        if valve.min() < 0.0 or valve.max() > 1.0:
            raise ValueError(f"valve must be in [0, 1], got {valve.min()} to {valve.max()}")
        hold = number_within("hold", self.hold, "(0, inf)")
        if (self.samples_per_hold is None) == (self.times is None):
            raise ValueError("samples_per_hold or times must be given, and not both")
        times: NDArray[np.float64]
        if self.samples_per_hold is not None:
            count = whole_number("samples_per_hold", self.samples_per_hold, 1)
            fractions = np.arange(1, count + 1) / count
            times = ((np.arange(valve.size)[:, np.newaxis] + fractions) * hold).ravel()
        else:
            times, end = finite_array("times", self.times, 1), valve.size * hold
            if np.any(np.diff(times) <= 0.0) or times[0] < 0.0 or times[-1] > end * (1.0 + 1e-12):
                raise ValueError(f"times must ascend from 0 or later to {end!r} or earlier, got {times}")
        for name, value in {"valve": valve, "hold": hold, "times": times}.items():
            object.__setattr__(self, name, value)
        if not self.measured:
            raise ValueError(f"one of {', '.join(CHANNELS)} must have been measured, got none")
        for name in self.measured:
            object.__setattr__(self, name, self._channel(name))

    def _channel(self, name: str) -> NDArray[np.float64]:
        """The samples of a channel, checked."""
        try:
            values: NDArray[np.float64] = np.asarray(getattr(self, name), dtype=np.float64)
        except (TypeError, ValueError):
            raise TypeError(f"{name} must be an array of real numbers, got {getattr(self, name)!r}") from None
        if values.shape != self.times.shape:
            raise ValueError(f"{name} must have {self.times.size} samples, one a time, got shape {values.shape}")
        if np.isinf(values).any() or np.isnan(values).all():
            raise ValueError(f"{name} must be finite but for gaps, which are NaN, got {values}")
        return values

    @property
    def measured(self) -> tuple[str, ...]:
        """Names of the channels that were measured."""
        return tuple(name for name in CHANNELS if getattr(self, name) is not None)

    @classmethod
    def of(
        cls,
        trajectory: Trajectory,
        *channels: str,
        noise: float = 0.0,
        seed: int = 0,
    ) -> Self:
        """What instruments would have told of a simulated run of one crawler.

        Parameters
        ----------
        trajectory : Trajectory
            Of one crawler from rest.
        *channels : str
            Of `CHANNELS`.
        noise : float
            Standard deviation of Gaussian errors, of that of the channel; of a position, of that of the deformation.
        seed : int
            Of the errors.

        Returns
        -------
        Measurements

        Raises
        ------
        ValueError, TypeError
            If an argument is out of range, or the trajectory is of several crawlers or does not begin at rest.
        """
        number_within("noise", noise, "[0, inf)")
        known_names("channels", channels, CHANNELS)
        if not isinstance(trajectory.groups, Groups):
            raise ValueError(f"trajectory must be of one crawler, got {len(trajectory.groups)}")
        if any(np.any(value) for value in trajectory.initial):
            raise ValueError(f"trajectory must begin at rest, got one from {trajectory.initial}")
        generator = np.random.default_rng(whole_number("seed", seed, 0))
        told: dict[str, Any] = {}
        for name in channels:
            exact = np.asarray(getattr(trajectory, name))
            spread = np.std(trajectory.deformation if name in ("foot", "payload") else exact)
            told[name] = exact + noise * spread * generator.standard_normal(exact.size)
        return cls(trajectory.valve, trajectory.hold, trajectory.time.size // trajectory.valve.size, **told)

    def until(self, holds: int) -> Self | None:
        """The first `holds` of the run, without the channels that are a gap all through them; None if all are."""
        if holds >= self.valve.size:
            return self
        inside = self.times <= holds * self.hold * (1.0 + 1e-12)
        told = {name: getattr(self, name)[inside] for name in self.measured}
        told = {name: values for name, values in told.items() if np.isfinite(values).any()}
        times = self.times[inside] if self.samples_per_hold is None else None
        return type(self)(self.valve[:holds], self.hold, self.samples_per_hold, times, **told) if told else None


def several(measurements: Measurements | Sequence[Measurements]) -> list[Measurements]:
    """One run or a sequence of them, as a list."""
    runs = list(measurements) if isinstance(measurements, Sequence) else [measurements]
    if not runs or not all(isinstance(run, Measurements) for run in runs):
        raise TypeError(f"measurements must be Measurements or a sequence of them, got {measurements!r}")
    return runs
