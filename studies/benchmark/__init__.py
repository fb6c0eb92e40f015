"""Tasks and measures on reservoirs over seeds, kept as they finish."""

from .attempts import run_benchmark, Score, STANDARD_RESERVOIRS, STANDARD_TASKS, summarize, Summary, table

__all__ = ["STANDARD_RESERVOIRS", "STANDARD_TASKS", "Score", "Summary", "run_benchmark", "summarize", "table"]
