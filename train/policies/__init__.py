"""Trained policies as plain numbers: kept, described, run and passed on without torch, and without running their code.

Nothing is imported here: `Policy` and its files need NumPy and safetensors alone, what makes a policy of a trained
model needs Stable-Baselines3. The names below are imported on first use.
"""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from .files import read_policy, write_policy
    from .from_model import policy_of
    from .policy import Layer, Policy
    from .pretrained import pretrained

_HOME = {
    "Layer": ".policy",
    "Policy": ".policy",
    "policy_of": ".from_model",
    "pretrained": ".pretrained",
    "read_policy": ".files",
    "write_policy": ".files",
}

__all__ = ["Layer", "Policy", "policy_of", "pretrained", "read_policy", "write_policy"]


if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name not in _HOME:
            raise AttributeError(f"module 'stickslip.train.policies' has no attribute {name!r}")
        return getattr(import_module(_HOME[name], __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
