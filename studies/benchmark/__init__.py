"""Tasks and measures on reservoirs over seeds, kept as they finish.

One pipeline: attempts give records, records give estimates with intervals, and estimates give tables.
"""

from .attempts import run_benchmark, STANDARD_RESERVOIRS, STANDARD_TASKS
from .records import Record
from .report import estimates, paired_differences, table

__all__ = [
    "STANDARD_RESERVOIRS",
    "STANDARD_TASKS",
    "Record",
    "estimates",
    "paired_differences",
    "run_benchmark",
    "table",
]
