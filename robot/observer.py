"""What the environment would have shown a policy, from what the sensors of a robot tell."""

import math

import numpy as np
from numpy.typing import NDArray

from ..crawler.model.actuator import Actuator
from .sensors import Readings
from .slope import Slope

__all__ = ["STATE", "Observer"]

STATE = ("deformation", "velocity", "pressure", "foot_velocity")
"""What an observation begins with, in natural units; the valve's last states follow, the newest first."""

_BENT, _STRAIGHT = 2, 1  # degrees: the foot's rate has corners, that of the deformation has none


class Observer:
    """The observation of `StickSlipCrawlerEnv`, kept from reading to reading.

    Velocities that are not measured are slopes of the positions (`Slope`); a pressure that is not measured follows
    the valve with the actuator's lag, as in the model.

    Parameters
    ----------
    actuator : Actuator
        Whose units are natural.
    valve_history : int
        Valve states in the observation.
    ratchet : bool
        Whether the foot cannot go back: a slope that says so is noise.
    window : int
        Readings of a slope.
    """

    def __init__(self, actuator: Actuator, valve_history: int, *, ratchet: bool, window: int) -> None:
        scales = actuator.scales
        self._length, self._time, self._peak = scales.length, scales.time, scales.pressure
        self._lag, self._ratchet = actuator.lag, ratchet
        self._valves = [0] * valve_history
        self._stretching = Slope(window, min(_BENT, window - 1))
        self._going = Slope(window, _STRAIGHT)
        self._pressure, self._when = 0.0, 0.0  # as share of the peak, where it is not measured
        self._last = Readings(0.0, 0.0, 0.0, None, 0.0)

    def turned(self, valve: int, holds: int = 1) -> None:
        """Learn that the valve was put into a state, which it keeps for so many holds."""
        self._valves = ([valve] * holds + self._valves)[: len(self._valves)]

    def see(self, time: float, readings: Readings, valve: int) -> None:
        """Take a reading at a time, until which the valve was in a state."""
        self._stretching.add(time, readings.deformation)
        if readings.foot is not None:
            self._going.add(time, readings.foot)
        self._pressure = valve + (self._pressure - valve) * math.exp(-(time - self._when) / self._lag)
        self._when, self._last = time, readings

    @property
    def observation(self) -> NDArray[np.float32]:
        """After the last reading, as the environment's: dimensionless, in single precision."""
        deformation, velocity, pressure, _, foot_velocity = self._last
        if velocity is None:
            velocity = self._stretching.now
        if foot_velocity is None:
            foot_velocity = max(self._going.now, 0.0) if self._ratchet else self._going.now
        unit = self._length / self._time
        share = self._pressure if pressure is None else pressure / self._peak
        state = deformation / self._length, velocity / unit, share, foot_velocity / unit
        return np.array([*state, *self._valves], np.float32)
