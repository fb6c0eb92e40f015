"""The Gymnasium environment for a body that computes.

Importing this package registers its environments and nothing else: the compiled solver, scikit-learn, torch and
matplotlib are imported by the parts that use them. The names below are imported on first use.
"""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from .crawler import (
        Actuator,
        EnergyWarning,
        Groups,
        lyapunov_spectrum,
        LyapunovSpectrum,
        Scene,
        Sensitivities,
        sensitivities,
        simulate,
        SlipWarning,
        Trajectory,
    )
    from .reservoir import memory_capacity
    from .studies.identification import identify
    from .studies.maps import parameter_map
    from .tasks.transformer import CrawlerReservoir
    from .train.policies.pretrained import pretrained

__version__ = "0.2.0"

_HOME = {
    "Actuator": "stickslip.crawler",
    "CrawlerReservoir": "stickslip.tasks.transformer",
    "EnergyWarning": "stickslip.crawler",
    "Groups": "stickslip.crawler",
    "LyapunovSpectrum": "stickslip.crawler",
    "Scene": "stickslip.crawler",
    "Sensitivities": "stickslip.crawler",
    "SlipWarning": "stickslip.crawler",
    "Trajectory": "stickslip.crawler",
    "sensitivities": "stickslip.crawler",
    "simulate": "stickslip.crawler",
    "identify": "stickslip.studies.identification",
    "lyapunov_spectrum": "stickslip.crawler",
    "memory_capacity": "stickslip.reservoir",
    "parameter_map": "stickslip.studies.maps",
    "pretrained": "stickslip.train.policies.pretrained",
}

_REQUIRED = ("gymnasium", "numba", "scipy", "sklearn", "joblib")
"""What an installation without dependencies lacks, which is enough to run a policy."""

__all__ = [
    "Actuator",
    "CrawlerReservoir",
    "EnergyWarning",
    "Groups",
    "LyapunovSpectrum",
    "Scene",
    "Sensitivities",
    "SlipWarning",
    "Trajectory",
    "__version__",
    "identify",
    "lyapunov_spectrum",
    "memory_capacity",
    "parameter_map",
    "pretrained",
    "sensitivities",
    "simulate",
]


def _register() -> None:
    try:
        from gymnasium.envs.registration import register
    except ModuleNotFoundError as missing:
        if missing.name != "gymnasium":
            raise
        return  # a robot runs policies, and has no environments
    register(
        id="StickSlipCrawler-v0",
        entry_point="stickslip.envs:StickSlipCrawlerEnv",
        vector_entry_point="stickslip.envs:StickSlipCrawlerVectorEnv",
        max_episode_steps=1000,
    )
    register(
        id="StickSlipCrawlerMO-v0",
        entry_point="stickslip.envs:StickSlipCrawlerMOEnv",
        vector_entry_point="stickslip.envs:StickSlipCrawlerMOVectorEnv",
        max_episode_steps=1000,
        disable_env_checker=True,  # which takes a vector of rewards for a fault
    )


_register()


# Hidden from type checkers, to whom every name would be known, and of any type.
if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name not in _HOME:
            raise AttributeError(f"module 'stickslip' has no attribute {name!r}")
        try:
            return getattr(import_module(_HOME[name]), name)
        except ModuleNotFoundError as missing:
            if missing.name not in _REQUIRED:
                raise
            raise ModuleNotFoundError(
                f"stickslip.{name} needs {missing.name}, which is not installed: run `pip install stickslip` without "
                "--no-deps",
                name=missing.name,
            ) from missing


def __dir__() -> list[str]:
    return list({*globals(), *__all__})  # `dir` sorts it
