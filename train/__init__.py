"""Training policies with Stable-Baselines3, and what they come to beside open-loop schedules.

Nothing is imported here: torch takes seconds, and `stickslip.train.schedules` does without it. The names
below are imported on first use.
"""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from ..common.threads import library_threads
    from .vec_env import StickSlipVecEnv

_HOME = {"StickSlipVecEnv": ".vec_env", "library_threads": "..common.threads"}

__all__ = ["StickSlipVecEnv", "library_threads"]


if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name not in _HOME:
            raise AttributeError(f"module 'stickslip.train' has no attribute {name!r}")
        return getattr(import_module(_HOME[name], __name__), name)


def __dir__() -> list[str]:
    return list({*globals(), *__all__})  # `dir` sorts it
