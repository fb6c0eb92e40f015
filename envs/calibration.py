"""The scale of what the memory readout sees: found from the body under random commands."""

import numpy as np
from numpy.typing import NDArray

from ..reservoir.prequential import PrequentialMemory
from .settings import Settings

__all__ = ["calibrated_memory", "calibration_valves"]

# Enough for the scale of each feature to a few percent; fewer where holds are long, but never fewer than the least.
_HOLDS = 2000
_TIME = 20_000.0
_LEAST = 100
_SEED = 0


def calibration_valves(settings: Settings) -> NDArray[np.int64]:
    """Random states of the valve, hold by hold."""
    affordable = int(min(_TIME / settings.hold, _HOLDS))
    return np.random.default_rng(_SEED).integers(0, 2, max(affordable, _LEAST))


def calibrated_memory(settings: Settings, states: NDArray[np.float64]) -> PrequentialMemory:
    """Memory readout that scales its features as those of a body that went through the calibration from rest.

    Parameters
    ----------
    settings : Settings
    states : (holds, features) array
        Deformations at the virtual nodes of each hold, then rates, then pressures.

    Returns
    -------
    PrequentialMemory
    """
    return PrequentialMemory(states, settings.messages, target=settings.aim)
