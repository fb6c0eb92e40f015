"""Input streams, targets, and the benchmark that runs them on the crawler and its baselines."""

from .benchmark import run_benchmark, Score, summarize, Summary, table, TASKS
from .figures import plot_memory_profile
from .narma import narma2, narma10
from .parity import parity
from .reservoirs import body_states, crawler_and_baselines, crawler_states, RESERVOIRS
from .streams import dithered, innovation, random_bits

__all__ = [
    "RESERVOIRS",
    "TASKS",
    "Score",
    "Summary",
    "body_states",
    "crawler_and_baselines",
    "crawler_states",
    "dithered",
    "innovation",
    "narma2",
    "narma10",
    "parity",
    "plot_memory_profile",
    "random_bits",
    "run_benchmark",
    "summarize",
    "table",
]
