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
        self._state = np.zeros(len(STATE))

    def turned(self, valve: int, holds: int = 1) -> None:
        """Learn that the valve was put into a state, which it keeps for so many holds."""
        self._valves = ([valve] * holds + self._valves)[: len(self._valves)]

    def see(self, time: float, readings: Readings, valve: int) -> None:
        """Take a reading at a time, until which the valve was in a state."""
        unit = self._length / self._time
        self._stretching.add(time, readings.deformation)
        if readings.foot is not None:
            self._going.add(time, readings.foot)
        velocity = self._stretching.now if readings.velocity is None else readings.velocity
        foot_velocity = readings.foot_velocity
        if foot_velocity is None:
            foot_velocity = max(self._going.now, 0.0) if self._ratchet else self._going.now
        self._pressure = valve + (self._pressure - valve) * math.exp(-(time - self._when) / self._lag)
        self._when = time
        pressure = self._pressure if readings.pressure is None else readings.pressure / self._peak
        self._state[:] = readings.deformation / self._length, velocity / unit, pressure, foot_velocity / unit

    @property
    def observation(self) -> NDArray[np.float32]:
        """After the last reading, as the environment's: dimensionless, in single precision."""
        return np.array([*self._state, *self._valves], np.float32)
