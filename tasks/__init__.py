"""Input series and their encodings, targets, reservoirs, and the benchmark that runs the tasks on them."""

from .benchmark import run_benchmark, Score, STANDARD_RESERVOIRS, STANDARD_TASKS, summarize, Summary, table
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
from .search import Evaluation, Found, held_out_scores, search
from .space import body_space, Choice, echo_state_space, Range, Space
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
    "STANDARD_RESERVOIRS",
    "STANDARD_TASKS",
    "TASKS",
    "BodyReservoir",
    "Choice",
    "ClosedLoopTask",
    "DelayLine",
    "EchoState",
    "Evaluation",
    "Found",
    "FrictionTask",
    "Metric",
    "Problem",
    "Range",
    "Reservoir",
    "Score",
    "SeriesTask",
    "Solution",
    "Space",
    "Summary",
    "Task",
    "body_space",
    "body_states",
    "crawler_states",
    "dithered",
    "echo_state_space",
    "encode",
    "held_out_scores",
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
    "run_benchmark",
    "search",
    "sigma_delta",
    "stepper",
    "summarize",
    "table",
    "threshold",
    "waveforms",
]
