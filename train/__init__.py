"""Training policies with Stable-Baselines3, and what they come to beside open-loop schedules.

Nothing is imported here: torch takes seconds, and `stickslip.train.schedules` does without it. The name
below is imported on first use.
"""

from importlib import import_module
from typing import Any

__all__ = ["StickSlipVecEnv"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'stickslip.train' has no attribute {name!r}")
    return getattr(import_module(".vec_env", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
