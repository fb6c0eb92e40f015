"""A policy on a real valve: sensors in SI units in, valve states out, at a fixed rate.

It needs NumPy, and safetensors for a policy's file; the simulator only for `SimulatedPlant`.
"""

from .clock import Clock, RealClock, VirtualClock
from .plant import SimulatedPlant
from .report import Report
from .runner import Runner
from .sensors import SensorError, SENSORS

__all__ = [
    "SENSORS",
    "Clock",
    "RealClock",
    "Report",
    "Runner",
    "SensorError",
    "SimulatedPlant",
    "VirtualClock",
]
