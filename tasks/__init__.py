"""Input series and their encodings, targets, and reservoirs by name."""

from .catalogue import TASKS
from .chaos import lorenz, mackey_glass
from .closed_loop import ClosedLoopTask, stepper
from .encodings import encode, ENCODINGS, pulse_width, sigma_delta, threshold
from .figures import plot_memory_profile
from .friction import FrictionTask
from .measures import MEASURES
from .narma import narma, random_narma
from .parity import parity
from .reservoirs import (
    body_states,
    BodyReservoir,
    crawler_states,
    DelayLine,
    EchoState,
    known_reservoirs,
    Reservoir,
    RESERVOIRS,
)
from .streams import dithered, innovation, random_bits, random_uniform
from .task import ACCURACY, CAPACITY, Metric, NRMSE, Problem, SeriesTask, Solution, Task
from .waveforms import waveforms

__all__ = [
    "ACCURACY",
    "CAPACITY",
    "ENCODINGS",
    "MEASURES",
    "NRMSE",
    "RESERVOIRS",
    "TASKS",
    "BodyReservoir",
    "ClosedLoopTask",
    "DelayLine",
    "EchoState",
    "FrictionTask",
    "Metric",
    "Problem",
    "Reservoir",
    "SeriesTask",
    "Solution",
    "Task",
    "body_states",
    "crawler_states",
    "dithered",
    "encode",
    "innovation",
    "known_reservoirs",
    "lorenz",
    "mackey_glass",
    "narma",
    "parity",
    "plot_memory_profile",
    "pulse_width",
    "random_bits",
    "random_narma",
    "random_uniform",
    "sigma_delta",
    "stepper",
    "threshold",
    "waveforms",
]
