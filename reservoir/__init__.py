"""Reservoir computing on arrays: readouts, capacities, ranks, and reference reservoirs. Knows no crawler."""

from typing import Any, TYPE_CHECKING

from .bootstrap import Estimate, mean_over_runs
from .convergence import echo_state_property, EchoStateProperty
from .delay_line import delay_line
from .echo_state import EchoStateNetwork
from .information import information_processing_capacity, InformationCapacity
from .kernel import kernel_quality, KernelQuality, ranks
from .memory import memory_capacity, MemoryCapacity
from .memory_runs import memory_over_runs, MemoryOverRuns
from .metrics import nrmse, squared_correlation
from .orthonormal import state_rank
from .recursive_least_squares import RecursiveLeastSquares
from .ridge import predict_held_out
from .targets import target_series

if TYPE_CHECKING:
    from .readouts import fit_readout, RecursiveLeastSquaresReadout, RidgeReadout

__all__ = [
    "EchoStateNetwork",
    "EchoStateProperty",
    "Estimate",
    "InformationCapacity",
    "KernelQuality",
    "MemoryCapacity",
    "MemoryOverRuns",
    "RecursiveLeastSquares",
    "RecursiveLeastSquaresReadout",
    "RidgeReadout",
    "delay_line",
    "echo_state_property",
    "fit_readout",
    "information_processing_capacity",
    "kernel_quality",
    "mean_over_runs",
    "memory_capacity",
    "memory_over_runs",
    "nrmse",
    "predict_held_out",
    "ranks",
    "squared_correlation",
    "state_rank",
    "target_series",
]

_OF_SCIKIT_LEARN = ("RecursiveLeastSquaresReadout", "RidgeReadout", "fit_readout")


if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        # scikit-learn takes a second to import, and whoever only steps an environment needs none of it.
        if name in _OF_SCIKIT_LEARN:
            from . import readouts

            return getattr(readouts, name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return list({*globals(), *_OF_SCIKIT_LEARN})  # `dir` sorts it
