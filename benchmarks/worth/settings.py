"""Tolerances, their names, and the defaults that are on trial."""

import inspect

from stickslip.crawler import simulate
from stickslip.envs import StickSlipCrawlerEnv

__all__ = ["ALL", "ENVIRONMENT_DEFAULT", "REFERENCE", "SIMULATE_DEFAULT", "TOLERANCES", "name_of"]

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12, 1e-14)
REFERENCE = 1e-15
ALL = (*TOLERANCES, REFERENCE)

SIMULATE_DEFAULT: float = inspect.signature(simulate).parameters["tolerance"].default
ENVIRONMENT_DEFAULT: float = inspect.signature(StickSlipCrawlerEnv.__init__).parameters["tolerance"].default


def name_of(tolerance: float) -> str:
    """How a tolerance is written in keys and tables, such as 1e-06."""
    return f"{tolerance:.0e}"
