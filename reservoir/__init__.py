"""Reservoir computing on arrays: readouts, memory, and reference reservoirs. Knows no crawler."""

from .delay_line import delay_line
from .echo_state import EchoStateNetwork
from .memory import memory_capacity, MemoryCapacity
from .metrics import nrmse, squared_correlation
from .recursive_least_squares import RecursiveLeastSquares
from .ridge import fit_readout, predict_held_out

__all__ = [
    "EchoStateNetwork",
    "MemoryCapacity",
    "RecursiveLeastSquares",
    "delay_line",
    "fit_readout",
    "memory_capacity",
    "nrmse",
    "predict_held_out",
    "squared_correlation",
]
